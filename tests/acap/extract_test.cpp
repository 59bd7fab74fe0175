// SPDX-License-Identifier: MIT
#include "mscomp/acap/extract.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <mutex>
#include <numbers>
#include <set>
#include <utility>

#include "acap_cases.h"
#include "base/temporary_folder.h"
#include "base/thrown_message.h"
#include "mscomp/acap/feature_file.h"
#include "mscomp/base/error.h"
#include "mscomp/base/parallel.h"

namespace mscomp {
namespace {

using namespace cases;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

void expect_reference_feature(const FeatureSet& set, double tolerance) {
    for (int n = 0; n < set.shape_count(); ++n) {
        for (int i = 0; i < set.vertex_count(); ++i) {
            EXPECT_LT(largest(rotation_vector(set, i, n)), tolerance);
            EXPECT_LT(largest(stretch(set, i, n) - Matrix3d::Identity()), tolerance);
        }
    }
}

void expect_finite(const FeatureSet& set) {
    for (const float value : set.features) ASSERT_TRUE(std::isfinite(value));
    for (const double value : set.consistency_energy) ASSERT_TRUE(std::isfinite(value));
}

std::vector<TriangleMesh> plain_meshes() {
    return {bumpy_sphere(2), shapes::grid(6, 5), shapes::cylinder(8, 5, 1, 3, false)};
}

TEST(Extract, ReferenceHasItsOwnFeature) {
    for (const TriangleMesh& mesh : plain_meshes()) {
        expect_reference_feature(extract_one(mesh, mesh), 1e-6);
    }
}

// p -> R p + t: S = I and r = log R everywhere; nothing is left after alignment.
TEST(Extract, RigidMotionIsOneConstantRotationAndAlignsAway) {
    const Vector3d r = Vector3d(1, -2, 0.5).normalized() * 2.8;
    for (const TriangleMesh& mesh : plain_meshes()) {
        const TriangleMesh shape = mapped(
            mesh, [&](const Vector3d& p) -> Vector3d { return exp_of(r) * p + Vector3d(4, 5, 6); });
        const FeatureSet kept = extract_one(mesh, shape, false);
        for (int i = 0; i < mesh.vertex_count(); ++i) {
            EXPECT_LT(largest(rotation_vector(kept, i) - r), 1e-6);
            EXPECT_LT(largest(stretch(kept, i) - Matrix3d::Identity()), 1e-6);
        }
        EXPECT_NEAR(kept.consistency_energy[0], 0, 1e-20);
        expect_reference_feature(extract_one(mesh, shape, true), 1e-6);
    }
}

// aligned = rotation * input + translation, and that is what `vertices` holds.
TEST(Extract, StoresTheMotionOfTheAlignment) {
    const TriangleMesh mesh = bumpy_sphere(1);
    const TriangleMesh shape = mapped(mesh, [](const Vector3d& p) -> Vector3d {
        return rotation_about({1, 1, 0}, 1.0) * wobble(p) + Vector3d(9, 0, 1);
    });
    const FeatureSet set = extract_one(mesh, shape, true);
    const Matrix3d rotation =
        Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(set.rotation[0].data());
    for (int i = 0; i < mesh.vertex_count(); ++i) {
        const Vector3d moved = rotation * vec(shape.vertices[at(i)]) + vec(set.translation[0]);
        const float* stored = set.vertices.data() + 3 * at(i);
        EXPECT_LT(largest(Vector3d(stored[0], stored[1], stored[2]) - moved), 1e-6);
    }
}

// A rotation by exactly π about any axis: finite, |r| = π, one sign for all.
TEST(Extract, HalfTurnHasOneAxisEverywhere) {
    const TriangleMesh mesh = bumpy_sphere(2);
    for (const Vector3d& direction : {Vector3d(0, 0, 1), Vector3d(1, 0, 0), Vector3d(1, 2, -2)}) {
        const Vector3d axis = direction.normalized();
        const Matrix3d half_turn = 2 * axis * axis.transpose() - Matrix3d::Identity();
        const FeatureSet set = extract_one(
            mesh, mapped(mesh, [&](const Vector3d& p) -> Vector3d { return half_turn * p; }));
        const Vector3d root = rotation_vector(set, 0);
        EXPECT_NEAR(root.norm(), kPi, 1e-6);
        EXPECT_LT(root.cross(axis).norm(), 1e-6);
        for (int i = 0; i < mesh.vertex_count(); ++i) {
            EXPECT_LT(largest(rotation_vector(set, i) - root), 1e-6);
        }
        EXPECT_LT(set.largest_jump[0], 1e-6);
    }
}

// A flat cloth bent to a roll: the rotation of a ring follows the normal.
TEST(Extract, FlatGridRolledUpTurnsWithItsNormal) {
    const TriangleMesh flat = shapes::grid(30, 5);
    const double radius = 6;
    const TriangleMesh roll = mapped(flat, [=](const Vector3d& p) -> Vector3d {
        return {radius * std::sin(p.x() / radius), p.y(), radius * (1 - std::cos(p.x() / radius))};
    });
    const FeatureSet set = extract_one(flat, roll);
    for (int x = 1; x < 29; ++x) {
        for (int y = 1; y < 4; ++y) {
            const Vector3d wanted(0, -x / radius, 0);  // 4.67 rad at the far end
            EXPECT_LT(largest(rotation_vector(set, y * 30 + x) - wanted), 1e-5) << x;
        }
    }
}

// x -> -x: det T < 0 is counted and said, S has a negative eigenvalue, nothing is infinite.
TEST(Extract, MirroredShapeIsFiniteAndReported) {
    const TriangleMesh mesh = bumpy_sphere(2);
    const TriangleMesh inside_out = mapped(mesh, [](const Vector3d& p) -> Vector3d { return -p; });
    TriangleMesh turned = inside_out;
    const FeatureSet set = extract_one(mesh, turned, true);
    expect_finite(set);
    EXPECT_THAT(set.warnings, Contains(HasSubstr("mirrored")));
    EXPECT_THAT(set.warnings, Contains(HasSubstr("in 1 of 1 shapes")));
}

// Places count from 1, as in the files and in what `check` says.
TEST(Extract, WarningsCountPlacesFromOne) {
    TriangleMesh mesh = shapes::grid(4, 4);
    mesh.vertices.push_back({9, 9, 9});  // the 17th
    mesh.faces.push_back({0, 1, 0});     // the 19th
    const FeatureSet set = extract_one(mesh, mesh);
    EXPECT_THAT(set.warnings, Contains(HasSubstr("alignment and scale (first: vertex 17)")));
    EXPECT_THAT(set.warnings, Contains(HasSubstr("weight (first: face 19)")));
    EXPECT_THAT(set.warnings, Contains(HasSubstr("(first: face 19 of ")));
}

// float32 has 24 bits: a hundred sizes away from the origin it has 17 left for the shape.
TEST(Extract, WarnsWhereFloatKeepsFewDigits) {
    const auto warnings_at = [](double place, double place_of_reference, bool align) {
        const auto at_x = [](double x) {
            return mapped(shapes::icosphere(2), [x](const Vector3d& p) -> Vector3d {
                return {p.x() + x, p.y(), p.z()};
            });
        };
        const ExtractOptions options{EdgeWeights::cotangent, align};
        return extract_features(sequence_of({at_x(place)}), at_x(place_of_reference).vertices,
                                options)
            .warnings;
    };
    EXPECT_THAT(warnings_at(210, 210, true),
                ElementsAre(HasSubstr("the reference lies over 100 times its size")));
    EXPECT_TRUE(warnings_at(190, 190, true).empty());
    EXPECT_TRUE(warnings_at(2100, 0, true).empty());  // aligned, it is stored at the reference
    EXPECT_THAT(warnings_at(210, 0, false),
                ElementsAre(HasSubstr("1 of 1 shapes lie over 100 times their size from the "
                                      "reference")));
}

// What check would say of one in millimetres, one whose vertices are shuffled and one with a spike.
TEST(Extract, WarnsOfWholeShapesThatAreOdd) {
    const TriangleMesh mesh = bumpy_sphere(3);
    std::vector<TriangleMesh> shapes(40, mapped(mesh, wobble));
    EXPECT_TRUE(
        extract_features(sequence_of(shapes), mesh.vertices, ExtractOptions{}).warnings.empty());
    shapes[3] = mapped(mesh, [](const Vector3d& p) -> Vector3d { return 1000 * wobble(p); });
    const std::vector<int> order = CounterRandom(2, 2).permutation(mesh.vertex_count());
    for (std::size_t v = 0; v < order.size(); ++v) {
        shapes[5].vertices[v] = shapes[7].vertices[at(order[v])];
    }
    const FeatureSet set = extract_features(sequence_of(shapes), mesh.vertices);
    EXPECT_THAT(set.warnings, Contains(HasSubstr("1 of 40 shapes (first: 'shape_3') have another "
                                                 "size than the reference")));
    EXPECT_THAT(set.warnings, Contains(HasSubstr("1 of 40 shapes (first: 'shape_5') seem to have "
                                                 "their vertices in another order")));
    shapes.assign(40, mapped(mesh, wobble));
    shapes[9].vertices[100] = {20, 20, 20};
    EXPECT_THAT(
        extract_features(sequence_of(shapes), mesh.vertices).warnings,
        Contains(HasSubstr("1 of 40 shapes (first: 'shape_9') stretch somewhere far more")));
}

// The reference has a ring drawn together that is open in all others: no fault of theirs.
TEST(Extract, WarnsOfAReferenceThatIsPinched) {
    const TriangleMesh open = bumpy_sphere(5);
    const OneRings rings = one_rings_of_faces(open.vertex_count(), open.faces);
    TriangleMesh shut = open;
    for (int k = rings.offsets[1000]; k < rings.offsets[1001]; ++k) {
        Point& p = shut.vertices[at(rings.neighbors[at(k)])];
        const Vector3d center = vec(open.vertices[1000]);
        p = point(center + 0.03 * (vec(p) - center));
    }
    const MeshSequence sequence = sequence_of({shut, mapped(open, wobble), open});
    EXPECT_THAT(extract_features(sequence, shut.vertices).warnings,
                ElementsAre(HasSubstr("2 of 3 shapes (first: 'shape_1') are open where the "
                                      "reference is pinched")));
    EXPECT_THAT(extract_features(sequence, open.vertices).warnings, testing::IsEmpty());
}

TEST(Extract, RefusesWhatIsTooSmallForFloat) {
    const TriangleMesh tiny = mapped(bumpy_sphere(1), [](const Vector3d& p) { return 1e-40 * p; });
    EXPECT_THAT(thrown_message<MeshError>([&] { extract_one(tiny, tiny); }),
                HasSubstr("too small for float32"));
    const TriangleMesh small = mapped(bumpy_sphere(1), [](const Vector3d& p) { return 1e-20 * p; });
    EXPECT_TRUE(extract_one(small, small).warnings.empty());
}

TEST(Extract, PlainShapesGiveNoWarnings) {
    const TriangleMesh mesh = bumpy_sphere(2);
    EXPECT_TRUE(extract_one(mesh, mapped(mesh, wobble)).warnings.empty());
}

TEST(Extract, OddPlacesAreFiniteAndReported) {
    TriangleMesh mesh = shapes::grid(4, 4);
    mesh.vertices.push_back({9, 9, 9});  // isolated
    mesh.vertices.push_back({0.5, 0, 0});
    mesh.faces.push_back({0, 1, 17});  // no area
    mesh.faces.push_back({5, 6, 10});  // again, the other way round and over itself
    mesh.faces.push_back({5, 10, 6});
    TriangleMesh collapsed = mapped(mesh, wobble);
    for (const int i : {0, 1, 4, 5}) collapsed.vertices[at(i)] = {1, 1, 1};
    const TriangleMesh point = mapped(mesh, [](const Vector3d&) { return Vector3d::Zero(); });
    const FeatureSet set =
        extract_features(sequence_of({mesh, collapsed, point}), mesh.vertices, {});
    expect_finite(set);
    EXPECT_THAT(set.warnings, Contains(HasSubstr("without area carry no weight")));
    EXPECT_THAT(set.warnings, Contains(HasSubstr("without faces get the identity")));
    EXPECT_THAT(set.warnings, Contains(HasSubstr("faces without area in")));
    for (int k = 0; k < kFeatureDim; ++k) {
        EXPECT_EQ(feature(set, 16, 1)[k], kReferenceFeature[at(k)]);
    }
}

TEST(Extract, FeaturesDoNotDependOnTheUnit) {
    const TriangleMesh mesh = bumpy_sphere(2), shape = mapped(mesh, wobble);
    const FeatureSet one = extract_one(mesh, shape, true);
    for (const double unit : {1e-8, 1e8}) {
        const auto scale = [=](const Vector3d& p) -> Vector3d { return unit * p; };
        const FeatureSet scaled = extract_one(mapped(mesh, scale), mapped(shape, scale), true);
        for (std::size_t k = 0; k < one.features.size(); ++k) {
            ASSERT_NEAR(scaled.features[k], one.features[k], 1e-6);
        }
    }
}

// Feature of vertex i = feature of its new number: nothing depends on the order of vertices.
TEST(Extract, CommutesWithRenumberingTheVertices) {
    const TriangleMesh mesh = bumpy_sphere(2);
    const TriangleMesh shape = mapped(mesh, [](const Vector3d& p) -> Vector3d {
        return rotation_about({0.2, 1, 0}, 3.5 * p.y()) * p;
    });
    const std::vector<int> number = CounterRandom(3, 4).permutation(mesh.vertex_count());
    const auto renumbered = [&](const TriangleMesh& from) {
        TriangleMesh to = from;
        for (std::size_t i = 0; i < number.size(); ++i)
            to.vertices[at(number[i])] = from.vertices[i];
        for (Face& face : to.faces) {
            for (int& corner : face) corner = number[at(corner)];
        }
        return to;
    };
    const FeatureSet plain = extract_one(mesh, shape);
    const FeatureSet other = extract_one(renumbered(mesh), renumbered(shape));
    EXPECT_GT(plain.consistency_energy[0], 1);
    EXPECT_NEAR(plain.consistency_energy[0], other.consistency_energy[0], 1e-9);
    for (int i = 0; i < mesh.vertex_count(); ++i) {
        for (int k = 0; k < kFeatureDim; ++k) {
            ASSERT_NEAR(feature(plain, i)[k], feature(other, number[at(i)])[k], 2e-6);
        }
    }
}

// Shapes that twist up to several turns, so that turns have to be chosen.
std::vector<TriangleMesh> turning_shapes(int count) {
    std::vector<TriangleMesh> shapes;
    for (int n = 0; n < count; ++n) {
        shapes.push_back(mapped(bumpy_sphere(2), [=](const Vector3d& p) -> Vector3d {
            return rotation_about({1, 0.1 * n, 0}, 0.9 * (n % 6) * p.x()) * p;
        }));
    }
    return shapes;
}

void expect_same_bits(const FeatureSet& got, const FeatureSet& wanted) {
    EXPECT_EQ(std::memcmp(got.features.data(), wanted.features.data(),
                          wanted.features.size() * sizeof(float)),
              0);
    EXPECT_EQ(got.vertices, wanted.vertices);
    EXPECT_EQ(got.rotation, wanted.rotation);
    EXPECT_EQ(got.translation, wanted.translation);
    EXPECT_EQ(got.principal_energy, wanted.principal_energy);
    EXPECT_EQ(got.propagation_energy, wanted.propagation_energy);
    EXPECT_THAT(got.relaxation_energy,
                testing::Pointwise(testing::NanSensitiveDoubleEq(), wanted.relaxation_energy));
    EXPECT_EQ(got.consistency_energy, wanted.consistency_energy);
    EXPECT_EQ(got.consistency_gap, wanted.consistency_gap);
    EXPECT_EQ(got.largest_jump, wanted.largest_jump);
    EXPECT_EQ(got.large_jumps, wanted.large_jumps);
    EXPECT_EQ(got.inherent_jumps, wanted.inherent_jumps);
    EXPECT_EQ(got.removable_jumps, wanted.removable_jumps);
    EXPECT_EQ(got.warnings, wanted.warnings);
}

TEST(Extract, IsBitIdenticalForAnyNumberOfThreadsInMemoryAndInAFile) {
    const std::vector<TriangleMesh> shapes = turning_shapes(10);  // more than a chunk of one thread
    const MeshSequence sequence = sequence_of(shapes);
    set_thread_count(1);
    const FeatureSet wanted = extract_features(sequence, shapes[0].vertices);
    EXPECT_GT(*std::max_element(wanted.largest_jump.begin(), wanted.largest_jump.end()), 1);
    const TemporaryFolder folder;
    for (const int threads : {1, 2, 7}) {
        set_thread_count(threads);
        expect_same_bits(extract_features(sequence, shapes[0].vertices), wanted);
        const SequenceSource source(sequence);
        FeatureFileWriter file(folder / "f", feature_outline(source, shapes[0].vertices));
        const FeatureSet rest = extract_features(source, shapes[0].vertices, {}, file);
        EXPECT_TRUE(rest.features.empty());
        file.finish(rest);
        expect_same_bits(read_features(folder / "f"), wanted);
    }
    set_thread_count(0);
}

// The energies of one shape: the result is never above any start, never below the bound.
TEST(Extract, EnergiesAreInOrder) {
    const std::vector<TriangleMesh> shapes = turning_shapes(9);
    const FeatureSet set = extract_features(sequence_of(shapes), shapes[0].vertices);
    for (std::size_t n = 0; n < shapes.size(); ++n) {
        const double energy = set.consistency_energy[n], rounding = 1e-6 * (1 + energy);
        EXPECT_TRUE(energy <= set.principal_energy[n] + rounding) << n;
        EXPECT_TRUE(energy <= set.propagation_energy[n] + rounding) << n;
        EXPECT_FALSE(energy > set.relaxation_energy[n] + rounding) << n;
        EXPECT_TRUE(set.consistency_gap[n] >= -rounding) << n;
    }
}

// Counted again from the features, edge by edge, on shapes of which one is scrambled: there axes of
// neighbours have nothing to do with each other, and no turns keep them together.
TEST(Extract, LargeJumpsAreTheEdgesAbovePi) {
    std::vector<TriangleMesh> shapes = turning_shapes(3);
    TriangleMesh scrambled = shapes[0];
    const CounterRandom random(5, 0);
    std::uint64_t draw = 0;
    for (Point& p : scrambled.vertices) {
        for (double& x : p) x = random.normal(draw++);
    }
    shapes.push_back(scrambled);
    const FeatureSet set = extract_features(sequence_of(shapes), shapes[0].vertices);
    std::set<std::pair<int, int>> edges;
    for (const Face& face : set.reference.faces) {
        for (std::size_t k = 0; k < 3; ++k) edges.insert(std::minmax({face[k], face[(k + 1) % 3]}));
    }
    for (int n = 0; n < set.shape_count(); ++n) {
        int large = 0;
        for (const auto& [i, j] : edges) {
            const Vector3d difference = rotation_vector(set, i, n) - rotation_vector(set, j, n);
            large += difference.norm() > std::numbers::pi ? 1 : 0;
        }
        EXPECT_EQ(set.large_jumps[at(n)], large) << n;
        EXPECT_TRUE(0 <= set.inherent_jumps[at(n)] && set.inherent_jumps[at(n)] <= large) << n;
        EXPECT_TRUE(0 <= set.removable_jumps[at(n)] && set.removable_jumps[at(n)] <= large) << n;
    }
    EXPECT_GT(set.large_jumps.back(), 0);
}

/// Shapes of which one cannot be read.
class BrokenSource final : public ShapeSource {
  public:
    BrokenSource(const MeshSequence& sequence, int broken) : sequence_(sequence), broken_(broken) {}
    const std::vector<std::string>& names() const override { return sequence_.names; }
    const std::vector<Face>& faces() const override { return sequence_.faces; }
    int vertex_count() const override { return sequence_.vertex_count(); }
    std::vector<Point> shape(int index) const override {
        if (index == broken_) throw InputError({"late.obj", 7}, "broken");
        return sequence_.shapes[at(index)];
    }

