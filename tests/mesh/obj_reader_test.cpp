// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <charconv>
#include <chrono>
#include <csignal>
#include <fstream>
#include <limits>
#include <thread>

#include "base/temporary_folder.h"
#include "base/thrown_message.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/error.h"
#include "mscomp/base/interruption.h"
#include "mscomp/base/random.h"
#include "two_triangles.h"

namespace mscomp {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

const std::string kPlain = "v 0 0 0\nv 1 0.5 0\nv 1 1 -2e-3\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";

std::string obj_message(const std::string& text) {
    return thrown_message<InputError>([&] { parse_obj(text, "a.obj"); });
}

struct Variant {
    std::string name;
    std::string text;
};
void PrintTo(const Variant& variant, std::ostream* out) { *out << variant.name; }
template <class Case>
std::string case_name(const testing::TestParamInfo<Case>& info) {
    return info.param.name;
}

class HarmlessObj : public testing::TestWithParam<Variant> {};

TEST_P(HarmlessObj, GivesTheSameMesh) {
    const TriangleMesh mesh = parse_obj(GetParam().text, "a.obj");
    EXPECT_EQ(mesh.vertices, kPoints);
    EXPECT_EQ(mesh.faces, kFaces);
}

INSTANTIATE_TEST_SUITE_P(
    Variants, HarmlessObj,
    testing::Values(
        Variant{"Plain", kPlain}, Variant{"ByteOrderMark", "\xEF\xBB\xBF" + kPlain},
        Variant{"WindowsLineEnds", replaced(kPlain, "\n", "\r\n")},
        Variant{"OldMacLineEnds", replaced(kPlain, "\n", "\r")},
        Variant{"NoLastLineEnd", kPlain.substr(0, kPlain.size() - 1)},
        Variant{"TabsAndTrailingBlanks", replaced(replaced(kPlain, " ", "\t "), "\n", " \t\n")},
        Variant{"Indented", "  " + replaced(kPlain, "\n", "\n\t")},
        Variant{"BlankLines", "\n\n" + replaced(kPlain, "\n", "\n \n")},
        Variant{"Continuation",
                replaced(replaced(kPlain, "f 1 3", "f 1 \\\n 3"), "v 1 1", "v \\\r\n1 1")},
        Variant{"ContinuationWithoutBlank", replaced(kPlain, "f 1 3 4", "f 1 3\\\n 4")},
        Variant{"TextureCorners", replaced(replaced(kPlain, "f 1 2 3", "f 1/1 2/2 3/3"), "f 1 3 4",
                                           "f 1/1/9 3/2/8 4/-1/-7")},
        Variant{"NormalCorners", replaced(kPlain, "f 1 2 3", "f 1//1 2//-2 3//3")},
        Variant{"EmptyParts", replaced(kPlain, "f 1 2 3", "f 1/ 2// 3")},
        Variant{"NegativeIndices",
                replaced(replaced(kPlain, "f 1 2 3", "f -4 -3 -2"), "f 1 3 4", "f 1 -2 4")},
        Variant{"Quad", replaced(kPlain, "f 1 2 3\nf 1 3 4\n", "f 1 2 3 4\n")},
        Variant{"Weights", replaced(kPlain, "v 1 0.5 0", "v 1 0.5 0 1.0")},
        Variant{"Colors", replaced(kPlain, "v 1 0.5 0", "v 1 0.5 0 0.1 0.2 0.3 1")},
        Variant{"Comments",
                "# made by hand\n#\n" + replaced(kPlain, "v 1 0.5 0", "v 1 0.5 0 # here")},
        Variant{"CommentEndingInABackslash", "# in C:\\\n" + kPlain},
        Variant{"OtherKeywords",
                "mtllib a.mtl\no body\ng left arm\ns off\nusemtl red\nvt 0 0\nvn 0 0 1\nvp 1\nl 1 "
                "2\np 1\n" +
                    kPlain},
        Variant{"ContinuedOtherKeyword", "g one \\\ntwo\n" + kPlain},
        Variant{"FacesFirst", kPlain.substr(kPlain.find('f')) + kPlain.substr(0, kPlain.find('f'))},
        Variant{"NegativeIndicesBetweenVertices",
                "v 0 0 0\nv 1 0.5 0\nv 1 1 -2e-3\nf -3 -2 -1\nv 0 1 0\nf -4 -2 -1\n"},
        Variant{"OtherSpellingsOfNumbers",
                replaced(replaced(kPlain, "0.5", "+5.E-1"), "-2e-3", "-.002")},
        Variant{"TooSmallForADouble", replaced(kPlain, "v 0 0 0", "v 1e-400 -0 0.0e5")}),
    case_name<Variant>);

struct BadObj {
    std::string name;
    std::string text;
    std::string start;
    std::vector<std::string> parts;
};
void PrintTo(const BadObj& bad, std::ostream* out) { *out << bad.name; }

class RefusedObj : public testing::TestWithParam<BadObj> {};

TEST_P(RefusedObj, SaysWhereWhatWasGotAndWhatWasExpected) {
    const std::string message = obj_message(GetParam().text);
    EXPECT_THAT(message, StartsWith(GetParam().start));
    for (const std::string& part : GetParam().parts) EXPECT_THAT(message, HasSubstr(part));
}

std::string with_first_vertex(const std::string& line) { return replaced(kPlain, "v 0 0 0", line); }
std::string with_first_face(const std::string& line) { return replaced(kPlain, "f 1 2 3", line); }

INSTANTIATE_TEST_SUITE_P(
    Kinds, RefusedObj,
    testing::Values(
        BadObj{"NotANumber",
               with_first_vertex("v 0 nan 0"),
               "a.obj:1:5: ",
               {"coordinate y", "'nan'", "finite number"}},
        BadObj{"Infinity",
               with_first_vertex("v 0 0 -inf"),
               "a.obj:1:7: ",
               {"coordinate z", "'-inf'", "finite number"}},
        BadObj{"BeyondDouble", with_first_vertex("v 1e999 0 0"), "a.obj:1:3: ", {"'1e999'"}},
        BadObj{"DecimalComma",
               with_first_vertex("v 0,5 0,25 1"),
               "a.obj:1:3: ",
               {"'0,5'", "decimal comma", "decimal point"}},
        BadObj{"CommaAfterNumber",
               with_first_vertex("v 0, 5, 1"),
               "a.obj:1:3: ",
               {"'0,'", "expected a number"}},
        BadObj{"Word",
               with_first_vertex("v 0 zero 0"),
               "a.obj:1:5: ",
               {"'zero'", "expected a number"}},
        BadObj{"NumberWithTail", with_first_vertex("v 0 1.5x 0"), "a.obj:1:5: ", {"'1.5x'"}},
        BadObj{"TwoPoints", with_first_vertex("v 0 1.5.2 0"), "a.obj:1:5: ", {"'1.5.2'"}},
        BadObj{"HalfAnExponent", with_first_vertex("v 0 1e 0"), "a.obj:1:5: ", {"'1e'"}},
        BadObj{"SignsWithoutEnd", with_first_vertex("v 0 +-1 0"), "a.obj:1:5: ", {"'+-1'"}},
        BadObj{"Hexadecimal", with_first_vertex("v 0 0x1p3 0"), "a.obj:1:5: ", {"'0x1p3'"}},
        BadObj{"GarbageAfterVertex",
               with_first_vertex("v 0 0 0 abc"),
               "a.obj:1:9: ",
               {"after the vertex", "'abc'"}},
        BadObj{"TruncatedVertex",
               with_first_vertex("v 1 2"),
               "a.obj:1:6: ",
               {"2 coordinates", "expected 3"}},
        BadObj{
            "VertexWithoutCoordinates", with_first_vertex("v"), "a.obj:1:2: ", {"0 coordinates"}},
        BadObj{
            "VertexCommentedOut", with_first_vertex("v 1 2 # 3"), "a.obj:1:7: ", {"2 coordinates"}},
        BadObj{"FaceCutOff", kPlain + "f 1 2", "a.obj:7:6: ", {"2 corners", "expected at least 3"}},
        BadObj{"IndexBeyondTheEnd",
               with_first_face("f 1 2 9001"),
               "a.obj:5:7: ",
               {"face refers to vertex 9001, the file has 4"}},
        BadObj{"FirstOfSeveralIndicesBeyondTheEnd",
               replaced(with_first_face("f 1 4 7"), "f 1 3 4", "f 1 3 9001"),
               "a.obj:5:7: ",
               {"vertex 7, the file has 4"}},
        BadObj{"HugeIndex",
               with_first_face("f 1 2 99999999999999999999999"),
               "a.obj:5:7: ",
               {"the file has 4"}},
        BadObj{"IndexBeyondTheEndBeforeTheVertices",
               "f 1 2 3\nf 1 2 5\n" + kPlain,
               "a.obj:2:7: ",
               {"vertex 5, the file has 4"}},
        BadObj{"NegativeIndexBeforeTheFirst",
               with_first_face("f -5 1 2"),
               "a.obj:5:3: ",
               {"vertex -5", "only 4"}},
        BadObj{"NegativeIndexToALaterVertex",
               "v 0 0 0\nv 1 0 0\nf 1 2 -3\nv 1 1 0\n",
               "a.obj:3:7: ",
               {"vertex -3", "only 2"}},
        BadObj{"ZeroIndex", with_first_face("f 0 1 2"), "a.obj:5:3: ", {"vertex 0", "1 or more"}},
        BadObj{"FractionAsIndex", with_first_face("f 1 2.5 3"), "a.obj:5:5: ", {"'2.5'", "index"}},
        BadObj{"WordAsIndex", with_first_face("f 1 two 3"), "a.obj:5:5: ", {"'two'", "index"}},
        BadObj{"WordAsTextureIndex", with_first_face("f 1 2/x 3"), "a.obj:5:5: ", {"'2/x'"}},
        BadObj{"ThreeSlashes", with_first_face("f 1 2/1/1/1 3"), "a.obj:5:5: ", {"'2/1/1/1'"}},
        BadObj{"LoneSlash", with_first_face("f 1 /2 3"), "a.obj:5:5: ", {"'/2'"}},
        BadObj{"AnotherKindOfText",
               "vertex 1 2 3\n",
               "a.obj:1:1: ",
               {"'vertex'", "expected v, f", "vt", "usemtl"}},
        BadObj{"ByteOrderMarkInside",
               kPlain + "\xEF\xBB\xBF" + kPlain,
               "a.obj:7:1: ",
               {"byte order mark", "'v'"}},
        BadObj{"NulLine", kPlain + std::string(3, '\0') + "\n" + kPlain, "a.obj:7:1: ", {"\\x00"}},
        BadObj{"UpperCaseKeyword", with_first_vertex("V 0 0 0"), "a.obj:1:1: ", {"'V'"}},
        BadObj{"KeywordGluedToNumber", with_first_vertex("v1 0 0"), "a.obj:1:1: ", {"'v1'"}},
        BadObj{"BinaryGarbage",
               std::string("\x01\x02\x00zz\n", 6) + kPlain,
               "a.obj:1:1: ",
               {"'\\x01\\x02\\x00zz'"}},
        BadObj{"Empty", "", "a.obj: ", {"empty"}},
        BadObj{"OnlyComments", "# nothing\n\n", "a.obj: ", {"no vertices", "expected"}},
        BadObj{"NoFaces",
               kPlain.substr(0, kPlain.find('f')),
               "a.obj: ",
               {"4 vertices but no faces", "expected"}},
        BadObj{"AfterAContinuation", with_first_face("f 1 \\\n2 \\\nx"), "a.obj:7:1: ", {"'x'"}}),
    case_name<BadObj>);

TEST(ObjReader, CountsWindowsAndOldMacLinesAlike) {
    const std::string bad = kPlain + "f 1 2 x\n";
    EXPECT_THAT(obj_message(bad), StartsWith("a.obj:7:7: "));
    EXPECT_THAT(obj_message(replaced(bad, "\n", "\r\n")), StartsWith("a.obj:7:7: "));
    EXPECT_THAT(obj_message(replaced(bad, "\n", "\r")), StartsWith("a.obj:7:7: "));
}

TEST(ObjReader, LongTokensAreCutInMessages) {
    const std::string message = obj_message("v 0 0 " + std::string(100000, 'z'));
    EXPECT_LT(message.size(), 200u);
}

TEST(ObjReader, SplitsPolygonsFromTheirLowestCorner) {
    const TriangleMesh mesh =
        parse_obj("v 0 0 0\nv 1 0 0\nv 2 1 0\nv 1 2 0\nv 0 1 0\nf 3 4 5 1 2\n", "a.obj");
    EXPECT_EQ(mesh.faces, (std::vector<Face>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}));
}

