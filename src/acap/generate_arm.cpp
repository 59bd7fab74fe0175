// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "limb.h"
#include "mscomp/acap/generate.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/base/parallel.h"
#include "mscomp/base/random.h"
#include "mscomp/base/safetensors.h"

namespace mscomp {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;

double radians(double degrees) { return degrees * kPi / 180; }

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

/// (N,K) weights: component k swings at a frequency of its own over the frames after the first,
/// which makes all of them orthogonal; the coarse ones take the slow half.
std::vector<float> draw_weights(int frames, std::uint64_t seed) {
    const std::size_t coarse = turns().size(), count = coarse + swellings().size();
    const std::vector<int> slow = CounterRandom(seed, 0).permutation(static_cast<int>(coarse));
    const std::vector<int> fast =
        CounterRandom(seed, 1).permutation(static_cast<int>(count - coarse));
    const CounterRandom phases(seed, 2);
    std::vector<float> weights(static_cast<std::size_t>(frames) * count, 0.0F);
    for (std::size_t k = 0; k < count; ++k) {
        const bool is_turn = k < coarse;
        const int frequency =
            is_turn ? 1 + slow[k] : 1 + static_cast<int>(coarse) + fast[k - coarse];
        const double lowest =
            is_turn ? turns()[k].lowest_weight : (swellings()[k - coarse].waves > 0 ? -1.0 : 0.0);
        // A whole frame is hit by the crest, so that every component reaches its full weight.
        const double crest = std::floor(phases.uniform(k) * (frames - 1));
        for (int n = 1; n < frames; ++n) {
            const double angle = 2 * kPi * frequency * (n - 1 - crest) / (frames - 1);
            weights[static_cast<std::size_t>(n) * count + k] =
                static_cast<float>(lowest + (1 - lowest) * 0.5 * (1 + std::cos(angle)));
        }
    }
    return weights;
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
        Eigen::Map<Vector3d>(points[i].data()) =
            frames[static_cast<std::size_t>(limb.ring_of[i])] * local;
    }
    return points;
}

}  // namespace

GeneratedSequence generate_arm(int frames, std::uint64_t seed, int vertices) {
    if (frames < 2) throw UsageError(fmt::format("arm: {} frames, wanted at least 2", frames));
    if (vertices < 100) {
        throw UsageError(fmt::format("arm: {} vertices, wanted at least 100", vertices));
    }
    const Limb limb = limb_with_vertices(vertices);
    GeneratedSequence result;
    for (const Turn& turn : turns()) {
        result.component_names.emplace_back(turn.name);
        result.scales.push_back(0);
        for (const Point& p : limb.mesh.vertices) {
            result.supports.push_back(static_cast<float>(turn.share(p[2])));
        }
    }
    std::vector<std::vector<double>> windows;
    for (const Swelling& swelling : swellings()) {
        result.component_names.emplace_back(swelling.name);
        result.scales.push_back(1);
        windows.push_back(window_of(limb, swelling));
        for (const double value : windows.back()) {
            result.supports.push_back(static_cast<float>(value));
        }
    }
    result.weights = draw_weights(frames, seed);
    result.sequence.faces = limb.mesh.faces;
    result.sequence.shapes.resize(static_cast<std::size_t>(frames));
    for (int n = 0; n < frames; ++n) result.sequence.names.push_back(fmt::format("frame_{:04}", n));
    parallel_for(frames, [&](std::int64_t n) {
        const auto at = static_cast<std::size_t>(n);
        result.sequence.shapes[at] =
            pose(limb, windows, result.weights.data() + at * result.component_names.size());
    });
    return result;
}

void write_generated(const GeneratedSequence& generated, const std::string& folder) {
    const MeshSequence& sequence = generated.sequence;
    parallel_for(sequence.shape_count(), [&](std::int64_t n) {
        const auto at = static_cast<std::size_t>(n);
        write_obj(fmt::format("{}/{}.obj", folder, sequence.names[at]),
                  {sequence.shapes[at], sequence.faces});
    });
    const std::size_t count = generated.component_names.size();
    nlohmann::json truth;
    truth["names"] = generated.component_names;
    truth["scales"] = generated.scales;
    truth["frames"] = sequence.names;
    truth["weights"] = nlohmann::json::array();
    for (std::size_t n = 0; n < sequence.names.size(); ++n) {
        const auto row = generated.weights.begin() + static_cast<std::ptrdiff_t>(n * count);
        truth["weights"].push_back(
            std::vector<float>(row, row + static_cast<std::ptrdiff_t>(count)));
    }
    write_file(folder + "/truth.json", truth.dump(1) + "\n");

    SafetensorsWriter writer;
    writer.add<float>(
        "supports",
        {generated.component_count(), static_cast<std::int64_t>(sequence.vertex_count())},
        generated.supports);
    writer.set_metadata("names", nlohmann::json(generated.component_names).dump());
    writer.write(folder + "/truth_supports.safetensors");
}

}  // namespace mscomp
