// SPDX-License-Identifier: MIT
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "angles.h"
#include "generate_motion.h"
#include "limb.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"
#include "mscomp/generate/generate.h"

namespace mscomp {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// ---------------------------------------------------------------------------------------------
// What moves.

/// Turns everything beyond a stretch of the axis: the rotation grows from 0 at `from` to `degrees`
/// at `to`, about an axis that turns with the limb.
struct Turn {
    const char* name;
    Vector3d axis;
    double degrees, from, to;
    double lowest_weight;
    bool linear;

    double share(double s) const {
        if (!linear) return plateau(s);
        return std::clamp((s - from) / (to - from), 0.0, 1.0);
    }
    /// Rises with an even slope and rounded ends, so that the bend is nearly a circular arc.
    double plateau(double s) const {
        const double x = std::clamp((s - from) / (to - from), 0.0, 1.0);
        constexpr double ramp = 0.2;  // of the stretch, where the slope grows
        constexpr double slope = 1 / (1 - ramp);
        if (x < ramp) return slope * x * x / (2 * ramp);
        if (x > 1 - ramp) return 1 - slope * (1 - x) * (1 - x) / (2 * ramp);
        return slope * (x - ramp / 2);
    }
};

/// Moves a patch around (height, degrees around the axis) along the normal.
struct Swelling {
    const char* name;
    double height_at, degrees_at;
    double half_length, half_width;
    double height;
    double waves;  // 0 for a bulge, else along the patch

    /// 1 in the middle of the patch, 0 outside it.
    double window(double s, double arc) const {
        const double distance = std::hypot((s - height_at) / half_length, arc / half_width);
        return distance < 1 ? std::pow(std::cos(kPi / 2 * distance), 2) : 0;
    }
    double wave(double s) const { return std::cos(kPi * waves * (s - height_at) / half_length); }
};

const std::vector<Turn>& turns() {
    static const std::vector<Turn> all{
        {"shoulder_lift", Vector3d::UnitX(), 35, 0.9, 2.3, -1, false},
        {"shoulder_swing", Vector3d::UnitY(), 30, 0.9, 2.3, -1, false},
        {"elbow_bend", Vector3d::UnitX(), 120, 3.5, 5.9, 0, false},
        {"forearm_twist", Vector3d::UnitZ(), 270, 5.7, 9.2, -0.3, true},
        {"wrist_bend", Vector3d::UnitY(), 55, 9.1, 10.2, -1, false}};
    return all;
}

const std::vector<Swelling>& swellings() {
    static const std::vector<Swelling> all{{"biceps", 2.8, 265, 1.2, 0.65, 0.26, 0},
                                           {"triceps", 2.4, 145, 1.1, 0.6, 0.2, 0},
                                           {"flexor", 6.4, 245, 0.9, 0.52, 0.18, 0},
                                           {"extensor", 6.7, 160, 0.9, 0.5, 0.18, 0},
                                           {"knuckles", 10.9, 180, 0.5, 0.5, 0.14, 0},
                                           {"ripple_upper_arm", 3.2, 195, 1.1, 0.5, 0.1, 3},
                                           {"ripple_forearm", 8.1, 205, 0.8, 0.42, 0.08, 2}};
    return all;
}

/// (V) how much of a swelling reaches each vertex: 1 at its middle, 0 outside it.
std::vector<double> window_of(const Limb& limb, const Swelling& swelling) {
    std::vector<double> window;
    for (std::size_t i = 0; i < limb.angle.size(); ++i) {
        const Point& p = limb.mesh.vertices[i];
        const double turn = std::remainder(limb.angle[i] - radians(swelling.degrees_at), 2 * kPi);
        window.push_back(swelling.window(p[2], turn * std::hypot(p[0], p[1])));
    }
    const double highest = *std::max_element(window.begin(), window.end());
    for (double& value : window) value /= highest;
    return window;
}

/// Frames of all rings when each turn has the given angle: the axis is carried along, so that bends
/// are arcs and the length of the limb stays.
std::vector<Eigen::Isometry3d> ring_frames(const Limb& limb, const std::vector<double>& angles) {
    constexpr int kSubsteps = 16;
    std::vector<Eigen::Isometry3d> frames;
    Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
    double s = 0;
    for (const Ring& ring : limb.rings) {
        const double step = (ring.height - s) / kSubsteps;
        for (int k = 0; step > 0 && k < kSubsteps; ++k, s += step) {
            Vector3d turn = Vector3d::Zero();
            for (std::size_t t = 0; t < turns().size(); ++t) {
                const Turn& one = turns()[t];
                turn += angles[t] * (one.share(s + step) - one.share(s)) * one.axis;
            }
            // Half the turn, the step along the axis, the other half: second order in the step.
            const Eigen::AngleAxisd half(turn.norm() / 2, turn.norm() > 0
                                                              ? Vector3d(turn.normalized())
                                                              : Vector3d(Vector3d::UnitZ()));
            frame.rotate(half);
            frame.translate(Vector3d(0, 0, step));
            frame.rotate(half);
        }
        s = ring.height;
        frames.push_back(frame);
    }
    return frames;
}

std::vector<Point> pose(const Limb& limb, const std::vector<std::vector<double>>& windows,
                        const float* weights) {
    std::vector<double> angles;
    for (const Turn& turn : turns()) {
        angles.push_back(static_cast<double>(*weights++) * radians(turn.degrees));
    }
    const std::vector<Eigen::Isometry3d> frames = ring_frames(limb, angles);
    std::vector<Point> points(limb.angle.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Point& p = limb.mesh.vertices[i];
        double height = 0;
        for (std::size_t k = 0; k < windows.size(); ++k) {
            const Swelling& one = swellings()[k];
            height += static_cast<double>(weights[k]) * one.height * windows[k][i] * one.wave(p[2]);
        }
        const Vector3d local = Vector3d(p[0], p[1], 0) + height * limb.normal[i];
        Eigen::Map<Vector3d>(points[i].data()) = frames[at(limb.ring_of[i])] * local;
    }
    return points;
}

}  // namespace

GeneratedSequence generate_arm(int frames, std::uint64_t seed, int vertices) {
    require_size("arm", frames, vertices);
    const Limb limb = limb_with_vertices(vertices);
    std::vector<Mover> movers;
    for (const Turn& turn : turns()) movers.push_back({turn.name, 0, turn.lowest_weight});
    for (const Swelling& swelling : swellings()) {
        movers.push_back({swelling.name, 1, swelling.waves > 0 ? -1.0 : 0.0});
    }
    GeneratedSequence result = still_sequence(movers, frames, seed);
    for (const Turn& turn : turns()) {
        for (const Point& p : limb.mesh.vertices) {
            result.supports.push_back(static_cast<float>(turn.share(p[2])));
        }
    }
    std::vector<std::vector<double>> windows;
    for (const Swelling& swelling : swellings()) {
        windows.push_back(window_of(limb, swelling));
        for (const double value : windows.back()) {
            result.supports.push_back(static_cast<float>(value));
        }
    }
    result.sequence.faces = limb.mesh.faces;
    parallel_for(frames, [&](std::int64_t n) {
        const auto place = at(n);
        result.sequence.shapes[place] =
            pose(limb, windows, result.weights.data() + place * result.component_names.size());
    });
    return result;
}

}  // namespace mscomp
