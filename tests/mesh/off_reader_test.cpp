// SPDX-License-Identifier: MIT
// Beyond the tiny files of tests/mesh/files: what holds for every cut and every altered byte.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "base/thrown_message.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/error.h"

namespace mscomp {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

const std::string kPlain =
    "OFF\n4 2 5\n0 0 0\n1 0.5 0\n1 1 -2e-3\n0 1 0\n3 0 1 2\n3 0 2 3 255 0 0\n";
const std::vector<Point> kPoints{{0, 0, 0}, {1, 0.5, 0}, {1, 1, -2e-3}, {0, 1, 0}};
const std::vector<Face> kFaces{{0, 1, 2}, {0, 2, 3}};

std::string message_of(const std::string& text) {
    return thrown_message<InputError>([&] { parse_off(text, "a.off"); });
}

TEST(OffReader, KeepsVerticesAndFacesAsTheyAre) {
    const TriangleMesh mesh = parse_off(kPlain, "a.off");
    EXPECT_EQ(mesh.vertices, kPoints);
    EXPECT_EQ(mesh.faces, kFaces);
}

// The prefixes may come in the order of their authors' programs.
TEST(OffReader, TakesThePrefixesThatOnlyAddNumbers) {
    for (const char* prefix :
         {"", "C", "N", "ST", "CN", "NC", "STC", "STN", "STCN", "CST", "NST"}) {
        EXPECT_EQ(parse_off(prefix + kPlain, "a.off").vertices, kPoints) << prefix;
    }
    for (const char* prefix : {"4", "n", "4n", "C4", "STCN4n", "CC", "NN", "S", "T", "x"}) {
        EXPECT_THAT(message_of(prefix + kPlain), StartsWith("a.off:1:1: got '")) << prefix;
    }
}

TEST(OffReader, CountsLinesAlikeForEveryLineEnd) {
    for (const std::string line_end : {"\n", "\r\n", "\r"}) {
        std::string text = "OFF";
        for (const char* line : {"3 1 0", "# comment", "0 0 0", "", "1 0 0", "0 1 0", "3 0 1 x"}) {
            text += line_end + line;
        }
        EXPECT_THAT(message_of(text), StartsWith("a.off:8:7: face corner: got 'x'"));
    }
}

TEST(OffReader, SplitsPolygonsIntoFansFromTheirFirstCorner) {
    const TriangleMesh mesh =
        parse_off("OFF 5 1\n0 0 0\n1 0 0\n2 1 0\n1 2 0\n0 1 0\n5 2 3 4 0 1\n", "a.off");
    EXPECT_EQ(mesh.faces, (std::vector<Face>{{2, 3, 4}, {2, 4, 0}, {2, 0, 1}}));
}

// Nothing that was cut before its last corner passes for a whole mesh.
TEST(OffReader, NoticesEveryTruncation) {
    const std::size_t last_corner = kPlain.find(" 255");
    for (std::size_t size = 0; size < last_corner; ++size) {
        EXPECT_THAT(message_of(kPlain.substr(0, size)), StartsWith("a.off:")) << size;
    }
    for (std::size_t size = last_corner; size <= kPlain.size(); ++size) {
        EXPECT_EQ(parse_off(kPlain.substr(0, size), "a.off").faces, kFaces) << size;
    }
}

TEST(OffReader, SurvivesEveryAlteredByte) {
    for (std::size_t at = 0; at < kPlain.size(); ++at) {
        for (const char c : {'\0', '9', '-', 'e', '\r', '#', '\n', ' ', '\xff'}) {
            // Of exactly its size, so that reading beyond the end is seen by a sanitizer.
            std::vector<char> exact(kPlain.begin(), kPlain.end());
            exact[at] = c;
            try {
                const TriangleMesh mesh = parse_off({exact.data(), exact.size()}, "a.off");
                for (const Face& face : mesh.faces) {
                    EXPECT_GE(std::ranges::min(face), 0);
                    EXPECT_LT(std::ranges::max(face), mesh.vertex_count());
                }
            } catch (const InputError& error) {
                EXPECT_THAT(error.what(), StartsWith("a.off:"));
            }
        }
    }
}

TEST(OffReader, LongTokensAreCutInMessages) {
    EXPECT_LT(message_of(std::string(100000, 'z')).size(), 200u);
    EXPECT_LT(message_of("OFF\n1 1 0\n0 0 " + std::string(100000, 'z')).size(), 200u);
}

}  // namespace
}  // namespace mscomp
