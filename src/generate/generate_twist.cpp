// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "angles.h"
#include "generate_motion.h"
#include "mscomp/base/error.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"
#include "mscomp/base/random.h"
#include "mscomp/generate/generate.h"

namespace mscomp {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kLength = 10;
constexpr int kAround = 8;

Matrix3d rotation_about(const Vector3d& axis, double angle) {
    return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

// ---------------------------------------------------------------------------------------------
// The bar at rest, along z; every other ring is turned by half a step.

struct Bar {
    int rings = 0;
    double spacing = 0, radius = 0;
    TriangleMesh mesh;  // ring by ring from z = 0 on, then the centres of the two caps

    int ring_of(int vertex) const {
        const int ring = vertex / kAround;
        return ring < rings ? ring : (vertex == rings * kAround ? 0 : rings - 1);
    }
    bool is_inner(int vertex) const {
        return vertex >= rings * kAround || (ring_of(vertex) > 0 && ring_of(vertex) < rings - 1);
    }
    bool is_cap_center(int vertex) const { return vertex >= rings * kAround; }
    /// Around the axis, 0 at +x.
    double angle_of(int vertex) const {
        const double half_step = (vertex / kAround) % 2 == 0 ? 0 : 0.5;
        return 2 * kPi * (vertex % kAround + half_step) / kAround;
    }
};

void add_faces(Bar& bar) {
    const auto vertex = [](int ring, int k) { return ring * kAround + k % kAround; };
    const int bottom = bar.rings * kAround;
    for (int k = 0; k < kAround; ++k)
        bar.mesh.faces.push_back({bottom, vertex(0, k + 1), vertex(0, k)});
    for (int ring = 0; ring + 1 < bar.rings; ++ring) {
        const int shift = ring % 2;  // the ring above starts half a step later, or earlier
        for (int k = 0; k < kAround; ++k) {
            const int above = vertex(ring + 1, k + shift);
            bar.mesh.faces.push_back({vertex(ring, k), vertex(ring, k + 1), above});
            bar.mesh.faces.push_back({vertex(ring, k + 1), vertex(ring + 1, k + shift + 1), above});
        }
    }
    const int last = bar.rings - 1;
    for (int k = 0; k < kAround; ++k) {
        bar.mesh.faces.push_back({bottom + 1, vertex(last, k), vertex(last, k + 1)});
    }
}

Bar bar_with_vertices(int vertices, double thickness) {
    Bar bar;
    bar.rings = (vertices - 2 + kAround - 1) / kAround;
    bar.spacing = kLength / (bar.rings - 1);
    bar.radius = thickness * bar.spacing;
    for (int i = 0; i < bar.rings * kAround; ++i) {
        const double angle = bar.angle_of(i);
        const int ring = i / kAround;
        bar.mesh.vertices.push_back(
            {bar.radius * std::cos(angle), bar.radius * std::sin(angle), bar.spacing * ring});
    }
    bar.mesh.vertices.push_back({0, 0, 0});
    bar.mesh.vertices.push_back({0, 0, kLength});
    add_faces(bar);
    return bar;
}

double mean_edge_length(const TriangleMesh& mesh) {
    double sum = 0;  // every edge twice, once from each side
    for (const Face& f : mesh.faces) {
        for (std::size_t k = 0; k < 3; ++k) {
            const Point& p = mesh.vertices[at(f[k])];
            const Point& q = mesh.vertices[at(f[(k + 1) % 3])];
            sum += std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
        }
    }
    return sum / (3 * static_cast<double>(mesh.faces.size()));
}

// ---------------------------------------------------------------------------------------------
// How it moves.

/// The twist at one amount in [0, 1].
struct Twist {
    double radians;  // of the far end
    double tilt;     // radians

    double angle(double s) const { return radians * s / kLength; }
    Vector3d axis(double s) const {
        const double lean = tilt * s / kLength;
        return {std::sin(lean), 0, std::cos(lean)};
    }
    Matrix3d rotation(double s) const { return rotation_about(axis(s), angle(s)); }
};

/// A bar whose axis tilts is of no preferred direction at rest either.
Matrix3d lie_of_bar(const TwistOptions& options) {
    return options.tilt == 0 ? Matrix3d(Matrix3d::Identity())
                             : rotation_about(Vector3d(1, 2, 0.5).normalized(), 0.8);
}

/// (rings) middles: the middle line follows the rotated axis of the bar, at its length.
std::vector<Vector3d> ring_centers(const Bar& bar, const Twist& twist) {
    constexpr int kSubsteps = 16;
    std::vector<Vector3d> centers{Vector3d::Zero()};
    for (int ring = 1; ring < bar.rings; ++ring) {
        Vector3d step = Vector3d::Zero();
        for (int k = 0; k < kSubsteps; ++k) {
            const double s = bar.spacing * (ring - 1 + (k + 0.5) / kSubsteps);
            step += twist.rotation(s).col(2);
        }
        centers.push_back(centers.back() + bar.spacing / kSubsteps * step);
    }
    return centers;
}

std::vector<Point> pose(const Bar& bar, const Twist& twist, const Matrix3d& lie) {
    const std::vector<Vector3d> centers = ring_centers(bar, twist);
    std::vector<Point> points(bar.mesh.vertices.size());
    for (int i = 0; i < bar.mesh.vertex_count(); ++i) {
        const int ring = bar.ring_of(i);
        const Point& rest = bar.mesh.vertices[at(i)];
        const Vector3d arm(rest[0], rest[1], 0);
        Eigen::Map<Vector3d>(points[at(i)].data()) =
            lie * (centers[at(ring)] + twist.rotation(bar.spacing * ring) * arm);
    }
    return points;
}

void add_noise(std::vector<Point>& points, double deviation, std::uint64_t seed, int frame) {
    const CounterRandom random(seed, static_cast<std::uint64_t>(frame));
    std::uint64_t draw = 0;
    for (Point& p : points) {
        for (double& c : p) c += deviation * random.normal(draw++);
    }
}

// ---------------------------------------------------------------------------------------------
// Its features in closed form.

/// What an untilted twist does to every inner one-ring in its own frame of radius, tangent and
/// axis, the turn about the axis taken out: a rotation about the radius and a stretch.
struct Shear {
    double angle = 0;
    Matrix3d stretch = Matrix3d::Identity();
};

/// The one-ring has two edges along its ring (b) and four slanted ones (l), two up, two down. All
/// sums over it are even or odd under the half turn about the radius, so that T maps the radius to
/// itself and [tangent, axis] by a 2x2 matrix [p q; 0 1]. `step` is the turn from ring to ring.
Shear shear_of(const Bar& bar, double step) {
    const double half = kPi / kAround;  // from a vertex to those above and below it
    const double b = 2 * bar.radius * std::sin(half);
    const auto slanted = [&](double angle) {
        return std::hypot(bar.spacing, 2 * bar.radius * std::sin(angle / 2));
    };
    // Cotangents of the triangle (b, l, l): at the base, for slanted edges; at the top, for b.
    const double slope = std::sqrt(slanted(half) * slanted(half) - b * b / 4) / (b / 2);
    const double at_base = std::max(1 / slope, 1e-3);
    const double at_top = std::max((slope - 1 / slope) / 2, 1e-3);
    const double h = 0.3 * (2 * b + 4 * slanted(half)) / 6;
    const double turned_h = 0.3 * (2 * b + 2 * slanted(half + step) + 2 * slanted(half - step)) / 6;

    const double r2 = bar.radius * bar.radius;
    const double ring_sag = 1 - std::cos(2 * half), sag = 1 - std::cos(half);
    const double turned_sag = 1 - std::cos(half) * std::cos(step);
    const double along_radius =
        (2 * at_top * r2 * ring_sag * ring_sag + 4 * at_base * r2 * sag * turned_sag +
         h * turned_h) /
        (2 * at_top * r2 * ring_sag * ring_sag + 4 * at_base * r2 * sag * sag + h * h);
    const double ring_part = 2 * at_top * std::pow(std::sin(2 * half), 2);
    const double slanted_part = 4 * at_base * std::pow(std::sin(half), 2);
    const double p = (ring_part + slanted_part * std::cos(step)) / (ring_part + slanted_part);
    const double q = bar.radius / bar.spacing * std::cos(half) * std::sin(step);

    // Polar decomposition of a 2x2 matrix: the rotation that makes the rest symmetric.
    Shear shear;
    shear.angle = std::atan2(-q, p + 1);
    const double c = std::cos(shear.angle), s = std::sin(shear.angle);
    shear.stretch << along_radius, 0, 0, 0, c * p, c * q + s, 0, -s * p, c - s * q;
    return shear;
}

/// Of all r with exp(r) = `rotation` the one nearest to `near`.
Vector3d nearest_logarithm(const Matrix3d& rotation, const Vector3d& near) {
    const Eigen::AngleAxisd principal(rotation);
    const double along = near.dot(principal.axis());
    const double turns = std::round((along - principal.angle()) / (2 * kPi));
    return (principal.angle() + 2 * kPi * turns) * principal.axis();
}

void write_feature(float* feature, const Vector3d& r, const Matrix3d& stretch) {
    for (int c = 0; c < 3; ++c) *feature++ = static_cast<float>(r[c]);
    for (int row = 0; row < 3; ++row) {
        for (int column = row; column < 3; ++column) {
            *feature++ = static_cast<float>(stretch(row, column));
        }
    }
}

/// (V,9) features of an untilted twist, the reference's on the end rings.
void write_features_of(const Bar& bar, const Twist& twist, float* features) {
    const Shear shear = shear_of(bar, twist.angle(bar.spacing));
    for (int i = 0; i < bar.mesh.vertex_count(); ++i, features += kFeatureDim) {
        std::copy(kReferenceFeature.begin(), kReferenceFeature.end(), features);
        if (!bar.is_inner(i)) continue;
        const double turned = twist.angle(bar.spacing * bar.ring_of(i));
        const Vector3d turn = turned * Vector3d::UnitZ();
        if (bar.is_cap_center(i)) {
            write_feature(features, turn, Matrix3d::Identity());
            continue;
        }
        const Matrix3d place = rotation_about(Vector3d::UnitZ(), bar.angle_of(i));
        const Matrix3d rotation = rotation_about(Vector3d::UnitZ(), turned) * place *
                                  rotation_about(Vector3d::UnitX(), shear.angle) *
                                  place.transpose();
        write_feature(features, nearest_logarithm(rotation, turn),
                      place * shear.stretch * place.transpose());
    }
}

void require_options(const TwistOptions& options, int rings) {
    const auto refuse = [](const char* name, double got, const char* wanted) {
        throw UsageError(fmt::format("twist: {} is {}, wanted {}", name, got, wanted));
    };
    if (!std::isfinite(options.turns)) refuse("turns", options.turns, "a finite number");
    if (!(std::abs(options.tilt) <= 90)) refuse("tilt", options.tilt, "at most 90 degrees");
    if (!(options.noise >= 0 && options.noise <= 1)) refuse("noise", options.noise, "0 to 1");
    if (!(options.thickness >= 0.01 && options.thickness <= 10)) {
        refuse("thickness", options.thickness, "0.01 to 10");
    }
    if (!(2 * std::abs(options.turns) < rings - 1)) {
        throw UsageError(
            fmt::format("twist: {} turns over {} rings, which are then half a turn or more apart; "
                        "wanted less than {}, or more vertices ({} to a ring)",
                        options.turns, rings, (rings - 1) / 2.0, kAround));
    }
}

}  // namespace

GeneratedSequence generate_twist(int frames, std::uint64_t seed, int vertices,
                                 const TwistOptions& options) {
    require_size("twist", frames, vertices);
    const Bar bar = bar_with_vertices(vertices, options.thickness);
    require_options(options, bar.rings);
    const Matrix3d lie = lie_of_bar(options);
    const double deviation = options.noise * mean_edge_length(bar.mesh);
    const auto count = bar.mesh.vertices.size();

    GeneratedSequence result = still_sequence({{"twist", 0, 0}}, frames, seed);
    result.sequence.faces = bar.mesh.faces;
    RotationTruth& truth = result.rotation_truth;
    for (int i = 0; i < bar.mesh.vertex_count(); ++i) {
        result.supports.push_back(static_cast<float>(bar.spacing * bar.ring_of(i) / kLength));
        truth.exact.push_back(bar.is_inner(i) ? 1 : 0);
    }
    truth.rotation.resize(at(frames) * count * kRotationDim);
    if (options.tilt == 0) {
        truth.features.resize(at(frames) * count * kFeatureDim);
    }
    parallel_for(frames, [&](std::int64_t n) {
        const auto place = at(n);
        const double amount = static_cast<double>(n) / (frames - 1);
        const Twist twist{2 * kPi * options.turns * amount, options.tilt * kPi / 180};
        result.weights[place] = static_cast<float>(amount);
        result.sequence.shapes[place] = pose(bar, twist, lie);
        if (n > 0) add_noise(result.sequence.shapes[place], deviation, seed, static_cast<int>(n));
        for (int i = 0; i < bar.mesh.vertex_count(); ++i) {
            const double s = bar.spacing * bar.ring_of(i);
            Eigen::Map<Eigen::Vector3f>(truth.rotation.data() +
                                        (place * count + at(i)) * kRotationDim) =
                (lie * (twist.angle(s) * twist.axis(s))).cast<float>();
        }
        if (!truth.features.empty()) {
            write_features_of(bar, twist, truth.features.data() + place * count * kFeatureDim);
        }
    });
    return result;
}

}  // namespace mscomp