TEST(ObjReader, KeepsVerticesThatAreEqualOrUnused) {
    const TriangleMesh mesh =
        parse_obj("v 1 1 1\nv 0 0 0\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 2 4 5\n", "a.obj");
    EXPECT_EQ(mesh.vertex_count(), 5);
    EXPECT_EQ(mesh.faces, (std::vector<Face>{{1, 3, 4}}));
}

// The nearest double, as the standard library finds it, for any number of digits.
TEST(ObjReader, ReadsEveryNumberToTheNearestDouble) {
    const CounterRandom random(11, 0);
    std::vector<std::string> texts{"0.1",
                                   "9007199254740993",
                                   "9007199254740992.5",
                                   "0.30000000000000004",
                                   "123456789012345678901234567890",
                                   "1.7976931348623157e308",
                                   "5e-324",
                                   "2.2250738585072011e-308",
                                   "0.000000000000000000000000123",
                                   "1e22",
                                   "1e23"};
    for (std::uint64_t i = 0; i < 20000; ++i) {
        const int digits = static_cast<int>(random.bits(3 * i) % 22);
        char text[64];
        const double value = (random.uniform(3 * i + 1) - 0.5) *
                             std::ldexp(1.0, static_cast<int>(random.bits(3 * i + 2) % 60) - 30);
        const auto format = i % 2 == 0 ? std::chars_format::fixed : std::chars_format::general;
        const auto end = std::to_chars(text, text + 64, value, format, digits).ptr;
        texts.emplace_back(text, end);
    }
    for (const std::string& text : texts) {
        double expected = 0;
        std::from_chars(text.data(), text.data() + text.size(), expected);
        const TriangleMesh mesh = parse_obj("v " + text + " 0 0\nf 1 1 1\n", "a.obj");
        EXPECT_EQ(mesh.vertices[0][0], expected) << text;
        EXPECT_EQ(std::signbit(mesh.vertices[0][0]), std::signbit(expected)) << text;
    }
}

