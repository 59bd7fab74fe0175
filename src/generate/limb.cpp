// SPDX-License-Identifier: MIT
#include "limb.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "angles.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

using Eigen::Vector3d;

/// Half axes of the cross-section at height s.
Eigen::Vector2d section(double s) {
    const auto swelling = [s](double center, double width, double height) {
        const double x = (s - center) / width;
        return height * std::exp(-x * x);
    };
    const double limb = 0.42 + 0.38 * (1 - smooth_step(s, 1.0, 9.2)) + swelling(2.6, 1.3, 0.12) +
                        swelling(6.0, 1.2, 0.14);
    const double hand = smooth_step(s, 9.4, 10.6);
    const double rounding_start = std::sqrt(std::max(0.0, 1 - std::pow(1 - std::min(s, 1.0), 2)));
    const double from_end = std::min((kLimbLength - s) / 0.9, 1.0);
    const double rounding =
        rounding_start * std::sqrt(std::max(0.0, 1 - std::pow(1 - from_end, 2)));
    return {rounding * (limb - 0.13 * hand), rounding * (limb + 0.28 * hand)};
}

/// `count` angles that cut an ellipse into equally long arcs, starting `phase` arcs after angle 0.
std::vector<double> even_angles(const Eigen::Vector2d& axes, int count, double phase) {
    constexpr int kSamples = 720;
    std::vector<double> arc(kSamples + 1, 0.0);
    for (int i = 0; i < kSamples; ++i) {
        const double angle = 2 * kPi * (i + 0.5) / kSamples;
        arc[at(i) + 1] =
            arc[at(i)] + std::hypot(axes[0] * std::sin(angle), axes[1] * std::cos(angle));
    }
    std::vector<double> angles;
    for (int k = 0; k < count; ++k) {
        const double wanted = arc.back() * (k + phase) / count;
        const auto above = std::upper_bound(arc.begin(), arc.end() - 1, wanted);
        const double share = (wanted - *(above - 1)) / (*above - *(above - 1));
        angles.push_back(2 * kPi * (static_cast<double>(above - 1 - arc.begin()) + share) /
                         kSamples);
    }
    return angles;
}

/// Heights at equal steps of about `spacing` along the outline, both poles included.
std::vector<double> even_heights(double spacing) {
    constexpr int kSamples = 20000;
    std::vector<double> heights, arc{0};
    for (int i = 0; i <= kSamples; ++i) {
        heights.push_back(0.5 * kLimbLength * (1 - std::cos(kPi * i / kSamples)));
        if (i == 0) continue;
        const double before = heights[heights.size() - 2];
        const double rise = (section(heights.back()).sum() - section(before).sum()) / 2;
        arc.push_back(arc.back() + std::hypot(heights.back() - before, rise));
    }
    const int steps = static_cast<int>(std::ceil(arc.back() / spacing));
    std::vector<double> even{0};
    for (int k = 1; k < steps; ++k) {
        const auto above = std::upper_bound(arc.begin(), arc.end() - 1, arc.back() * k / steps);
        even.push_back(heights[at(above - arc.begin())]);
    }
    even.push_back(kLimbLength);
    return even;
}

/// Triangles between two neighbouring rings: always on to the vertex that comes first around.
void stitch(Limb& limb, const Ring& lower, const Ring& upper) {
    const auto angle_at = [&limb](const Ring& ring, int k) {
        const double turn = k >= ring.count ? 2 * kPi : 0;
        return limb.angle[at(ring.first + k % ring.count)] + turn;
    };
    const auto vertex = [](const Ring& ring, int k) { return ring.first + k % ring.count; };
    int i = 0, j = 0;
    const int last_i = lower.count > 1 ? lower.count : 0;
    const int last_j = upper.count > 1 ? upper.count : 0;
    while (i < last_i || j < last_j) {
        const bool go_lower =
            j == last_j || (i < last_i && angle_at(lower, i + 1) + angle_at(lower, i) <
                                              angle_at(upper, j + 1) + angle_at(upper, j));
        if (go_lower) {
            limb.mesh.faces.push_back({vertex(lower, i), vertex(lower, i + 1), vertex(upper, j)});
            ++i;
        } else {
            limb.mesh.faces.push_back({vertex(lower, i), vertex(upper, j + 1), vertex(upper, j)});
            ++j;
        }
    }
}

Limb limb_with_edge_length(double edge_length) {
    Limb limb;
    for (const double height : even_heights(edge_length * std::sqrt(0.75))) {
        const Eigen::Vector2d axes = section(height);
        const bool pole = height <= 0 || height >= kLimbLength;
        const double around = kPi * (axes[0] + axes[1]);
        Ring ring{height, limb.mesh.vertex_count(),
                  pole ? 1 : std::max(5, static_cast<int>(std::lround(around / edge_length)))};
        // Every other ring is turned by half a step, which makes the triangles equilateral.
        const double phase = limb.rings.size() % 2 == 0 ? 0.25 : 0.75;
        for (const double angle :
             pole ? std::vector<double>{0} : even_angles(axes, ring.count, phase)) {
            limb.mesh.vertices.push_back(
                {axes[0] * std::cos(angle), axes[1] * std::sin(angle), height});
            limb.angle.push_back(angle);
            limb.ring_of.push_back(static_cast<int>(limb.rings.size()));
        }
        if (!limb.rings.empty()) stitch(limb, limb.rings.back(), ring);
        limb.rings.push_back(ring);
    }
    limb.normal = vertex_normals(limb.mesh);
    return limb;
}

}  // namespace

std::vector<Vector3d> vertex_normals(const TriangleMesh& mesh) {
    const auto point = [&mesh](int i) {
        return Eigen::Map<const Vector3d>(mesh.vertices[at(i)].data());
    };
    std::vector<Vector3d> normals(mesh.vertices.size(), Vector3d::Zero());
    for (const Face& f : mesh.faces) {
        const Vector3d normal = (point(f[1]) - point(f[0])).cross(point(f[2]) - point(f[0]));
        for (const int i : f) normals[at(i)] += normal;
    }
    for (Vector3d& normal : normals) normal.normalize();
    return normals;
}

double smooth_step(double s, double from, double to) {
    const double x = std::clamp((s - from) / (to - from), 0.0, 1.0);
    return x * x * (3 - 2 * x);
}

Limb limb_with_vertices(int vertices) {
    double edge_length = std::sqrt(60.0 / vertices);
    Limb limb = limb_with_edge_length(edge_length);
    while (limb.mesh.vertex_count() < vertices) {
        edge_length *= 0.99;
        limb = limb_with_edge_length(edge_length);
    }
    return limb;
}

}  // namespace mscomp
