// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>

#include "mscomp/acap/generate.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/base/parallel.h"
#include "mscomp/base/safetensors.h"

namespace mscomp {
namespace {

const GeneratedSequence& arm() {
    static const GeneratedSequence generated = generate_arm();
    return generated;
}

Point minus(const Point& p, const Point& q) { return {p[0] - q[0], p[1] - q[1], p[2] - q[2]}; }
Point cross(const Point& u, const Point& v) {
    return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
}
double dot(const Point& u, const Point& v) { return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]; }
double norm(const Point& u) { return std::sqrt(dot(u, u)); }

/// (F) areas of the faces.
std::vector<double> areas(const std::vector<Point>& points, const std::vector<Face>& faces) {
    std::vector<double> result;
    for (const Face& f : faces) {
        const Point& p = points[static_cast<std::size_t>(f[0])];
        const Point& q = points[static_cast<std::size_t>(f[1])];
        const Point& r = points[static_cast<std::size_t>(f[2])];
        result.push_back(norm(cross(minus(q, p), minus(r, p))) / 2);
    }
    return result;
}

double mean(const std::vector<double>& values) {
    double sum = 0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
}

float weight(const GeneratedSequence& g, int frame, int component) {
    return g.weights[static_cast<std::size_t>(frame * g.component_count() + component)];
}

float support(const GeneratedSequence& g, int component, int vertex) {
    return g.supports[static_cast<std::size_t>(component) *
                          static_cast<std::size_t>(g.sequence.vertex_count()) +
                      static_cast<std::size_t>(vertex)];
}

int component_named(const GeneratedSequence& g, const std::string& name) {
    const auto at = std::find(g.component_names.begin(), g.component_names.end(), name);
    return static_cast<int>(at - g.component_names.begin());
}

/// Components by the share of the vertices they reach.
double support_share(const GeneratedSequence& g, int component) {
    int reached = 0;
    for (int i = 0; i < g.sequence.vertex_count(); ++i) reached += support(g, component, i) > 0;
    return static_cast<double>(reached) / g.sequence.vertex_count();
}

TEST(Arm, HasTheSizeAskedFor) {
    EXPECT_GE(arm().sequence.vertex_count(), 3000);
    EXPECT_LE(arm().sequence.vertex_count(), 3200);
    EXPECT_EQ(arm().sequence.shape_count(), 60);
    EXPECT_EQ(arm().sequence.names[59], "frame_0059");
    EXPECT_GE(generate_arm(2, 0, 500).sequence.vertex_count(), 500);
}

// Closed, orientable, of genus 0: every edge once in each direction, V - E + F = 2.
TEST(Arm, IsATopologicalSphere) {
    std::map<std::array<int, 2>, int> sides;
    std::set<int> used;
    for (const Face& f : arm().sequence.faces) {
        for (std::size_t k = 0; k < 3; ++k) ++sides[{f[k], f[(k + 1) % 3]}];
        used.insert(f.begin(), f.end());
    }
    for (const auto& [side, count] : sides) {
        EXPECT_EQ(count, 1);
        EXPECT_TRUE(sides.contains({side[1], side[0]}));
    }
    const int V = arm().sequence.vertex_count();
    EXPECT_EQ(static_cast<int>(used.size()), V);
    EXPECT_EQ(
        V - static_cast<int>(sides.size()) / 2 + static_cast<int>(arm().sequence.faces.size()), 2);
}

// Outward: the volume by the divergence theorem is positive.
TEST(Arm, HasItsFacesTurnedOutwards) {
    double volume = 0;
    const std::vector<Point>& points = arm().sequence.shapes[0];
    for (const Face& f : arm().sequence.faces) {
        volume += dot(points[static_cast<std::size_t>(f[0])],
                      cross(points[static_cast<std::size_t>(f[1])],
                            points[static_cast<std::size_t>(f[2])])) /
                  6;
    }
    EXPECT_GT(volume, 8);
    EXPECT_LT(volume, 30);
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
        float highest = 0;
        for (int i = 0; i < arm().sequence.vertex_count(); ++i) {
            const float value = support(arm(), k, i);
            EXPECT_TRUE(value >= 0 && value <= 1);
            highest = std::max(highest, value);
        }
        EXPECT_EQ(highest, 1) << arm().component_names[static_cast<std::size_t>(k)];
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
    const int N = arm().sequence.shape_count() - 1;
    const auto centred = [&](int k) {
        std::vector<double> values;
        for (int n = 1; n <= N; ++n) values.push_back(static_cast<double>(weight(arm(), n, k)));
        const double middle = mean(values);
        for (double& value : values) value -= middle;
        return values;
    };
    const auto product = [](const std::vector<double>& a, const std::vector<double>& b) {
        double sum = 0;
        for (std::size_t n = 0; n < a.size(); ++n) sum += a[n] * b[n];
        return sum;
    };
    for (int k = 0; k < arm().component_count(); ++k) {
        const std::vector<double> a = centred(k);
        EXPECT_GT(product(a, a) / N, 0.05) << "a component that hardly moves";
        for (int l = 0; l < k; ++l) {
            const std::vector<double> b = centred(l);
            const double correlation = product(a, b) / std::sqrt(product(a, a) * product(b, b));
            EXPECT_TRUE(std::abs(correlation) <= 1e-5) << k << ", " << l;
        }
    }
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

TEST(WriteGenerated, WritesMeshesAndTheirTruth) {
    const std::string folder = testing::TempDir() + "arm_truth_test";
    std::filesystem::remove_all(folder);
    const GeneratedSequence small = generate_arm(3, 5, 400);
    write_generated(small, folder);

    const TriangleMesh mesh = read_mesh(folder + "/frame_0002.obj");
    EXPECT_EQ(mesh.faces, small.sequence.faces);
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        EXPECT_LE(norm(minus(mesh.vertices[i], small.sequence.shapes[2][i])), 1e-7);
    }
    const nlohmann::json truth = nlohmann::json::parse(read_file(folder + "/truth.json"));
    EXPECT_EQ(truth["names"].get<std::vector<std::string>>(), small.component_names);
    EXPECT_EQ(truth["scales"].get<std::vector<int>>(), small.scales);
    ASSERT_EQ(truth["weights"].size(), 3u);
    EXPECT_EQ(truth["weights"][2][1].get<float>(), weight(small, 2, 1));
    const SafetensorsFile file(folder + "/truth_supports.safetensors");
    const std::span<const float> supports =
        file.data<float>("supports", {small.component_count(), small.sequence.vertex_count()});
    EXPECT_TRUE(std::equal(supports.begin(), supports.end(), small.supports.begin()));
    std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace mscomp