// The nearest double to what no double can hold is zero, with the sign it has.
TEST(ObjReader, ReadsWhatIsTooSmallAsZeroOfItsSign) {
    const auto read = [](const std::string& text) {
        return parse_obj("v " + text + " 0 0\nf 1 1 1\n", "a.obj").vertices[0][0];
    };
    for (const std::string& text : {std::string("1e-400"), std::string("1e-5000"),
                                    std::string("2e-324"), "0." + std::string(400, '0') + "1"}) {
        EXPECT_EQ(read(text), 0) << text;
        EXPECT_FALSE(std::signbit(read(text))) << text;
        EXPECT_EQ(read("-" + text), 0) << text;
        EXPECT_TRUE(std::signbit(read("-" + text))) << text;
    }
    EXPECT_THAT(obj_message("v 1e5000 0 0\nf 1 1 1\n"), HasSubstr("not beyond 1.8e308"));
}

// However a file is cut, the outcome is an error with its name or a mesh: never a crash.
TEST(ObjReader, SurvivesEveryTruncationAndEveryAlteredByte) {
    for (std::size_t at = 0; at < kPlain.size(); ++at) {
        std::vector<std::string> texts{kPlain.substr(0, at)};
        for (const char c : {'\0', '\\', '/', '-', 'e', '\r', '#', '\xff'}) {
            texts.push_back(kPlain);
            texts.back()[at] = c;
        }
        for (const std::string& text : texts) {
            try {
                // A copy of exactly its size, so that reading beyond the end is seen by a
                // sanitizer.
                const std::vector<char> exact(text.begin(), text.end());
                const TriangleMesh mesh = parse_obj({exact.data(), exact.size()}, "a.obj");
                for (const Face& face : mesh.faces) {
                    for (const int corner : face) {
                        EXPECT_GE(corner, 0);
                        EXPECT_LT(corner, mesh.vertex_count());
                    }
                }
            } catch (const InputError& error) {
                EXPECT_THAT(error.what(), StartsWith("a.obj:"));
            }
        }
    }
}

