// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "generated_cases.h"
#include "mscomp/base/error.h"
#include "mscomp/base/parallel.h"

namespace mscomp {
namespace {

using namespace cases;

const GeneratedSequence& arm() {
    static const GeneratedSequence generated = generate_arm();
    return generated;
}

TEST(Arm, HasTheSizeAskedFor) {
    EXPECT_GE(arm().sequence.vertex_count(), 3000);
    EXPECT_LE(arm().sequence.vertex_count(), 3200);
    EXPECT_EQ(arm().sequence.shape_count(), 60);
    EXPECT_EQ(arm().sequence.names[59], "frame_0059");
    EXPECT_GE(generate_arm(2, 0, 500).sequence.vertex_count(), 500);
}

TEST(Arm, IsATopologicalSphereTurnedOutwards) {
    EXPECT_TRUE(is_oriented_manifold(arm().sequence.faces));
    EXPECT_EQ(boundary_edges(arm().sequence.faces), 0);
    EXPECT_EQ(euler_characteristic(arm().sequence), 2);
    EXPECT_GT(volume(arm().sequence.shapes[0], arm().sequence.faces), 8);
    EXPECT_LT(volume(arm().sequence.shapes[0], arm().sequence.faces), 30);
}

TEST(Arm, HasEvenTriangles) {
    const std::vector<double> sizes = areas(arm().sequence.shapes[0], arm().sequence.faces);
    EXPECT_GE(*std::min_element(sizes.begin(), sizes.end()), 0.4 * mean(sizes));
    EXPECT_LE(*std::max_element(sizes.begin(), sizes.end()), 2.0 * mean(sizes));
}

TEST(Arm, IsFiniteAndHasNoFlatTriangleInAnyFrame) {
    for (const std::vector<Point>& shape : arm().sequence.shapes) {
        for (const Point& p : shape) ASSERT_TRUE(std::isfinite(p[0] + p[1] + p[2]));
        const std::vector<double> sizes = areas(shape, arm().sequence.faces);
        EXPECT_GE(*std::min_element(sizes.begin(), sizes.end()), 0.05 * mean(sizes));
    }
}

// Weights of 0 leave the limb straight: the first frame is the reference.
TEST(Arm, StartsWithTheReference) {
    for (int k = 0; k < arm().component_count(); ++k) EXPECT_EQ(weight(arm(), 0, k), 0);
    double widest = 0, longest = 0;
    for (const Point& p : arm().sequence.shapes[0]) {
        widest = std::max(widest, std::hypot(p[0], p[1]));
        longest = std::max(longest, p[2]);
    }
    EXPECT_LT(widest, 1.1);
    EXPECT_NEAR(longest, 12, 1e-9);
}

TEST(Arm, IsAFunctionOfItsSeed) {
    const GeneratedSequence again = generate_arm();
    const GeneratedSequence other = generate_arm(60, 1);
    EXPECT_EQ(again.sequence.shapes, arm().sequence.shapes);
    EXPECT_EQ(again.weights, arm().weights);
    EXPECT_EQ(other.sequence.shapes[0], arm().sequence.shapes[0]);
    EXPECT_NE(other.weights, arm().weights);
    EXPECT_NE(other.sequence.shapes[30], arm().sequence.shapes[30]);
}

TEST(Arm, IsBitwiseEqualForAnyNumberOfThreads) {
    for (const int threads : {1, 2, 7}) {
        set_thread_count(threads);
        EXPECT_EQ(generate_arm().sequence.shapes, arm().sequence.shapes) << threads;
    }
    set_thread_count(0);
}

TEST(Arm, HasSupportsThatAreNeitherEmptyNorEverything) {
    for (int k = 0; k < arm().component_count(); ++k) {
        EXPECT_EQ(highest_support(arm(), k), 1);
        EXPECT_GT(support_share(arm(), k), 0.005);
        EXPECT_LT(support_share(arm(), k), 0.95);
    }
}

TEST(Arm, HasFineComponentsSmallerThanAllCoarseOnes) {
    double smallest_coarse = 1, largest_fine = 0;
    for (int k = 0; k < arm().component_count(); ++k) {
        if (arm().scales[static_cast<std::size_t>(k)] == 0) {
            smallest_coarse = std::min(smallest_coarse, support_share(arm(), k));
        } else {
            largest_fine = std::max(largest_fine, support_share(arm(), k));
        }
    }
    EXPECT_LT(largest_fine, smallest_coarse);
    EXPECT_LT(largest_fine, 0.12);
}

// Frames differ from one another only where some component acts: before the shoulder and away from
// all swellings nothing ever moves.
TEST(Arm, StandsStillOutsideTheSupports) {
    int still = 0;
    for (int i = 0; i < arm().sequence.vertex_count(); ++i) {
        float reach = 0;
        for (int k = 0; k < arm().component_count(); ++k) reach += support(arm(), k, i);
        if (reach > 0) continue;
        ++still;
        for (const std::vector<Point>& shape : arm().sequence.shapes) {
            const auto at = static_cast<std::size_t>(i);
            EXPECT_LE(norm(minus(shape[at], arm().sequence.shapes[0][at])), 1e-12);
        }
    }
    EXPECT_GT(still, 100);
}

// Pearson correlation of any two components over the frames after the first is 0: they swing at
// different frequencies.
TEST(Arm, MovesItsComponentsIndependently) {
    EXPECT_TRUE(largest_correlation(arm()) <= 1e-5) << largest_correlation(arm());
}

TEST(Arm, ReachesTheFullWeightOfEveryComponent) {
    for (int k = 0; k < arm().component_count(); ++k) {
        float highest = 0;
        for (int n = 0; n < 60; ++n) highest = std::max(highest, weight(arm(), n, k));
        EXPECT_NEAR(highest, 1, 1e-6);
    }
}

/// Angle by which a ring at the wrist is turned about the limb against one before the twist,
/// measured on the points and followed along the forearm (so that it may exceed pi).
double measured_twist(const std::vector<Point>& rest, const std::vector<Point>& shape) {
    std::map<double, std::vector<std::size_t>> rings;
    for (std::size_t i = 0; i < rest.size(); ++i) {
        if (rest[i][2] >= 5.8 && rest[i][2] <= 9.05) rings[rest[i][2]].push_back(i);
    }
    // Between rings the frame turns by a small angle: sum over rings of the best angle about the
    // axis that joins their centres.
    const auto centre = [](const std::vector<Point>& points, const std::vector<std::size_t>& ring) {
        Point sum{0, 0, 0};
        for (const std::size_t i : ring) {
            for (std::size_t c = 0; c < 3; ++c) {
                sum[c] += points[i][c] / static_cast<double>(ring.size());
            }
        }
        return sum;
    };
    const auto direction = [&](const std::vector<Point>& points,
                               const std::vector<std::size_t>& ring) {
        // The vertex nearest to angle 0 at rest, less its angle there, as cosine and sine of a
        // linear fit: first Fourier coefficient of the ring around its centre.
        const Point middle = centre(points, ring);
        Point sum{0, 0, 0};
        for (const std::size_t i : ring) {
            const Point arm_of = minus(points[i], middle);
            const double cosine = std::cos(std::atan2(rest[i][1], rest[i][0]));
            for (std::size_t c = 0; c < 3; ++c) sum[c] += arm_of[c] * cosine;
        }
        return sum;
    };
    double total = 0;
    for (auto next = rings.begin(), previous = next++; next != rings.end(); previous = next++) {
        const Point a = direction(shape, previous->second), b = direction(shape, next->second);
        Point axis = minus(centre(shape, next->second), centre(shape, previous->second));
        const double length = norm(axis);
        for (double& c : axis) c /= length;
        total += std::atan2(dot(axis, cross(a, b)), dot(a, b) - dot(a, axis) * dot(b, axis));
    }
    return total;
}

TEST(Arm, TwistsItsForearmBeyondHalfATurn) {
    const int twist = component_named(arm(), "forearm_twist");
    double largest = 0;
    for (int n = 0; n < 60; ++n) {
        const double angle = measured_twist(arm().sequence.shapes[0],
                                            arm().sequence.shapes[static_cast<std::size_t>(n)]);
        // 270 degrees over 3.5 units, seen over the rings between 5.8 and 9.05.
        const double expected =
            1.5 * std::numbers::pi * static_cast<double>(weight(arm(), n, twist)) * 3.2 / 3.5;
        EXPECT_NEAR(angle, expected, 0.35) << "frame " << n;
        largest = std::max(largest, angle);
    }
    EXPECT_GT(largest, 1.2 * std::numbers::pi);
}

// The elbow at full weight brings the hand back by 120 degrees.
TEST(Arm, BendsItsElbowTo120Degrees) {
    const int elbow = component_named(arm(), "elbow_bend");
    const auto centre = [](const std::vector<Point>& shape, double height) {
        const std::vector<Point>& rest = arm().sequence.shapes[0];
        Point sum{0, 0, 0};
        int count = 0;
        for (std::size_t i = 0; i < rest.size(); ++i) {
            if (std::abs(rest[i][2] - height) > 0.1) continue;
            for (std::size_t c = 0; c < 3; ++c) sum[c] += shape[i][c];
            ++count;
        }
        for (double& c : sum) c /= count;
        return sum;
    };
    for (int n = 1; n < 60; ++n) {
        const std::vector<Point>& shape = arm().sequence.shapes[static_cast<std::size_t>(n)];
        const Point upper = minus(centre(shape, 3.4), centre(shape, 2.6));
        const Point fore = minus(centre(shape, 8.6), centre(shape, 6.2));
        const double angle = std::acos(dot(upper, fore) / (norm(upper) * norm(fore)));
        EXPECT_NEAR(angle, 2 * std::numbers::pi / 3 * static_cast<double>(weight(arm(), n, elbow)),
                    0.15)
            << "frame " << n;
    }
}

/// (N-1) distances of a vertex from the middle of its ring, which bends and twists leave alone.
std::vector<double> radii(int vertex) {
    const std::vector<Point>& rest = arm().sequence.shapes[0];
    const double height = rest[static_cast<std::size_t>(vertex)][2];
    std::vector<double> result;
    for (int n = 1; n < arm().sequence.shape_count(); ++n) {
        const std::vector<Point>& shape = arm().sequence.shapes[static_cast<std::size_t>(n)];
        Point middle{0, 0, 0};
        double count = 0;
        for (std::size_t i = 0; i < rest.size(); ++i) {
            if (rest[i][2] != height) continue;
            for (std::size_t c = 0; c < 3; ++c) middle[c] += shape[i][c];
            ++count;
        }
        for (double& c : middle) c /= count;
        result.push_back(norm(minus(shape[static_cast<std::size_t>(vertex)], middle)));
    }
    return result;
}

/// Change of a vertex's radius per unit of a component's weight: the weights are orthogonal, so one
/// regression each is enough.
double height_of(int component, int vertex) {
    const std::vector<double> radius = radii(vertex);
    const double middle = mean(radius);
    std::vector<double> weights;
    for (int n = 1; n < arm().sequence.shape_count(); ++n) {
        weights.push_back(static_cast<double>(weight(arm(), n, component)));
    }
    const double mean_weight = mean(weights);
    double product = 0, square = 0;
    for (std::size_t n = 0; n < weights.size(); ++n) {
        product += (weights[n] - mean_weight) * (radius[n] - middle);
        square += (weights[n] - mean_weight) * (weights[n] - mean_weight);
    }
    return product / square;
}

// Bulges only rise; ripples rise and fall beside one another.
TEST(Arm, SwellsInBulgesAndRipples) {
    for (int k = 0; k < arm().component_count(); ++k) {
        const std::string& name = arm().component_names[static_cast<std::size_t>(k)];
        if (arm().scales[static_cast<std::size_t>(k)] == 0) continue;
        double highest = 0, lowest = 0;
        for (int i = 0; i < arm().sequence.vertex_count(); ++i) {
            if (support(arm(), k, i) < 0.3F) continue;
            const double height = height_of(k, i);
            highest = std::max(highest, height);
            lowest = std::min(lowest, height);
        }
        const bool ripple = name.starts_with("ripple");
        EXPECT_GT(highest, ripple ? 0.04 : 0.08) << name;
        EXPECT_EQ(lowest < -0.02, ripple) << name << " falls to " << lowest;
    }
}

TEST(Arm, RefusesTooLittle) {
    EXPECT_THROW(generate_arm(1), UsageError);
    EXPECT_THROW(generate_arm(60, 0, 99), UsageError);
}

}  // namespace
}  // namespace mscomp
