// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>

#include "base/thrown_message.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/error.h"
#include "two_triangles.h"

namespace mscomp {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

const std::vector<Point> kPlyPoints{{0, 0, 0}, {1, 0.5, 0}, {1, 1, -2}, {0, 1, 0}};

const std::string kHeader =
    "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 4\nproperty float x\nproperty float "
    "y\nproperty float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n";
const std::string kData = "0 0 0\n1 0.5 0\n1 1 -2\n0 1 0\n3 0 1 2\n3 0 2 3\n";

std::string ply_message(const std::string& bytes) {
    return thrown_message<InputError>([&] { parse_ply(bytes, "a.ply"); });
}

void expect_the_mesh(const std::string& bytes) {
    const TriangleMesh mesh = parse_ply(bytes, "a.ply");
    EXPECT_EQ(mesh.vertices, kPlyPoints);
    EXPECT_EQ(mesh.faces, kFaces);
}

/// Bytes of a number in the byte order asked for.
template <class T>
std::string bytes_of(double value, bool big) {
    const T number = static_cast<T>(value);
    std::string raw(sizeof(T), '\0');
    std::memcpy(raw.data(), &number, sizeof(T));
    if (big) std::reverse(raw.begin(), raw.end());
    return raw;
}

template <class Coordinate, class Count, class Index>
std::string binary(const std::string& coordinate, const std::string& count,
                   const std::string& index, bool big) {
    std::string bytes = "ply\nformat binary_" + std::string(big ? "big" : "little") +
                        "_endian 1.0\nelement vertex 4\nproperty " + coordinate + " x\nproperty " +
                        coordinate + " y\nproperty " + coordinate +
                        " z\nelement face 2\nproperty list " + count + " " + index +
                        " vertex_index\nend_header\n";
    for (const Point& point : kPlyPoints) {
        for (const double x : point) bytes += bytes_of<Coordinate>(x, big);
    }
    for (const Face& face : kFaces) {
        bytes += bytes_of<Count>(3, big);
        for (const int corner : face) bytes += bytes_of<Index>(corner, big);
    }
    return bytes;
}

TEST(PlyReader, ReadsAscii) { expect_the_mesh(kHeader + kData); }

TEST(PlyReader, ReadsBinaryOfEitherByteOrderAndAnyType) {
    for (const bool big : {false, true}) {
        expect_the_mesh(binary<float, std::uint8_t, std::int32_t>("float", "uchar", "int", big));
        expect_the_mesh(binary<double, std::int32_t, std::uint32_t>("double", "int", "uint", big));
        expect_the_mesh(
            binary<double, std::uint16_t, std::int16_t>("float64", "uint16", "int16", big));
        expect_the_mesh(binary<float, std::int8_t, std::uint8_t>("float32", "int8", "uint8", big));
    }
}

TEST(PlyReader, ReadsWholeNumbersAsCoordinates) {
    const std::string header =
        "ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty short x\nproperty char "
        "y\nproperty uint z\nelement face 1\nproperty list uchar uchar "
        "vertex_indices\nend_header\n";
    std::string data;
    for (int i = 0; i < 3; ++i) {
        data += bytes_of<std::int16_t>(-300 + i, true) + bytes_of<std::int8_t>(-i, true) +
                bytes_of<std::uint32_t>(4e9, true);
    }
    const TriangleMesh mesh =
        parse_ply(header + data + std::string("\x03\x00\x01\x02", 4), "a.ply");
    EXPECT_EQ(mesh.vertices,
              (std::vector<Point>{{-300, 0, 4e9}, {-299, -1, 4e9}, {-298, -2, 4e9}}));
}

TEST(PlyReader, AcceptsHarmlessVariants) {
    const std::string plain = kHeader + kData;
    expect_the_mesh(replaced(plain, "\n", "\r\n"));
    expect_the_mesh(replaced(plain, "\n", "\r"));
    expect_the_mesh(plain.substr(0, plain.size() - 1));
    expect_the_mesh(plain + "\n \n");
    expect_the_mesh(kHeader + replaced(kData, "\n", " \n\n"));
    expect_the_mesh(replaced(plain, "comment by hand\n", "obj_info x\ncomment\n\n"));
    expect_the_mesh(replaced(plain, "3 0 1 2\n3 0 2 3\n", "4 0 1 2 3\n")
                        .replace(plain.find("face 2") + 5, 1, "1"));
}

// Some programs break lines at a width, not at elements. What is no stream of the promised numbers
// either is reported as lines.
TEST(PlyReader, ReadsRowsThatBreakAnywhere) {
    expect_the_mesh(kHeader + replaced(kData, "\n", " "));
    expect_the_mesh(kHeader + replaced(kData, " ", "\n"));
    expect_the_mesh(kHeader +
                    replaced(replaced(kData, "1 0.5", "1\r\n0.5"), "3 0 2 3\n", "3 0\n2 3"));
    EXPECT_THAT(ply_message(kHeader + replaced(kData, "0 1 0\n3 ", "0 1 0 3 ") + "7\n"),
                StartsWith("a.ply:14:7: "));
}

// After a header with Windows line ends the first data byte may well be a line feed.
TEST(PlyReader, FindsTheStartOfBinaryDataForEveryLineEnd) {
    const std::string sound =
        binary<float, std::uint8_t, std::int32_t>("float", "uchar", "int", false);
    const std::size_t data = sound.find("end_header\n") + 11;
    for (const char* line_end : {"\n", "\r\n", "\r"}) {
        std::string bytes = replaced(sound.substr(0, data), "\n", line_end) + sound.substr(data);
        const std::size_t first = bytes.size() - (sound.size() - data);
        bytes[first] = '\n';
        const TriangleMesh mesh = parse_ply(bytes, "a.ply");
        EXPECT_EQ(mesh.vertices[1], kPlyPoints[1]);
        EXPECT_EQ(mesh.faces, kFaces);
    }
}

TEST(PlyReader, SkipsOtherPropertiesAndElements) {
    expect_the_mesh(
        "ply\nformat ascii 1.0\nelement camera 1\nproperty list uchar float matrix\nproperty int "
        "n\nelement vertex 4\nproperty float nx\nproperty double z\nproperty double x\nproperty "
        "list uchar int tags\nproperty double y\nproperty uchar red\nelement material 0\nproperty "
        "float shine\nelement face 2\nproperty uchar flag\nproperty list uchar int "
        "vertex_indices\nproperty list uchar float texcoord\nelement nothing 99999999\nend_header\n"
        "2 0.5 1.5 7\n"
        "nan 0 0 0 0 255\n1 0 1 2 8 9 0.5 255\n0 -2 1 0 1 255\n0 0 0 1 5 1 255\n"
        "9 3 0 1 2 0\n9 3 0 2 3 2 0.1 0.2\n");
}

struct BadPly {
    std::string name;
    std::string bytes;
    std::string start;
    std::vector<std::string> parts;
};
void PrintTo(const BadPly& bad, std::ostream* out) { *out << bad.name; }
std::string ply_case_name(const testing::TestParamInfo<BadPly>& info) { return info.param.name; }

class RefusedPly : public testing::TestWithParam<BadPly> {};

TEST_P(RefusedPly, SaysWhereWhatWasGotAndWhatWasExpected) {
    const std::string message = ply_message(GetParam().bytes);
    EXPECT_THAT(message, StartsWith(GetParam().start));
    for (const std::string& part : GetParam().parts) EXPECT_THAT(message, HasSubstr(part));
}

std::string with_header(const std::string& from, const std::string& to) {
    return replaced(kHeader, from, to) + kData;
}
std::string with_data(const std::string& from, const std::string& to) {
    return kHeader + replaced(kData, from, to);
}
std::string with_patch(std::size_t from_end, const std::string& patch) {
    std::string bytes = binary<float, std::uint8_t, std::int32_t>("float", "uchar", "int", false);
    return bytes.replace(bytes.size() - from_end, patch.size(), patch);
}
// Sizes of the binary sample: 4 vertices of 12 bytes, 2 faces of 13.
constexpr std::size_t kFaceBytes = 13;
constexpr std::size_t kDataBytes = 4 * 12 + 2 * kFaceBytes;

INSTANTIATE_TEST_SUITE_P(
    Kinds, RefusedPly,
    testing::Values(
        BadPly{"Empty", "", "a.ply: ", {"empty"}},
        BadPly{"NotPly", "solid cube\n", "a.ply:1: ", {"'solid cube'", "'ply'"}},
        BadPly{"HeaderCut", kHeader.substr(0, 40), "a.ply:", {"within the header", "end_header"}},
        BadPly{"NoFormat", with_header("format ascii 1.0\n", ""), "a.ply:9: ", {"'format'"}},
        BadPly{"UnknownFormat",
               with_header("ascii", "text"),
               "a.ply:2: ",
               {"'format text 1.0'", "binary_little_endian"}},
        BadPly{
            "UnknownLine", with_header("comment", "remark"), "a.ply:3: ", {"'remark'", "element"}},
        BadPly{"UnknownType", with_header("float y", "real y"), "a.ply:6: ", {"'real'", "float"}},
        BadPly{"CountNotANumber", with_header("vertex 4", "vertex four"), "a.ply:4: ", {"count"}},
        BadPly{"NegativeCount", with_header("vertex 4", "vertex -4"), "a.ply:4: ", {"count"}},
        BadPly{"PropertyBeforeElement",
               with_header("comment by hand", "property float w"),
               "a.ply:3: ",
               {"element"}},
        BadPly{"FloatAsListCount",
               with_header("list uchar", "list float"),
               "a.ply:9: ",
               {"'float'", "integer"}},
        BadPly{"HostileVertexCount",
               with_header("vertex 4", "vertex 4000000000000"),
               "a.ply:4: ",
               {"4000000000000", "'vertex'", "truncated"}},
        BadPly{"OverflowingCount",
               with_header("face 2", "face 9223372036854775807"),
               "a.ply:8: ",
               {"9223372036854775807"}},
        BadPly{
            "NoFaceElement", with_header("element face", "element facet"), "a.ply: ", {"'face'"}},
        BadPly{"NoCorners",
               with_header("vertex_indices", "corners"),
               "a.ply:8: ",
               {"vertex_indices", "vertex_index"}},
        BadPly{"NoZ", with_header("float z", "float w"), "a.ply:4: ", {"'z'"}},
        BadPly{"TwoX", with_header("float y", "float x"), "a.ply:4: ", {"2 properties 'x'"}},
        BadPly{"NoVertices", replaced(kHeader, "vertex 4", "vertex 0"), "a.ply:", {}},
        BadPly{"NoFaces",
               replaced(kHeader, "face 2", "face 0") + kData.substr(0, kData.find("3 0")),
               "a.ply:8: ",
               {"no faces"}},
        BadPly{"NotANumber", with_data("1 0.5 0", "1 nan 0"), "a.ply:12:", {"coordinate y", "nan"}},
        BadPly{"DecimalComma", with_data("0.5", "0,5"), "a.ply:12:3: ", {"'0,5'", "decimal comma"}},
        BadPly{"Word", with_data("0.5", "half"), "a.ply:12:3: ", {"'half'"}},
        BadPly{"ShortLine",
               with_data("1 0.5 0", "1 0.5"),
               "a.ply:12:6: ",
               {"ends before vertex coordinate z"}},
        BadPly{"LongLine", with_data("1 0.5 0", "1 0.5 0 7"), "a.ply:12:9: ", {"'7'"}},
        BadPly{"FaceCut", with_data("3 0 2 3", "3 0 2"), "a.ply:16:6: ", {"corner"}},
        BadPly{"ByteOrderMarkBehindTheHeader",
               kHeader + "\xEF\xBB\xBF" + kData,
               "a.ply:11:1: ",
               {"'0' behind a byte order mark"}},
        BadPly{"FractionAsCorner", with_data("3 0 2 3", "3 0 2.5 3"), "a.ply:16:5: ", {"'2.5'"}},
        BadPly{"CornerOutOfRange",
               with_data("3 0 2 3", "3 0 2 4"),
               "a.ply:16:",
               {"vertex 4, the file has 4"}},
        BadPly{"NegativeCorner", with_data("3 0 2 3", "3 0 2 -1"), "a.ply:16:", {"vertex -1"}},
        BadPly{
            "HostileList", with_data("3 0 2 3", "2000000000 0 2 3"), "a.ply:16:", {"2000000000"}},
        BadPly{"MissingRow",
               kHeader + kData.substr(0, kData.rfind("3 0")),
               "a.ply:16:",
               {"1 of 2 elements 'face'"}},
        BadPly{
            "RowsLeft", kHeader + kData + "3 0 1 3\n", "a.ply:17:1: ", {"'3'", "end of the file"}},
        BadPly{"BinaryNotANumber",
               with_patch(kDataBytes - 12,
                          bytes_of<float>(std::numeric_limits<float>::infinity(), false)),
               "a.ply: vertex 2 of 4 ",
               {"coordinate x", "inf"}},
        BadPly{"BinaryCornerOutOfRange",
               with_patch(4, bytes_of<std::int32_t>(77, false)),
               "a.ply: face 2 of 2 ",
               {"vertex 77, the file has 4"}},
        BadPly{"BinaryListBeyondTheEnd",
               with_patch(kFaceBytes, "\xc8"),
               "a.ply: face 2 of 2 ",
               {"200"}},
        BadPly{"BinaryRowsLeft", with_patch(4, std::string(5, '\1')), "a.ply: face 2 of 2 ", {}}),
    ply_case_name);

TEST(PlyReader, EveryTruncationOfABinaryFileIsNoticed) {
    const std::string sound =
        binary<float, std::uint8_t, std::int32_t>("float", "uchar", "int", true);
    for (std::size_t size = 0; size < sound.size(); ++size) {
        EXPECT_THAT(ply_message(sound.substr(0, size)), StartsWith("a.ply:"));
    }
    EXPECT_THAT(ply_message(sound + "xy"),
                AllOf(HasSubstr("2 bytes"), HasSubstr("end of the file")));
}

TEST(PlyReader, SurvivesEveryAlteredByte) {
    const std::string sound =
        binary<float, std::uint8_t, std::int32_t>("float", "uchar", "int", false);
    for (const std::string& text : {sound, kHeader + kData}) {
        for (std::size_t at = 0; at < text.size(); ++at) {
            for (const char c : {'\0', '\xff', '9', ' ', '\n'}) {
                std::vector<char> exact(text.begin(), text.end());
                exact[at] = c;
                try {
                    parse_ply({exact.data(), exact.size()}, "a.ply");
                } catch (const InputError& error) {
                    EXPECT_THAT(error.what(), StartsWith("a.ply:"));
                }
            }
        }
    }
}

}  // namespace
}  // namespace mscomp
