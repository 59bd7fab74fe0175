// SPDX-License-Identifier: MIT
// Beyond the tiny files of tests/mesh/files: what holds for every cut and every altered byte.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "base/thrown_message.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/error.h"
#include "two_triangles.h"

namespace mscomp {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

const std::string kPlainOff =
    "OFF\n4 2 5\n0 0 0\n1 0.5 0\n1 1 -2e-3\n0 1 0\n3 0 1 2\n3 0 2 3 255 0 0\n";

std::string off_message(const std::string& text) {
    return thrown_message<InputError>([&] { parse_off(text, "a.off"); });
}

TEST(OffReader, KeepsVerticesAndFacesAsTheyAre) {
    const TriangleMesh mesh = parse_off(kPlainOff, "a.off");
    EXPECT_EQ(mesh.vertices, kPoints);
    EXPECT_EQ(mesh.faces, kFaces);
}

// The prefixes may come in the order of their authors' programs.
TEST(OffReader, TakesThePrefixesThatOnlyAddNumbers) {
    for (const char* prefix :
         {"", "C", "N", "ST", "CN", "NC", "STC", "STN", "STCN", "CST", "NST"}) {
        EXPECT_EQ(parse_off(prefix + kPlainOff, "a.off").vertices, kPoints) << prefix;
    }
    for (const char* prefix : {"4", "n", "4n", "C4", "STCN4n", "CC", "NN", "S", "T", "x"}) {
        EXPECT_THAT(off_message(prefix + kPlainOff), StartsWith("a.off:1:1: got '")) << prefix;
    }
}

TEST(OffReader, CountsLinesAlikeForEveryLineEnd) {
    for (const std::string line_end : {"\n", "\r\n", "\r"}) {
        std::string text = "OFF";
        for (const char* line : {"3 1 0", "# comment", "0 0 0", "", "1 0 0", "0 1 0", "3 0 1 x"}) {
            text += line_end + line;
        }
        EXPECT_THAT(off_message(text), StartsWith("a.off:8:7: face corner: got 'x'"));
    }
}

TEST(OffReader, SplitsPolygonsFromTheirLowestCorner) {
    const TriangleMesh mesh =
        parse_off("OFF 5 1\n0 0 0\n1 0 0\n2 1 0\n1 2 0\n0 1 0\n5 2 3 4 0 1\n", "a.off");
    EXPECT_EQ(mesh.faces, (std::vector<Face>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}));
}

// Nothing that was cut before its last corner passes for a whole mesh.
TEST(OffReader, NoticesEveryTruncation) {
    const std::size_t last_corner = kPlainOff.find(" 255");
    for (std::size_t size = 0; size < last_corner; ++size) {
        EXPECT_THAT(off_message(kPlainOff.substr(0, size)), StartsWith("a.off:")) << size;
    }
    for (std::size_t size = last_corner; size <= kPlainOff.size(); ++size) {
        EXPECT_EQ(parse_off(kPlainOff.substr(0, size), "a.off").faces, kFaces) << size;
    }
}

TEST(OffReader, SurvivesEveryAlteredByte) {
    for (std::size_t at = 0; at < kPlainOff.size(); ++at) {
        for (const char c : {'\0', '9', '-', 'e', '\r', '#', '\n', ' ', '\xff'}) {
            // Of exactly its size, so that reading beyond the end is seen by a sanitizer.
            std::vector<char> exact(kPlainOff.begin(), kPlainOff.end());
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
    EXPECT_LT(off_message(std::string(100000, 'z')).size(), 200u);
    EXPECT_LT(off_message("OFF\n1 1 0\n0 0 " + std::string(100000, 'z')).size(), 200u);
}

}  // namespace
}  // namespace mscomp
