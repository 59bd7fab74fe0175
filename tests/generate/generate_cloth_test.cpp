// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>

#include "generated_cases.h"
#include "mscomp/acap/extract.h"
#include "mscomp/base/error.h"

namespace mscomp {
namespace {

using namespace cases;

const GeneratedSequence& cloth() {
    static const GeneratedSequence generated = generate_cloth();
    return generated;
}

/// Largest and smallest length of an edge of a frame relative to its length at rest, those edges
/// alone of which both ends pass `which`.
template <class Which>
std::array<double, 2> length_ratios(const GeneratedSequence& g, int frame, const Which& which) {
    const auto& rest = g.sequence.shapes[0];
    const auto& shape = g.sequence.shapes[static_cast<std::size_t>(frame)];
    std::array<double, 2> range{1, 1};
    for (const auto& [side, count] : sides_of(g.sequence.faces)) {
        if (!which(side[0]) || !which(side[1])) continue;
        const auto a = static_cast<std::size_t>(side[0]), b = static_cast<std::size_t>(side[1]);
        const double ratio = norm(minus(shape[a], shape[b])) / norm(minus(rest[a], rest[b]));
        if (!(ratio >= range[0])) range[0] = ratio;
        if (!(ratio <= range[1])) range[1] = ratio;
    }
    return range;
}

// One boundary loop around a disc: V - E + F = 1.
TEST(Cloth, IsASheetWithOneBoundary) {
    EXPECT_TRUE(is_oriented_manifold(cloth().sequence.faces));
    EXPECT_EQ(euler_characteristic(cloth().sequence), 1);
    EXPECT_EQ(boundary_edges(cloth().sequence.faces), 2 * (69 + 44 - 2));
    EXPECT_GE(cloth().sequence.vertex_count(), 3000);
    EXPECT_LE(cloth().sequence.vertex_count(), 3100);
    EXPECT_GE(generate_cloth(2, 0, 100).sequence.vertex_count(), 100);
}

TEST(Cloth, LiesExactlyFlatInTheFirstFrameFacingUp) {
    for (int k = 0; k < cloth().component_count(); ++k) EXPECT_EQ(weight(cloth(), 0, k), 0);
    for (const Point& p : cloth().sequence.shapes[0]) EXPECT_EQ(p[2], 0);
    for (const Face& f : cloth().sequence.faces) {
        EXPECT_GT(face_normal(cloth().sequence.shapes[0], f)[2], 0);
    }
}

TEST(Cloth, HasEvenTriangles) {
    const std::vector<double> sizes = areas(cloth().sequence.shapes[0], cloth().sequence.faces);
    for (const double size : sizes) EXPECT_NEAR(size / sizes[0], 1, 1e-9);
    const std::vector<double> lengths =
        edge_lengths(cloth().sequence.shapes[0], cloth().sequence.faces);
    EXPECT_LE(*std::ranges::max_element(lengths), 1.6 * *std::ranges::min_element(lengths));
}

// Bending keeps lengths: what remains away from all wrinkles is the chord of an arc, which goes
// down with the square of the edge length.
TEST(Cloth, BendsWithoutStretchingOutsideTheWrinkles) {
    const auto largest_change = [](const GeneratedSequence& g, int frames) {
        const auto unwrinkled = [&g](int i) {
            for (int k = 0; k < g.component_count(); ++k) {
                if (g.scales[static_cast<std::size_t>(k)] == 1 && support(g, k, i) > 0)
                    return false;
            }
            return true;
        };
        double worst = 0;
        for (int n = 1; n < frames; ++n) {
            const auto [shortest, longest] = length_ratios(g, n, unwrinkled);
            EXPECT_LE(longest, 1 + 1e-3) << "frame " << n;
            worst = std::max(worst, 1 - shortest);
        }
        return worst;
    };
    const double coarse = largest_change(generate_cloth(9, 3, 3000), 9);
    const double fine = largest_change(generate_cloth(9, 3, 12000), 9);
    EXPECT_LE(coarse, 0.06);
    EXPECT_LE(fine, 0.3 * coarse);
}

TEST(Cloth, StretchesLittleInTheWrinkles) {
    for (int n = 1; n < cloth().sequence.shape_count(); ++n) {
        const auto [shortest, longest] = length_ratios(cloth(), n, [](int) { return true; });
        EXPECT_GE(shortest, 0.85) << "frame " << n;
        EXPECT_LE(longest, 1.13) << "frame " << n;
    }
}

TEST(Cloth, DoesNotFoldOver) {
    for (const auto& shape : cloth().sequence.shapes) {
        EXPECT_GT(least_fold_cosine(shape, cloth().sequence.faces), 0.5);
    }
}

TEST(Cloth, MovesItsComponentsIndependently) {
    EXPECT_TRUE(largest_correlation(cloth()) <= 1e-5) << largest_correlation(cloth());
}

TEST(Cloth, HasSupportsAtTwoScales) {
    double smallest_coarse = 1, largest_fine = 0;
    for (int k = 0; k < cloth().component_count(); ++k) {
        EXPECT_GT(highest_support(cloth(), k), 0.95);
        const double share = support_share(cloth(), k);
        EXPECT_GT(share, 0.02) << k;
        if (cloth().scales[static_cast<std::size_t>(k)] == 1) {
            largest_fine = std::max(largest_fine, share);
        } else if (!cloth().component_names[static_cast<std::size_t>(k)].starts_with("corner")) {
            smallest_coarse = std::min(smallest_coarse, share);
        }
    }
    EXPECT_LT(largest_fine, smallest_coarse);
    EXPECT_LT(largest_fine, 0.12);
}

// Where no component acts, neighbouring vertices move as one rigid piece: edges keep their lengths.
TEST(Cloth, IsRigidOutsideAllSupports) {
    const auto still = [](int i) {
        for (int k = 0; k < cloth().component_count(); ++k) {
            const float value = support(cloth(), k, i);
            if (value > 0 && value < 1) return false;
        }
        return true;
    };
    int count = 0;
    for (int i = 0; i < cloth().sequence.vertex_count(); ++i) count += still(i) ? 1 : 0;
    EXPECT_GT(count, 400);
    for (int n = 1; n < cloth().sequence.shape_count(); ++n) {
        const auto [shortest, longest] = length_ratios(cloth(), n, still);
        EXPECT_GE(shortest, 1 - 1e-9);
        EXPECT_LE(longest, 1 + 1e-9);
    }
}

// Far out on the right side, beyond its arc, the sheet has turned by weight * 75 degrees against
// the flat strip between folds and arc.
TEST(Cloth, TurnsItsSideByTheWeight) {
    const int side = component_named(cloth(), "right_side");
    const auto& rest = cloth().sequence.shapes[0];
    const auto is_flat = [&](const Face& f, double from, double to) {
        for (const int i : f) {
            const Point& p = rest[static_cast<std::size_t>(i)];
            if (p[0] < from || p[0] > to) return false;
            for (int k = 0; k < cloth().component_count(); ++k) {
                const bool fine = cloth().scales[static_cast<std::size_t>(k)] == 1;
                const bool corner =
                    cloth().component_names[static_cast<std::size_t>(k)].starts_with("corner");
                if ((fine || corner) && support(cloth(), k, i) > 0) return false;
            }
        }
        return true;
    };
    for (int n = 1; n < cloth().sequence.shape_count(); ++n) {
        const auto& shape = cloth().sequence.shapes[static_cast<std::size_t>(n)];
        int faces = 0;
        for (const Face& f : cloth().sequence.faces) {
            if (!is_flat(f, 4.45, 7)) continue;
            const Point normal = face_normal(shape, f);
            const double angle = std::atan2(-normal[0], normal[2]) * 180 / 3.14159265358979;
            EXPECT_NEAR(angle, 75 * static_cast<double>(weight(cloth(), n, side)), 1e-3);
            ++faces;
        }
        EXPECT_GT(faces, 50);
    }
}

// The same place moves alike at another resolution.
TEST(Cloth, DeformsAlikeAtAnyResolution) {
    const GeneratedSequence a = generate_cloth(5, 2, 45 * 29);
    const GeneratedSequence b = generate_cloth(5, 2, 3000);
    int compared = 0;
    for (int i = 0; i < a.sequence.vertex_count(); ++i) {
        double off = 0;
        const int j = nearest_vertex(b, a.sequence.shapes[0][static_cast<std::size_t>(i)], off);
        if (off > 0.03) continue;
        ++compared;
        for (std::size_t n = 0; n < 5; ++n) {
            const double distance = norm(minus(a.sequence.shapes[n][static_cast<std::size_t>(i)],
                                               b.sequence.shapes[n][static_cast<std::size_t>(j)]));
            EXPECT_TRUE(distance <= 1.6 * off + 1e-9) << distance << " for " << off;
        }
    }
    EXPECT_GT(compared, 20);
}

TEST(Cloth, IsAFunctionOfItsSeed) {
    EXPECT_EQ(generate_cloth().sequence.shapes, cloth().sequence.shapes);
    EXPECT_NE(generate_cloth(60, 1).sequence.shapes[30], cloth().sequence.shapes[30]);
}

// Every one-ring is flat at rest: the pseudo-edge along the normal keeps the features regular.
TEST(Cloth, ExtractsFromItsFlatReference) {
    const GeneratedSequence small = generate_cloth(4, 0, 600);
    const FeatureSet set = extract_features(small.sequence, small.sequence.shapes[0]);
    for (const float value : set.features) ASSERT_TRUE(std::isfinite(value) && std::abs(value) < 7);
}

TEST(Cloth, RefusesTooLittle) {
    EXPECT_THROW(generate_cloth(1), UsageError);
    EXPECT_THROW(generate_cloth(60, 0, 99), UsageError);
}

}  // namespace
}  // namespace mscomp
