// SPDX-License-Identifier: MIT
// What other programs leave in mesh files, in every format: passed over, noted, or named.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "acap/mesh/polygon_mesh.h"
#include "base/temporary_folder.h"
#include "base/thrown_message.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/acap/mesh/shape_source.h"
#include "mscomp/base/error.h"
#include "two_triangles.h"

namespace mscomp {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using namespace std::string_literals;

const std::string kObj = "v 0 0 0\nv 1 0.5 0\nv 1 1 -2e-3\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";
const std::string kPoints4 = "0 0 0\n1 0.5 0\n1 1 -2e-3\n0 1 0\n";
const std::string kOff = "OFF\n4 2 0\n" + kPoints4 + "3 0 1 2\n3 0 2 3\n";
const std::string kPlyHeader =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty "
    "double z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n";
const std::string kPly = kPlyHeader + kPoints4 + "3 0 1 2\n3 0 2 3\n";

void expect_the_square(const TriangleMesh& mesh) {
    EXPECT_EQ(mesh.vertices, kPoints);
    EXPECT_EQ(mesh.faces, kFaces);
}
void expect_the_square_of_off(const std::string& text) {
    SCOPED_TRACE(text);
    expect_the_square(parse_off(text, "a.off"));
}

TEST(Padding, BehindTheLastLineIsPassedOver) {
    for (const std::string& padding :
         {std::string(1, '\0'), "\x1a"s, std::string(5000, '\0'), "\x1a"s + std::string(127, '\0'),
          "\0\n\0\r\n\x1a \t\0"s, std::string(3000, '\x1a') + "\n"}) {
        expect_the_square(parse_obj(kObj + padding, "a.obj"));
        expect_the_square(parse_off(kOff + padding, "a.off"));
        expect_the_square(parse_ply(kPly + padding, "a.ply"));
        expect_the_square(parse_obj(kObj.substr(0, kObj.size() - 1) + padding, "a.obj"));
    }
}

TEST(Padding, WithinTheLinesIsAnErrorThatShowsTheByte) {
    const std::string nul(3, '\0');
    EXPECT_THAT(thrown_message<InputError>([&] { parse_obj(nul + "\n" + kObj, "a.obj"); }),
                HasSubstr("\\x00\\x00\\x00"));
    EXPECT_THAT(thrown_message<InputError>(
                    [&] { parse_off(replaced(kOff, "3 0 1", nul + "\n3 0 1"), "a.off"); }),
                HasSubstr("\\x00"));
    EXPECT_THAT(thrown_message<InputError>(
                    [&] { parse_ply(replaced(kPly, "1 0.5", "1\x1a 0.5"), "a.ply"); }),
                HasSubstr("\\x1a"));
    EXPECT_THAT(thrown_message<InputError>([&] { parse_obj(nul, "a.obj"); }), HasSubstr("no vert"));
}

// Numbers bound to nothing but their order.
TEST(OffTokens, RowsMayBreakAnywhere) {
    std::string words = replaced(kOff, "\n", " ");
    expect_the_square_of_off(words);
    expect_the_square_of_off(replaced(words, " ", "\n"));
    expect_the_square_of_off(replaced(words, " ", "\n# comment 7\n\n"));
    expect_the_square_of_off("OFF\n4 2 0\n0 0 0 1 0.5 0 1 1 -2e-3 0 1 0\n3 0 1 2  3 0 2 3\n");
    expect_the_square_of_off("OFF\n4 2 0\n0 0 0 1 0.5 0\n1 1 -2e-3 0 1 0\n3 0 1\n2\n3 0 2 3");
    expect_the_square_of_off("OFF\n4\n2\n0\n" + kPoints4 + "3 0 1 2\n3 0 2 3\n");
    expect_the_square_of_off("OFF 4 2\n" + kPoints4 + "3 0 1 2\n3 0 2 3\n");
}

TEST(OffTokens, CountsMayFollowTheKeywordAtOnce) {
    expect_the_square_of_off(replaced(kOff, "OFF\n4", "OFF4"));
    expect_the_square_of_off(replaced(kOff, "OFF\n4 2 0", "OFF4\n2 0"));
    expect_the_square_of_off(replaced(kOff, "OFF\n", "off\n"));
    EXPECT_THAT(
        thrown_message<InputError>([] { parse_off(replaced(kOff, "OFF\n4", "4OFF4"), "a.off"); }),
        HasSubstr("another dimension"));
}

TEST(OffTokens, ColoursStayUnderstood) {
    // By lines: any colour behind any face.
    expect_the_square_of_off("OFF\n4 2 0\n" + kPoints4 + "3 0 1 2 0.5 0.5 1\n3 0 2 3 7\n");
    // By tokens: rows broken, as many numbers behind each.
    expect_the_square_of_off("OFF\n4 2 0\n" + kPoints4 + "3 0 1\n2 255 0 0 3\n0 2 3 9 9 9\n");
    expect_the_square_of_off("OFF\n4 2 0\n" + kPoints4 + "3 0\n1 2 255 0 0 255 3 0 2 3 1 2 3 4");
    // A face that goes over two lines ends with its line.
    expect_the_square_of_off("OFF\n4 2 0\n" + kPoints4 + "3\n0 1 2 255 0 0\n3 0\n2 3 9\n");
    // Colours, normals and texture coordinates of vertices.
    const std::string colours = "0 0 0 1 2 3 4 1 0.5 0 1 2 3 4\n1 1 -2e-3 9 9 9 9 0 1 0 8 8 8 8\n";
    expect_the_square_of_off("COFF 4 2 0\n" + colours + "3 0 1 2 3 0 2 3\n");
    expect_the_square_of_off(
        "CNOFF 4 2 0\n0 0 0 0 0 1 5 5 5 1 0.5 0 0 0 1 5 5 5\n1 1 -2e-3 0 0 1 5 "
        "5 5 0 1 0 0 0 1 5 5 5 3 0 1 2 3 0 2 3\n");
    expect_the_square_of_off(
        "STOFF 4 2 0\n0 0 0 .1 .2 1 0.5 0 .1 .2\n1 1 -2e-3 .1 .2 0 1 0 .1 .2 "
        "3 0 1 2 3 0 2 3\n");
}

TEST(OffTokens, AreCountedToTheLast) {
    const std::string stream = "OFF 4 2 0\n0 0 0 1 0.5 0 1 1 -2e-3 0 1 0 3 0 1 2 3 0 2 3";
    expect_the_square_of_off(stream);
    for (std::size_t size = 0; size < stream.size() - 2; ++size) {
        EXPECT_THROW(parse_off(stream.substr(0, size), "a.off"), InputError) << size;
    }
    EXPECT_THROW(parse_off(stream + " 3", "a.off"), InputError);
}

TEST(SmallFaces, AreLeftOutAndCounted) {
    const auto expect_two = [](const PolygonMesh& mesh, const std::string& place) {
        EXPECT_EQ(mesh.face_count(), 1u);
        EXPECT_EQ(mesh.file_number(0), 2u);
        ASSERT_EQ(mesh.passed_over.size(), 1u);
        EXPECT_EQ(mesh.passed_over[0].count, 2);
        EXPECT_EQ(mesh.passed_over[0].first, place);
    };
    const std::string points = kObj.substr(0, kObj.find('f'));
    expect_two(parse_obj_polygons(points + "f 1\nf 1 2 3\nf 3/1 4/2\n", "a"), "line 5");
    expect_two(parse_off_polygons("OFF\n4 3 0\n" + kPoints4 + "1 0\n3 0 1 2\n2 0 1\n", "a"),
               "line 7");
    expect_two(
        parse_ply_polygons(
            replaced(kPlyHeader, "face 2", "face 3") + kPoints4 + "0\n3 0 1 2\n2 0 1\n", "a"),
        "line 14");
    EXPECT_THROW(parse_obj(points + "f 1 2\n", "a"), InputError);
    EXPECT_THROW(parse_off("OFF\n4 1 0\n" + kPoints4 + "2 0 1\n", "a"), InputError);
}

TEST(UnknownStatements, ArePassedOverAndCounted) {
    const PolygonMesh mesh =
        parse_obj_polygons("t 0 1\n" + kObj + "vw 1 2 \\\n3\n#MRGB ff\nfoo\nl 1 2\np 1\n", "a.obj");
    EXPECT_EQ(mesh.vertices, kPoints);
    ASSERT_EQ(mesh.passed_over.size(), 1u);
    EXPECT_EQ(mesh.passed_over[0].count, 3);
    EXPECT_EQ(mesh.passed_over[0].first, "line 1: 't'");
    for (const char* line : {"V 0 0 0", "F 1 2 3", "v1 0 0", "f1 2 3", "0 0 0", "call a.obj"}) {
        EXPECT_THROW(parse_obj(kObj + line + "\n", "a.obj"), InputError) << line;
    }
    expect_the_square(parse_obj(replaced(kObj, "f 1 2", "fo 1 2"), "a.obj"));
}

// One sentence for a set, however many files and faces.
TEST(MeshFiles, WarnOnceForEachKind) {
    const TemporaryFolder folder;
    std::vector<std::string> paths;
    for (int i = 0; i < 4; ++i) {
        paths.push_back(
            folder.put(std::to_string(i) + ".obj", i < 2 ? kObj : kObj + "f 1 2\nzz\n"));
    }
    const MeshFiles files(paths);
    for (const int i : {3, 0, 2, 1, 2}) files.shape(i);
    EXPECT_THAT(files.warnings(),
                ElementsAre("2 faces of fewer than three corners in 2 of 4 files passed over, the "
                            "first in " +
                                paths[2] + ", line 7",
                            "2 unknown statements in 2 of 4 files passed over, the first in " +
                                paths[2] + ", line 8: 'zz'"));
}

TEST(MeshFiles, KnowWhatTheyDoNotKeep) {
    const TemporaryFolder folder;
    const auto unused = [&](const std::string& name, const std::string& text) {
        return MeshFiles({folder.put(name, text)}).unused();
    };
    EXPECT_THAT(unused("a.obj", kObj), IsEmpty());
    EXPECT_THAT(unused("b.obj",
                       "vt 0 0\nvn 0 0 1\nv 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nusemtl "
                       "x\nf 1/1 2/1 4/1 3/1\n"),
                testing::UnorderedElementsAre("texture coordinates", "normals", "materials",
                                              "weights or colours of vertices",
                                              "polygons of more than three corners (split)"));
    EXPECT_THAT(unused("c.off", "COFF\n4 2 0\n" + replaced(kPoints4, "\n", " 1 2 3 4\n") +
                                    "3 0 1 2 7\n3 0 2 3 7\n"),
                testing::UnorderedElementsAre("vertex colours", "face colours"));
    EXPECT_THAT(unused("d.ply", replaced(kPlyHeader, "property double z\n",
                                         "property double z\nproperty float heat\nproperty float "
                                         "nx\n") +
                                    replaced(kPoints4, "\n", " 1 2\n") + "3 0 1 2\n3 0 2 3\n"),
                testing::UnorderedElementsAre("the property 'heat' of the vertices", "normals"));
}

TEST(PlyReader, TakesWordsInAnyCase) {
    expect_the_square(parse_ply(replaced(kPly, "ply\n", "PLY\n"), "a.ply"));
    std::string upper = kPlyHeader;
    for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    expect_the_square(parse_ply(upper + kPly.substr(kPlyHeader.size()), "a.ply"));
    expect_the_square(parse_ply(replaced(kPly, "vertex_indices", "vertex_index"), "a.ply"));
    // x beside X: the one that is written as it should be.
    const std::string both =
        replaced(kPlyHeader, "property double z\n", "property double z\nproperty double X\n");
    expect_the_square(
        parse_ply(both + replaced(kPoints4, "\n", " 9\n") + "3 0 1 2\n3 0 2 3\n", "a.ply"));
    EXPECT_THAT(thrown_message<InputError>(
                    [] { parse_ply(replaced(kPly, "double x", "double px"), "a.ply"); }),
                AllOf(HasSubstr("0 properties 'x'"), HasSubstr("it has 'px', 'y', 'z'")));
}

TEST(ByteOrderMark, IsTakenInFrontAndNamedElsewhere) {
    const std::string mark = "\xEF\xBB\xBF";
    expect_the_square(parse_obj(mark + kObj, "a.obj"));
    expect_the_square(parse_off(mark + kOff, "a.off"));
    expect_the_square(parse_ply(mark + kPly, "a.ply"));
    const auto named = HasSubstr("byte order mark");
    EXPECT_THAT(thrown_message<InputError>([&] {
                    parse_ply(kPlyHeader + mark + kPly.substr(kPlyHeader.size()), "a.ply");
                }),
                named);
    EXPECT_THAT(thrown_message<InputError>([&] { parse_obj(kObj + mark + kObj, "a.obj"); }), named);
    EXPECT_THAT(thrown_message<InputError>(
                    [&] { parse_off(replaced(kOff, "0 0 0", mark + "0 0 0"), "a.off"); }),
                named);
}

}  // namespace
}  // namespace mscomp