  private:
    const MeshSequence& sequence_;
    int broken_;
};

TEST(Extract, AShapeThatCannotBeReadLeavesNoFile) {
    const MeshSequence sequence = sequence_of(turning_shapes(5));
    const TemporaryFolder folder;
    for (const int broken : {0, 4}) {
        const BrokenSource source(sequence, broken);
        const std::string message = thrown_message<InputError>([&] {
            FeatureFileWriter file(folder / "f", feature_outline(source, sequence.shapes[0]));
            extract_features(source, sequence.shapes[0], {}, file);
        });
        EXPECT_EQ(message, "late.obj:7: broken");
        EXPECT_THAT(folder.names(), testing::IsEmpty());
    }
}

// What progress throws comes through at any time: so an extraction is stopped.
TEST(Extract, CanBeStoppedAtEveryStep) {
    const std::vector<TriangleMesh> shapes = turning_shapes(4);
    struct Stop {};
    int steps = 0;
    extract_features(sequence_of(shapes), shapes[0].vertices, {}, [&](int, int) { ++steps; });
    EXPECT_GE(steps, 12);
    for (int last = 1; last <= steps; ++last) {
        int step = 0;
        EXPECT_THROW(extract_features(sequence_of(shapes), shapes[0].vertices, {},
                                      [&](int, int) {
                                          if (++step == last) throw Stop{};
                                      }),
                     Stop);
    }
}

TEST(Extract, ReportsProgressUpToTheNumberOfShapes) {
    const TriangleMesh mesh = bumpy_sphere(1);
    std::vector<int> seen;
    extract_features(sequence_of({mesh, mesh, mesh, mesh}), mesh.vertices, {},
                     [&](int done, int total) {
                         EXPECT_EQ(total, 4);
                         seen.push_back(done);
                     });
    EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
    EXPECT_THAT(seen, testing::IsSupersetOf({1, 2, 3, 4}));
}

TEST(Extract, RefusesShapesOfAnotherSize) {
    const TriangleMesh mesh = bumpy_sphere(1);
    TriangleMesh longer = mesh;
    longer.vertices.push_back({0, 0, 0});
    EXPECT_THROW(extract_features(sequence_of({mesh, longer}), mesh.vertices), MeshError);
    EXPECT_THROW(extract_features(sequence_of({mesh}), longer.vertices), MeshError);
}

}  // namespace
}  // namespace mscomp
