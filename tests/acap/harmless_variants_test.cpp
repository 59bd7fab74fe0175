// SPDX-License-Identifier: MIT
// Another spelling of the same meshes gives the same features, bit for bit.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <sstream>

#include "base/temporary_folder.h"
#include "mesh/generated_meshes.h"
#include "mscomp/acap/extract.h"

namespace mscomp {
namespace {

constexpr int kShapes = 3;
constexpr int kShortest = 0;  // spelling that keeps every double exactly

/// A capped cylinder that twists, bends and bulges.
GeneratedMesh deformed_shape(int number) {
    GeneratedMesh mesh = of_triangles(shapes::cylinder(9, 7, 1, 4, true));
    const double t = 0.9 * number;
    for (Point& p : mesh.vertices) {
        const double angle = t * p[2], size = 1 + 0.1 * t * std::sin(2 * p[2]);
        p = {size * (std::cos(angle) * p[0] - std::sin(angle) * p[1]) + 0.05 * t * p[2] * p[2],
             size * (std::sin(angle) * p[0] + std::cos(angle) * p[1]), p[2] + 0.02 * t * p[0]};
    }
    return mesh;
}

/// The file of shape `number` in some spelling, and its extension.
struct Variant {
    std::string name;
    std::string extension;
    std::function<std::string(const GeneratedMesh& mesh, int number)> text;
};
void PrintTo(const Variant& variant, std::ostream* out) { *out << variant.name; }

std::string plain_obj(const GeneratedMesh& mesh) {
    return obj_text(mesh, kShortest, Corner::plain);
}

/// A comment cannot be continued.
std::string without_comment(const GeneratedMesh& mesh) {
    const std::string text = plain_obj(mesh);
    return text.substr(text.find('\n') + 1);
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
        text.replace(at, from.size(), to);
    }
    return text;
}

/// With ` tail` at the end of every line that starts with `start`.
std::string with_tails(const std::string& text, const std::string& start, const std::string& tail) {
    std::istringstream lines(text);
    std::string result;
    for (std::string line; std::getline(lines, line);) {
        result += line + (line.starts_with(start) ? tail : "") + "\n";
    }
    return result;
}

/// The first file keeps its faces; the others have them in another order, from other corners.
GeneratedMesh with_shuffled_faces(GeneratedMesh mesh, int number) {
    if (number == 0) return mesh;
    const CounterRandom random(9, static_cast<std::uint64_t>(number));
    Polygons faces;
    for (const int i : random.permutation(static_cast<int>(mesh.faces.size()))) {
        faces.push_back(mesh.faces[static_cast<std::size_t>(i)]);
        std::rotate(faces.back().begin(), faces.back().begin() + (i + number) % 3,
                    faces.back().end());
    }
    mesh.faces = faces;
    return mesh;
}

/// Statements in another order: all faces first.
std::string with_faces_first(const std::string& text) {
    std::istringstream lines(text);
    std::string faces, others;
    for (std::string line; std::getline(lines, line);) {
        (line.starts_with("f ") ? faces : others) += line + "\n";
    }
    return faces + others;
}

/// COFF with a normal and a colour per vertex line.
std::string off_with_colours(const GeneratedMesh& mesh) {
    std::string text = "# coloured\nCNOFF " + std::to_string(mesh.vertices.size()) + " " +
                       std::to_string(mesh.faces.size()) + "\n";
    for (const Point& p : mesh.vertices) {
        std::string row = point_text(p, kShortest);
        row.pop_back();
        text += row + " 0 0 1 255 0 0 255 # p\n";
    }
    for (const std::vector<int>& face : mesh.faces) {
        text += "3 " + std::to_string(face[0]) + " " + std::to_string(face[1]) + " " +
                std::to_string(face[2]) + " 0.5 0.5 0.5\n";
    }
    return text;
}

FeatureSet features_of(const Variant& variant) {
    const TemporaryFolder folder;
    for (int i = 0; i < kShapes; ++i) {
        folder.put(std::to_string(i) + variant.extension, variant.text(deformed_shape(i), i));
    }
    const MeshSequence sequence = read_sequence(expand_inputs({folder.path()}));
    return extract_features(sequence, sequence.shapes.front());
}

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

class HarmlessVariant : public testing::TestWithParam<Variant> {};

TEST_P(HarmlessVariant, GivesTheSameFeaturesBitForBit) {
    static const FeatureSet plain = features_of(
        {"Plain", ".obj", [](const GeneratedMesh& mesh, int) { return plain_obj(mesh); }});
    const FeatureSet features = features_of(GetParam());
    ASSERT_EQ(features.shape_count(), kShapes);
    EXPECT_TRUE(same_bits(features.features, plain.features));
    EXPECT_TRUE(same_bits(features.vertices, plain.vertices));
    EXPECT_TRUE(same_bits(features.reference.vertices, plain.reference.vertices));
    EXPECT_TRUE(same_bits(features.reference.faces, plain.reference.faces));
    EXPECT_TRUE(same_bits(features.rotation, plain.rotation));
    EXPECT_TRUE(same_bits(features.translation, plain.translation));
    EXPECT_TRUE(same_bits(features.consistency_energy, plain.consistency_energy));
}

#define TEXT_OF(expression)             \
    [](const GeneratedMesh& m, int n) { \
        static_cast<void>(n);           \
        return expression;              \
    }

INSTANTIATE_TEST_SUITE_P(
    Spellings, HarmlessVariant,
    testing::Values(
        Variant{"ByteOrderMark", ".obj", TEXT_OF("\xEF\xBB\xBF" + plain_obj(m))},
        Variant{"WindowsLineEnds", ".obj", TEXT_OF(replaced(plain_obj(m), "\n", "\r\n"))},
        Variant{"OldMacLineEnds", ".obj", TEXT_OF(replaced(plain_obj(m), "\n", "\r"))},
        Variant{"NoLastLineEnd", ".obj", TEXT_OF(plain_obj(m).substr(0, plain_obj(m).size() - 1))},
        Variant{"TabsAndBlanks", ".obj", TEXT_OF(replaced(plain_obj(m), " ", " \t "))},
        Variant{"Continuations", ".obj", TEXT_OF(replaced(without_comment(m), " ", " \\\n "))},
        Variant{"Comments", ".obj", TEXT_OF(with_tails(plain_obj(m), "", " # here"))},
        Variant{"Texture", ".obj", TEXT_OF(obj_text(m, kShortest, Corner::texture))},
        Variant{"Normals", ".obj", TEXT_OF(obj_text(m, kShortest, Corner::normal))},
        Variant{"TextureAndNormals", ".obj",
                TEXT_OF(obj_text(m, kShortest, Corner::texture_and_normal))},
        Variant{"NegativeIndices", ".obj", TEXT_OF(obj_text(m, kShortest, Corner::negative))},
        Variant{"Colours", ".obj", TEXT_OF(with_tails(plain_obj(m), "v ", " 0.1 0.2 0.3"))},
        Variant{"Weights", ".obj", TEXT_OF(with_tails(plain_obj(m), "v ", " 1"))},
        Variant{"GroupsAndMaterials", ".obj",
                TEXT_OF("mtllib a.mtl\no body\n" +
                        replaced(plain_obj(m), "\nf 1 ", "\ng arm\nusemtl red\ns 1\nf 1 "))},
        Variant{"FacesFirst", ".obj", TEXT_OF(with_faces_first(plain_obj(m)))},
        Variant{"ScientificNumbers", ".obj", TEXT_OF(obj_text(m, 1, Corner::plain))},
        Variant{"SeventeenDigits", ".obj", TEXT_OF(obj_text(m, 4, Corner::plain))},
        Variant{"ShuffledFaces", ".obj", TEXT_OF(plain_obj(with_shuffled_faces(m, n)))},
        Variant{"Off", ".off", TEXT_OF(off_text(m, kShortest))},
        Variant{"OffWithColours", ".off", TEXT_OF(off_with_colours(m))},
        Variant{"OffShuffledFaces", ".OFF", TEXT_OF(off_text(with_shuffled_faces(m, n), 4))},
        Variant{"PlyText", ".ply", TEXT_OF(ply_text(m, kShortest))},
        Variant{"PlyLittleEndian", ".ply", TEXT_OF(ply_bytes(m, false))},
        Variant{"PlyBigEndian", ".ply", TEXT_OF(ply_bytes(m, true))},
        Variant{"PlyByteOrdersMixed", ".PLY", TEXT_OF(ply_bytes(m, n % 2 == 0))}),
    [](const auto& tested) { return tested.param.name; });

// The test would notice one coordinate of one vertex that is off in its sixth digit.
TEST(HarmlessVariants, AnotherCoordinateGivesOtherFeatures) {
    const auto features_with = [](double factor) {
        return features_of({"", ".obj", [factor](GeneratedMesh mesh, int number) {
                                if (number == 1) mesh.vertices[20][0] *= factor;
                                return plain_obj(mesh);
                            }});
    };
    EXPECT_TRUE(same_bits(features_with(1).features, features_with(1).features));
    EXPECT_FALSE(same_bits(features_with(1).features, features_with(1 + 1e-6).features));
}

}  // namespace
}  // namespace mscomp
