// SPDX-License-Identifier: MIT
// check: what is odd about single shapes. Each kind has a case that has it and one that nearly has
// it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "acap/check/check_frame.h"
#include "check_cases.h"
#include "mscomp/base/random.h"

namespace mscomp {
namespace {

using namespace cases;
using testing::HasSubstr;

/// Meshes whose vertices are numbered along the surface, and ones where they are not.
struct NamedMesh {
    const char* name;
    TriangleMesh mesh;
};
std::vector<NamedMesh> references() {
    return {{"sphere 42", bumpy_sphere(1)},
            {"sphere 642", bumpy_sphere(3)},
            {"closed cylinder", shapes::cylinder(24, 20, 1, 8, true)},
            {"open cylinder", shapes::cylinder(12, 40, 1, 12, false)},
            {"grid", shapes::grid(30, 20)}};
}
TriangleMesh deformed(const TriangleMesh& mesh) {
    return mapped(mesh, [](const Vector3d& p) -> Vector3d {
        return rotation_about({1, 2, 0}, 0.05 * p.x()) * p + Vector3d(0, 0, 0.02 * p.y() * p.y());
    });
}

bool seems_permuted(const TriangleMesh& reference, const TriangleMesh& shape) {
    return count_of(check_pair(reference, shape), "permuted_vertices") > 0;
}

TEST(CheckOrder, FindsRandomPermutations) {
    for (const auto& [name, mesh] : references()) {
        for (std::uint64_t seed = 0; seed < 3; ++seed) {
            const std::vector<int> source = CounterRandom(seed, 1).permutation(mesh.vertex_count());
            EXPECT_TRUE(seems_permuted(mesh, renumbered(deformed(mesh), source)))
                << name << ", seed " << seed;
        }
    }
}

TEST(CheckOrder, FindsSwappedHalvesAndShiftsByOne) {
    for (const auto& [name, mesh] : references()) {
        for (const int by : {mesh.vertex_count() / 2, (mesh.vertex_count() + 1) / 2, 1, -1}) {
            EXPECT_TRUE(seems_permuted(mesh, shifted(deformed(mesh), by))) << name << " by " << by;
        }
    }
}

TEST(CheckOrder, FindsThemInAnyUnit) {
    for (const double scale : {1e-3, 1e3}) {
        const TriangleMesh large =
            mapped(bumpy_sphere(3), [=](const Vector3d& p) -> Vector3d { return scale * p; });
        EXPECT_TRUE(seems_permuted(bumpy_sphere(3), shifted(large, 1)));
        EXPECT_FALSE(seems_permuted(bumpy_sphere(3), large));
    }
}

TEST(CheckOrder, StrongDeformationsAreNoPermutations) {
    for (const auto& [name, mesh] : references()) {
        EXPECT_FALSE(seems_permuted(mesh, deformed(mesh))) << name;
    }
    const TriangleMesh bar = shapes::cylinder(24, 60, 1, 12, true);
    EXPECT_FALSE(seems_permuted(bar, twisted(bar, 2.5, 12)));
    const TriangleMesh sheet = shapes::grid(60, 20);
    const TriangleMesh rolled = mapped(sheet, [](const Vector3d& p) -> Vector3d {
        const double angle = 0.4 * p.x(), radius = 2.5 - 0.02 * p.x();
        return {radius * std::cos(angle), p.y(), radius * std::sin(angle)};
    });
    EXPECT_FALSE(seems_permuted(sheet, rolled));
    const TriangleMesh pulled = mapped(sheet, [](const Vector3d& p) -> Vector3d {
        return {5 * p.x(), p.y(), 0};
    });
    EXPECT_FALSE(seems_permuted(sheet, pulled));
}

/// A bar along z that is rolled up to a ball, like a cat that curls up.
TriangleMesh curled(const TriangleMesh& bar, double turns, double length) {
    return mapped(bar, [=](const Vector3d& p) -> Vector3d {
        const double angle = 2 * std::numbers::pi * turns * p.z() / length;
        const double radius = length / (2 * std::numbers::pi * turns) - 0.8 * p.x();
        return {radius * std::cos(angle), p.y() + 0.4 * angle, radius * std::sin(angle)};
    });
}

// Small beside its edges, stretched here and pressed there, and torn open like a beak: all in
// order.
TEST(CheckOrder, CurledUpAndPulledApartIsNoPermutation) {
    const TriangleMesh bar = shapes::cylinder(24, 90, 0.5, 12, true);
    for (const double turns : {0.5, 1.0, 2.0, 3.0}) {
        EXPECT_FALSE(seems_permuted(bar, curled(bar, turns, 12))) << turns;
    }
    const TriangleMesh squashed = mapped(curled(bar, 1.5, 12), [](const Vector3d& p) -> Vector3d {
        return {3 * p.x(), 0.2 * p.y(), p.z() * p.z() * p.z()};
    });
    EXPECT_FALSE(seems_permuted(bar, squashed));
    const TriangleMesh sheet = shapes::grid(40, 40);
    for (const double width : {1.0, 3.0, 8.0}) {
        const TriangleMesh pulled = mapped(sheet, [=](const Vector3d& p) -> Vector3d {
            const double way = std::clamp((p.x() - 19) / width, 0.0, 1.0);
            return {p.x() + 30 * way, p.y(), 0};
        });
        EXPECT_FALSE(seems_permuted(sheet, pulled)) << width;
    }
}

// Fifty vertices in a patch, or two that are exchanged, in shapes that are curled up as well.
TEST(CheckOrder, FindsAFewVerticesOutOfOrder) {
    const TriangleMesh bar = shapes::cylinder(24, 90, 0.5, 12, true);
    const OneRings rings = one_rings_of_faces(bar.vertex_count(), bar.faces);
    for (int seed = 0; seed < 20; ++seed) {
        const TriangleMesh shape = curled(bar, 0.1 * (seed + 1), 12);
        const CounterRandom random(5, static_cast<std::uint64_t>(seed));
        const int first = static_cast<int>(random.uniform(0) * bar.vertex_count());
        EXPECT_TRUE(seems_permuted(bar, shuffled_patch(shape, rings, first, 50, seed))) << seed;
        const int other = (first + 700) % bar.vertex_count();
        EXPECT_TRUE(seems_permuted(bar, exchanged(shape, first, other))) << seed;
    }
}

// Two blocks of rows changed places: no shift explains it, and nearly all edges are as before.
TEST(CheckOrder, FindsBlocksThatChangedPlaces) {
    const TriangleMesh mesh = shapes::grid(20, 60);
    std::vector<int> source;
    for (int i = 0; i < mesh.vertex_count(); ++i) source.push_back(i);
    std::swap_ranges(source.begin() + 200, source.begin() + 400, source.begin() + 800);
    const Finding found =
        finding(check_pair(mesh, renumbered(deformed(mesh), source)), "permuted_vertices");
    EXPECT_EQ(found.count, 1);
}

TEST(CheckOrder, AnotherOrderIsNotAnotherUnit) {
    EXPECT_EQ(count_of(check_pair(bumpy_sphere(3), shifted(bumpy_sphere(3), 1)), "other_scale"), 0);
}

// Rows 0 to 9 of forty vertices stay: the first vertex out of place is in row 9 or 10.
TEST(CheckOrder, NamesTheFirstVertexOutOfPlace) {
    const TriangleMesh mesh = shapes::grid(40, 30);
    std::vector<int> source = CounterRandom(3, 1).permutation(800);
    for (int& index : source) index += 400;
    for (int i = 0; i < 400; ++i) source.insert(source.begin() + i, i);
    const CheckReport report = check_pair(mesh, renumbered(mesh, source));
    const Finding found = finding(report, "permuted_vertices");
    ASSERT_EQ(found.count, 1);
    EXPECT_GT(found.places.at(0).vertex, 360);
    EXPECT_LE(found.places.at(0).vertex, 440);
}

TEST(CheckOrder, SuspectsTheReferenceIfMostShapesDisagreeWithIt) {
    CheckedShapes shapes;
    shapes.add(shifted(bumpy_sphere(2), 1));
    for (int k = 0; k < 3; ++k)
        shapes.add(mapped(bumpy_sphere(2), [=](const Vector3d& p) -> Vector3d {
            return p + 0.1 * k * p.cwiseProduct(p);
        }));
    EXPECT_THAT(finding(shapes.check(), "permuted_vertices").advice, HasSubstr("the reference"));
}

TriangleMesh with_spike(TriangleMesh mesh, std::size_t vertex, double factor) {
    for (double& coordinate : mesh.vertices[vertex]) coordinate *= factor;
    return mesh;
}

TEST(CheckStrays, FindsASpikeAndOnlyThat) {
    const TriangleMesh mesh = bumpy_sphere(3);
    const CheckReport report = check_pair(mesh, with_spike(mesh, 100, 5));
    const Finding strays = finding(report, "stray_vertices");
    ASSERT_EQ(strays.count, 1);
    EXPECT_EQ(strays.places.at(0).vertex, 101);
    EXPECT_EQ(count_of(report, "permuted_vertices"), 0);
    EXPECT_EQ(count_of(check_pair(mesh, with_spike(mesh, 100, 1.3)), "stray_vertices"), 0);
}

TEST(CheckStrays, FindsASpikeOfTheReference) {
    CheckedShapes shapes;
    shapes.add(with_spike(bumpy_sphere(3), 7, 5));
    for (const double x : {1.0, 1.1, 1.2}) {
        shapes.add(mapped(bumpy_sphere(3), [=](const Vector3d& p) -> Vector3d {
            return {x * p.x(), p.y(), p.z()};
        }));
    }
    const CheckReport report = shapes.check();
    EXPECT_EQ(finding(report, "reference_stray_vertices").count, 1);
    EXPECT_EQ(finding(report, "reference_stray_vertices").places.at(0).vertex, 8);
    EXPECT_EQ(count_of(report, "stray_vertices"), 0);
}

TEST(CheckMirrors, FindsAMirrorImageButNoHalfTurn) {
    const TriangleMesh mesh = bumpy_sphere(3);
    const TriangleMesh bent = mapped(mesh, wobble);
    const auto flipped = [](const TriangleMesh& m) {
        return mapped(m, [](const Vector3d& p) -> Vector3d { return {-p.x(), p.y(), p.z()}; });
    };
    EXPECT_EQ(count_of(check_pair(mesh, flipped(mesh)), "mirrored_frames"), 1);
    EXPECT_EQ(count_of(check_pair(mesh, flipped(bent)), "mirrored_frames"), 1);
    EXPECT_EQ(count_of(check_pair(mesh, bent), "mirrored_frames"), 0);
    EXPECT_EQ(count_of(check_pair(mesh, flipped(flipped(bent))), "mirrored_frames"), 0);
    // A flat sheet turned over is a rotation.
    const TriangleMesh sheet = shapes::grid(8, 8);
    EXPECT_EQ(count_of(check_pair(sheet, flipped(sheet)), "mirrored_frames"), 0);
}

// In a square grid c = 1 along the axes, so M = 2 in the plane but for the floor of the diagonals:
// moving the neighbour by -k e makes det T = 1 - k/2.
TEST(CheckMirrors, CountsVerticesThatAreTurnedOver) {
    TriangleMesh mesh = shapes::grid(9, 9);
    const auto moved = [mesh](double k) {
        TriangleMesh shape = mesh;
        shape.vertices[4 * 9 + 4][0] -= k;
        return shape;
    };
    const Finding found = finding(check_pair(mesh, moved(3)), "mirrored_vertices");
    EXPECT_GE(found.count, 1);
    EXPECT_EQ(found.places.at(0).vertex, 4 * 9 + 3 + 1);
    EXPECT_EQ(count_of(check_pair(mesh, moved(1.5)), "mirrored_vertices"), 0);
}

TriangleMesh scaled(const TriangleMesh& mesh, double factor) {
    return mapped(mesh, [=](const Vector3d& p) -> Vector3d { return factor * p; });
}

TEST(CheckScale, FindsOtherUnits) {
    const TriangleMesh mesh = bumpy_sphere(2);
    EXPECT_THAT(finding(check_pair(mesh, scaled(mesh, 1000)), "other_scale").places.at(0).text,
                HasSubstr("1000 times as large, as millimetres to metres"));
    EXPECT_THAT(finding(check_pair(mesh, scaled(mesh, 0.0254)), "other_scale").places.at(0).text,
                HasSubstr("39.37 times smaller"));
    EXPECT_EQ(count_of(check_pair(mesh, scaled(mesh, 1.8)), "other_scale"), 0);
}

// Rolled up, a sheet is much smaller from end to end, but every edge is as long as before.
TEST(CheckScale, ARolledSheetHasNoOtherUnit) {
    const TriangleMesh sheet = shapes::grid(100, 10);
    const TriangleMesh rolled = mapped(sheet, [](const Vector3d& p) -> Vector3d {
        return {3 * std::cos(p.x() / 3), p.y(), 3 * std::sin(p.x() / 3)};
    });
    EXPECT_LT(rms_radius(rolled.vertices), rms_radius(sheet.vertices) / 5);
    EXPECT_EQ(count_of(check_pair(sheet, rolled), "other_scale"), 0);
}

TEST(CheckScale, FarFromTheOriginIsAWarning) {
    const auto both_at = [](double x) {
        const TriangleMesh mesh = mapped(bumpy_sphere(2), [x](const Vector3d& p) -> Vector3d {
            return {p.x() + x, p.y(), p.z()};
        });
        return check_pair(mesh, mesh);
    };
    EXPECT_EQ(finding(both_at(1e4), "far_from_origin").severity, Severity::warning);
    EXPECT_EQ(count_of(both_at(1e4), "far_from_origin"), 2);
    EXPECT_EQ(count_of(both_at(150), "far_from_origin"), 0);  // about 75 diameters
}

TEST(CheckScale, FarAwayIsANote) {
    const auto away = [](double distance) {
        return mapped(bumpy_sphere(2), [=](const Vector3d& p) -> Vector3d {
            return {p.x() + distance, p.y(), 1.05 * p.z()};
        });
    };
    const Finding found = finding(check_pair(bumpy_sphere(2), away(100)), "far_away");
    EXPECT_EQ(found.count, 1);
    EXPECT_EQ(found.severity, Severity::note);
    EXPECT_EQ(count_of(check_pair(bumpy_sphere(2), away(5)), "far_away"), 0);
}

TEST(CheckScale, CoordinatesBeyondComputingAreAnError) {
    TriangleMesh shape = bumpy_sphere(1);
    shape.vertices[3][1] = 1e200;
    const Finding found = finding(check_pair(bumpy_sphere(1), shape), "not_finite");
    EXPECT_EQ(found.count, 1);
    EXPECT_EQ(found.severity, Severity::error);
    shape.vertices[3][1] = 1e20;
    EXPECT_EQ(count_of(check_pair(bumpy_sphere(1), shape), "not_finite"), 0);
}

/// A sheet whose columns from x = 4 on are turned by `angle` about the line x = 4.
TriangleMesh folded(double angle) {
    return mapped(shapes::grid(9, 9), [=](const Vector3d& p) -> Vector3d {
        if (p.x() <= 4) return p;
        return {4 + (p.x() - 4) * std::cos(angle), p.y(), (p.x() - 4) * std::sin(angle)};
    });
}

// Folded flat, half the faces around an inner vertex of the fold look up and half look down.
TEST(CheckFolds, FindsRingsWhoseNormalsCancel) {
    const CheckReport report = check_pair(shapes::grid(9, 9), folded(std::numbers::pi));
    EXPECT_EQ(count_of(report, "folded_rings"), 7);
    EXPECT_EQ(finding(report, "folded_rings").places.at(0).vertex, 9 + 4 + 1);
    EXPECT_EQ(count_of(check_pair(shapes::grid(9, 9), folded(2.5)), "folded_rings"), 0);
}

TEST(CheckFolds, ThoseOfTheReferenceAreFoundThere) {
    const CheckReport report = check_pair(folded(std::numbers::pi), folded(std::numbers::pi));
    EXPECT_EQ(count_of(report, "reference_folded_rings"), 7);
    EXPECT_EQ(count_of(report, "folded_rings"), 0);
}

TEST(CheckFolds, FindsFacesWithoutArea) {
    const TriangleMesh mesh = bumpy_sphere(2);
    const auto squeezed = [&](double share) {  // face 10, one corner on the opposite edge
        TriangleMesh shape = mesh;
        const auto [a, b, c] = shape.faces[10];
        const Vector3d middle = (vec(shape.vertices[at(a)]) + vec(shape.vertices[at(b)])) / 2;
        shape.vertices[at(c)] = point(middle + share * (vec(shape.vertices[at(c)]) - middle));
        return shape;
    };
    const CheckReport report = check_pair(mesh, squeezed(0));
    EXPECT_EQ(count_of(report, "reference_zero_area_faces"), 0);
    EXPECT_EQ(count_of(check_pair(mesh, squeezed(1e-3)), "zero_area_faces"), 0);
    TriangleMesh point_face = mesh;
    const auto [a, b, c] = mesh.faces[10];
    point_face.vertices[at(c)] = point_face.vertices[at(b)];
    const Finding found = finding(check_pair(mesh, point_face), "zero_area_faces");
    EXPECT_EQ(found.count, 2);  // the two faces at the edge that vanished
    EXPECT_LE(found.places.at(0).face, 11);
    EXPECT_EQ(count_of(check_pair(point_face, mesh), "reference_zero_area_faces"), 2);
}

// A uniform scale s has S = s I everywhere.
TEST(CheckRange, LargestStretchAndQuantileOfAUniformScale) {
    const StretchRange range = check_pair(bumpy_sphere(2), scaled(bumpy_sphere(2), 1.5)).stretch;
    EXPECT_NEAR(range.largest, 0.5, 1e-6);
    EXPECT_NEAR(range.most_below, 0.5, 0.01);
}

TEST(CheckRange, QuantilesOfTheHistogramAreWithinTwoPercent) {
    StretchHistogram histogram;
    EXPECT_EQ(histogram.quantile(0.5), 0);
    for (int k = 1; k <= 1000; ++k) histogram.add(1e-3 * k);
    histogram.add(std::numeric_limits<double>::quiet_NaN());
    for (const double share : {0.1, 0.5, 0.999}) {
        EXPECT_GE(histogram.quantile(share), share);
        EXPECT_LE(histogram.quantile(share), 1.02 * share);
    }
    StretchHistogram sum;
    sum.add(histogram);
    sum.add(histogram);
    EXPECT_EQ(sum.quantile(0.3), histogram.quantile(0.3));
}

TEST(CheckRange, FindsTheVertexThatSpoilsTheScaling) {
    const TriangleMesh mesh = bumpy_sphere(4);
    CheckedShapes shapes, clean;
    for (const double x : {1.0, 1.05, 1.1, 1.15}) {
        const TriangleMesh shape = mapped(mesh, [=](const Vector3d& p) -> Vector3d {
            return {x * p.x(), p.y(), p.z()};
        });
        shapes.add(x == 1.1 ? with_spike(shape, 1000, 1.35) : shape);
        clean.add(shape);
    }
    const Finding found = finding(shapes.check(), "stretch_outlier");
    ASSERT_EQ(found.count, 1);
    EXPECT_EQ(found.places.at(0).file, shapes.path("frame_2.obj"));
    EXPECT_EQ(count_of(clean.check(), "stretch_outlier"), 0);
}

// Two spheres that share an edge only, one of them turned about it as a whole.
TEST(CheckRange, FindsNeighboursThatTurnAgainstEachOther) {
    TriangleMesh mesh = bumpy_sphere(1);
    const int count = mesh.vertex_count();
    for (int i = 0; i < count; ++i) {
        mesh.vertices.push_back(point(vec(mesh.vertices[at(i)]) + Vector3d(4, 0, 0)));
    }
    const std::size_t faces = mesh.faces.size();
    for (std::size_t f = 0; f < faces; ++f) {
        const Face face = mesh.faces[f];
        mesh.faces.push_back({face[0] + count, face[1] + count, face[2] + count});
    }
    mesh.faces.push_back({5, 5, 5 + count});
    const auto turned = [&](double degrees) {
        TriangleMesh shape = mesh;
        const Vector3d pivot = vec(mesh.vertices[at(5 + count)]);
        for (int i = count; i < 2 * count; ++i) {
            shape.vertices[at(i)] =
                point(pivot + rotation_about(Vector3d::UnitX(), degrees * std::numbers::pi / 180) *
                                  (vec(mesh.vertices[at(i)]) - pivot));
        }
        return shape;
    };
    const Finding found = finding(check_pair(mesh, turned(170)), "sharp_turns");
    ASSERT_EQ(found.count, 1);
    EXPECT_THAT(found.places.at(0).text, HasSubstr("170 degrees at vertex 6"));
    EXPECT_EQ(count_of(check_pair(mesh, turned(140)), "sharp_turns"), 0);
}

}  // namespace
}  // namespace mscomp