TEST(ReadMesh, ChoosesTheReaderByTheExtension) {
    const TemporaryFolder folder;
    EXPECT_EQ(read_mesh(folder.put("a.OBJ", kPlain)).vertices, kPoints);
    EXPECT_THAT(thrown_message<InputError>([&] { read_mesh(folder.put("a.stl", kPlain)); }),
                AllOf(HasSubstr("a.stl"), HasSubstr("'.stl'"), HasSubstr(".obj, .ply or .off")));
    EXPECT_THAT(thrown_message<IoError>([&] { read_mesh(folder / "nowhere.obj"); }),
                HasSubstr("nowhere.obj"));
}

// A pipe does not say how much comes.
TEST(ReadMesh, ReadsFromAPipe) {
    const TemporaryFolder folder;
    const std::string path = folder / "a.obj";
    ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
    std::string text;
    for (int i = 0; i < 40000; ++i) text += "v " + std::to_string(i) + " 0 0\n";
    std::thread writer([&] { std::ofstream(path, std::ios::binary) << text << "f 1 2 40000\n"; });
    const TriangleMesh mesh = read_mesh(path);
    writer.join();
    ASSERT_EQ(mesh.vertex_count(), 40000);
    for (int i = 0; i < 40000; ++i) {
        ASSERT_EQ(mesh.vertices[static_cast<std::size_t>(i)],
                  (Point{static_cast<double>(i), 0, 0}));
    }
    EXPECT_EQ(mesh.faces, (std::vector<Face>{{0, 1, 39999}}));
}

TEST(ReadMesh, WaitsAtAPipeNoLongerThanUntilAStopIsRequested) {
    const TemporaryFolder folder;
    const std::string path = folder / "a.obj";
    ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
    std::thread signal([] {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        request_stop(SIGTERM);
    });
    EXPECT_THROW(read_mesh(path), Interrupted);
    signal.join();
    request_stop(0);
}

TEST(ReadMesh, RefusesAFolder) {
    const TemporaryFolder folder;
    std::filesystem::create_directories(folder / "a.obj");
    EXPECT_EQ(thrown_message<IoError>([&] { read_mesh(folder / "a.obj"); }),
              (folder / "a.obj") + ": is a folder, wanted a file");
}

}  // namespace
}  // namespace mscomp
