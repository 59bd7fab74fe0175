// SPDX-License-Identifier: MIT
#include "mscomp/acap/mesh/mesh_sequence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/temporary_folder.h"
#include "base/thrown_message.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/error.h"
#include "mscomp/base/parallel.h"
#include "mscomp/base/random.h"

namespace mscomp {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

const std::string kVertices = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\n";
const std::string kMoved = "v 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nv 2 0 1\n";

class ReadSequence : public testing::Test {
  protected:
    MeshSequence read(const std::string& first_faces, const std::string& second_faces) {
        return read_sequence({folder_.put("a.obj", kVertices + first_faces),
                              folder_.put("b.obj", kMoved + second_faces)});
    }
    std::string refusal(const std::string& first_faces, const std::string& second_faces) {
        const std::string message =
            thrown_message<InputError>([&] { read(first_faces, second_faces); });
        EXPECT_THAT(message, testing::StartsWith(folder_ / "b.obj:"));
        return message;
    }
    TemporaryFolder folder_;
};

TEST_F(ReadSequence, TakesPositionsFromEveryFileAndFacesFromTheFirst) {
    const MeshSequence sequence =
        read("f 1 2 3\nf 1 3 4\nf 2 5 3\n", "f 1 2 3\nf 1 3 4\nf 2 5 3\n");
    EXPECT_THAT(sequence.names, ElementsAre("a", "b"));
    EXPECT_EQ(sequence.shapes[0][4], (Point{2, 0, 0}));
    EXPECT_EQ(sequence.shapes[1][4], (Point{2, 0, 1}));
    EXPECT_EQ(sequence.faces, (std::vector<Face>{{0, 1, 2}, {0, 2, 3}, {1, 4, 2}}));
}

TEST_F(ReadSequence, AcceptsTheSameFacesInAnotherOrderAndFromAnotherCorner) {
    const MeshSequence sequence =
        read("f 1 2 3\nf 1 3 4\nf 2 5 3\n", "f 3 2 5\nf 3 4 1\nf 2 3 1\n");
    EXPECT_EQ(sequence.faces, (std::vector<Face>{{0, 1, 2}, {0, 2, 3}, {1, 4, 2}}));
    EXPECT_EQ(sequence.shapes[1][1], (Point{1, 0, 1}));
}

// The fan of (2 3 4 1) would be another one; the reference decides.
TEST_F(ReadSequence, SplitsPolygonsAsInTheReference) {
    const MeshSequence sequence = read("f 1 2 3 4\nf 2 5 3\n", "f 2 3 4 1\nf 2 5 3\n");
    EXPECT_EQ(sequence.faces, (std::vector<Face>{{0, 1, 2}, {0, 2, 3}, {1, 4, 2}}));
}

TEST_F(ReadSequence, RefusesAnotherVertexCount) {
    const std::string faces = "f 1 2 3\n";
    const std::string a = folder_.put("a.obj", kVertices + faces);
    const std::string b = folder_.put("b.obj", kVertices + "v 9 9 9\n" + faces);
    EXPECT_EQ(thrown_message<InputError>([&] {
                  read_sequence({a, b});
              }),
              b + ": 6 vertices, but " + a + " has 5");
}

TEST_F(ReadSequence, NamesTheFirstFaceThatDiffers) {
    EXPECT_THAT(refusal("f 1 2 3\nf 1 3 4\n", "f 2 3 1\nf 1 3 5\n"),
                AllOf(HasSubstr("face 2 is (1 3 5)"), HasSubstr("a.obj does not have"),
                      HasSubstr("there face 2 is (1 3 4)")));
}

TEST_F(ReadSequence, RefusesFacesTurnedAround) {
    EXPECT_THAT(refusal("f 1 2 3\nf 1 3 4\n", "f 1 2 3\nf 1 4 3\n"),
                HasSubstr("face 2 is (1 4 3)"));
}

TEST_F(ReadSequence, RefusesAnotherFaceCount) {
    EXPECT_THAT(refusal("f 1 2 3\nf 1 3 4\n", "f 1 2 3\n"),
                AllOf(HasSubstr("1 faces, but"), HasSubstr("has 2"), HasSubstr("face 2 of"),
                      HasSubstr("(1 3 4), which is missing here")));
    EXPECT_THAT(
        refusal("f 1 2 3\n", "f 1 2 3\nf 1 3 4\n"),
        AllOf(HasSubstr("2 faces, but"), HasSubstr("has 1"), HasSubstr("face 2 is (1 3 4)")));
}

TEST_F(ReadSequence, CountsRepeatedFaces) {
    EXPECT_THAT(refusal("f 1 2 3\nf 1 2 3\nf 1 3 4\n", "f 1 2 3\nf 1 3 4\nf 1 3 4\n"),
                HasSubstr("face 3 is (1 3 4)"));
}

// Comparing all starts of such a face with each other would take 10^10 steps.
TEST_F(ReadSequence, ComparesFacesOfVeryManyCornersQuickly) {
    std::string ones;
    for (int i = 0; i < 100000; ++i) ones += " 1";
    const MeshSequence sequence = read("f" + ones + " 2 3\n", "f 2 3" + ones + "\n");
    EXPECT_EQ(sequence.faces.size(), 100000u);
    const std::string message = refusal("f" + ones + " 2 3\n", "f 3 2" + ones + "\n");
    EXPECT_THAT(message, HasSubstr("face 1 is (3 2 1 1 1"));
    EXPECT_LT(message.size(), 400u);
}

// Every order of the faces and every starting corner is the same connectivity; swapping two corners
// of any face, or having one twice in place of another, is not.
TEST_F(ReadSequence, ComparesManyFacesInAnyOrder) {
    const CounterRandom random(5, 0);
    const int count = 400;
    std::string plain, shuffled;
    const auto line = [](int a, int b, int c) {
        return "f " + std::to_string(a + 1) + " " + std::to_string(b + 1) + " " +
               std::to_string(c + 1) + "\n";
    };
    std::vector<std::array<int, 3>> corners;
    for (int i = 0; i < count; ++i) {
        const auto bits = static_cast<int>(random.bits(static_cast<std::uint64_t>(i)) % 125);
        corners.push_back({bits % 5, bits / 5 % 5, bits / 25});
        plain += line(corners.back()[0], corners.back()[1], corners.back()[2]);
    }
    for (const int i : random.permutation(count)) {
        const auto [a, b, c] = corners[static_cast<std::size_t>(i)];
        shuffled += i % 3 == 0 ? line(a, b, c) : i % 3 == 1 ? line(b, c, a) : line(c, a, b);
    }
    EXPECT_EQ(read(plain, shuffled).faces.size(), 400u);
    EXPECT_THAT(refusal(plain + "f 1 2 2\nf 3 4 5\n", shuffled + "f 1 2 2\nf 3 5 4\n"),
                HasSubstr("face 402 is (3 5 4)"));
}

TEST_F(ReadSequence, RefusesAQuadInPlaceOfItsTriangles) {
    EXPECT_THAT(refusal("f 1 2 3\nf 1 3 4\n", "f 1 2 3 4\n"), HasSubstr("face 1 is (1 2 3 4)"));
}

TEST_F(ReadSequence, PassesOnWhatIsWrongWithinAFile) {
    EXPECT_THAT(refusal("f 1 2 3\n", "f 1 2 9001\n"),
                HasSubstr("b.obj:6:7: face refers to vertex 9001"));
}

TEST_F(ReadSequence, KeepsTheFolderThatTellsRepeatedStemsApart) {
    const std::string text = kVertices + "f 1 2 3\n";
    const MeshSequence sequence =
        read_sequence({folder_.put("x/1.obj", text), folder_.put("y/1.obj", text),
                       folder_.put("1-2.obj", text), folder_.put("z/1.obj", text)});
    EXPECT_THAT(sequence.names, ElementsAre("x_1", "y_1", "1-2", "z_1"));
}

// The first bad file in the order given is reported, whichever thread finds its own first.
TEST_F(ReadSequence, ReportsTheSameFileForAnyNumberOfThreads) {
    std::vector<std::string> paths{folder_.put("0.obj", kVertices + "f 1 2 3\n")};
    for (int i = 1; i < 40; ++i) {
        const std::string faces = i >= 23 ? "f 1 2 4\n" : "f 1 2 3\n";
        paths.push_back(folder_.put(std::to_string(i) + ".obj", kMoved + faces));
    }
    for (const int threads : {1, 2, 7}) {
        set_thread_count(threads);
        EXPECT_THAT(thrown_message<InputError>([&] { read_sequence(paths); }),
                    HasSubstr("/23.obj: "));
    }
    set_thread_count(0);
}

TEST_F(ReadSequence, WithoutFilesIsAUsageError) { EXPECT_THROW(read_sequence({}), UsageError); }

}  // namespace
}  // namespace mscomp
