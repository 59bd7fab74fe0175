// SPDX-License-Identifier: MIT
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "angles.h"
#include "generate_motion.h"
#include "head.h"
#include "limb.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"
#include "mscomp/generate/generate.h"

namespace mscomp {
namespace {

using Eigen::Vector3d;

// ---------------------------------------------------------------------------------------------
// What moves.

/// Moves an oval of the face, seen from the front, along a fixed direction and the normal.
struct Expression {
    const char* name;
    int scale;
    double lowest_weight;
    double x, y, half_width, half_height;
    Vector3d shift;
    double swelling;  // along the normal of the reference
    bool both_sides = false;

    /// 1 in the middle, 0 outside and on the back of the head.
    double window(const Point& p) const {
        const double across = both_sides ? std::abs(p[0]) : p[0];
        const double distance = std::hypot((across - x) / half_width, (p[1] - y) / half_height);
        if (distance >= 1) return 0;
        return std::pow(std::cos(kPi / 2 * distance), 2) * smooth_step(p[2], 0.0, 0.35);
    }
};

const std::vector<Expression>& expressions() {
    static const std::vector<Expression> all{
        {"forehead", 0, -0.5, 0, 0.42, 0.62, 0.42, {0, 0.11, 0}, 0.01},
        {"cheeks", 0, -0.4, 0.38, -0.2, 0.34, 0.42, {0, 0, 0}, 0.09, true},
        {"smile", 0, -0.5, 0, -0.33, 0.55, 0.36, {0, 0.075, -0.03}, 0},
        {"pout", 0, -0.3, 0, -0.36, 0.38, 0.3, {0, 0, 0.1}, 0},
        {"brow_left", 1, -0.6, 0.27, 0.36, 0.28, 0.16, {0.01, 0.09, 0.01}, 0},
        {"brow_right", 1, -0.6, -0.27, 0.36, 0.28, 0.16, {-0.01, 0.09, 0.01}, 0},
        {"eyelid_left", 1, 0, 0.26, 0.2, 0.18, 0.12, {0, -0.05, 0.02}, 0},
        {"eyelid_right", 1, 0, -0.26, 0.2, 0.18, 0.12, {0, -0.05, 0.02}, 0},
        {"nose_wrinkle", 1, 0, 0, 0.02, 0.2, 0.18, {0, 0.06, 0.01}, 0},
        {"cheek_left", 1, -0.4, 0.4, -0.08, 0.26, 0.24, {0, 0.03, 0}, 0.07},
        {"cheek_right", 1, -0.4, -0.4, -0.08, 0.26, 0.24, {0, 0.03, 0}, 0.07},
        {"mouth_corner_left", 1, -0.7, 0.2, -0.36, 0.22, 0.18, {0.05, 0.055, -0.03}, 0},
        {"mouth_corner_right", 1, -0.7, -0.2, -0.36, 0.22, 0.18, {-0.05, 0.055, -0.03}, 0},
        {"upper_lip", 1, -0.3, 0, -0.27, 0.17, 0.13, {0, 0.03, 0.02}, 0},
        {"chin_boss", 1, -0.3, 0, -0.68, 0.24, 0.2, {0, 0.03, 0.08}, 0}};
    return all;
}

/// Turns the jaw about an axis through the ears.
struct JawTurn {
    const char* name;
    double lowest_weight;
    Vector3d axis;
    double degrees;
};

const std::vector<JawTurn>& jaw_turns() {
    static const std::vector<JawTurn> all{{"jaw_open", 0, Vector3d::UnitX(), 24},
                                          {"jaw_slide", -1, Vector3d::UnitY(), 11}};
    return all;
}

const Vector3d kJawJoint(0, -0.05, 0.0);

/// Share of the jaw's rotation: below a line from the mouth to the ears, in front of the neck.
double jaw_share(const Point& p) {
    const double line = -0.355 + 0.2 * smooth_step(-p[2], -0.6, 0.1);
    return smooth_step(line - p[1], 0.0, 0.2) * smooth_step(p[2], -0.45, 0.3);
}

// ---------------------------------------------------------------------------------------------

/// The supports of all components, the jaw's first: (K) rows of (V).
std::vector<std::vector<double>> supports_of(const Head& head) {
    std::vector<std::vector<double>> rows(jaw_turns().size());
    for (const Point& p : head.mesh.vertices) {
        for (std::vector<double>& row : rows) row.push_back(jaw_share(p));
    }
    for (const Expression& expression : expressions()) {
        std::vector<double> row;
        for (const Point& p : head.mesh.vertices) row.push_back(expression.window(p));
        rows.push_back(std::move(row));
    }
    return rows;
}

std::vector<Point> pose(const Head& head, const std::vector<std::vector<double>>& supports,
                        const float* weights) {
    const std::size_t turns = jaw_turns().size();
    std::vector<Point> points(head.mesh.vertices.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        Vector3d place = Eigen::Map<const Vector3d>(head.mesh.vertices[i].data());
        for (std::size_t e = 0; e < expressions().size(); ++e) {
            const Expression& one = expressions()[e];
            place += static_cast<double>(weights[turns + e]) * supports[turns + e][i] *
                     (one.shift + one.swelling * head.normal[i]);
        }
        Vector3d turn = Vector3d::Zero();
        for (std::size_t t = 0; t < turns; ++t) {
            turn += static_cast<double>(weights[t]) * supports[t][i] * jaw_turns()[t].degrees *
                    kPi / 180 * jaw_turns()[t].axis;
        }
        const double angle = turn.norm();
        if (angle > 0) {
            place = kJawJoint + Eigen::AngleAxisd(angle, turn / angle) * (place - kJawJoint);
        }
        Eigen::Map<Vector3d>(points[i].data()) = place;
    }
    return points;
}

std::vector<Mover> face_movers() {
    std::vector<Mover> all;
    for (const JawTurn& turn : jaw_turns()) all.push_back({turn.name, 0, turn.lowest_weight});
    for (const Expression& one : expressions()) {
        all.push_back({one.name, one.scale, one.lowest_weight});
    }
    return all;
}

}  // namespace

GeneratedSequence generate_face(int frames, std::uint64_t seed, int vertices) {
    require_size("face", frames, vertices);
    const Head head = head_with_vertices(vertices);
    const std::vector<std::vector<double>> supports = supports_of(head);
    GeneratedSequence result = still_sequence(face_movers(), frames, seed);
    result.sequence.faces = head.mesh.faces;
    for (const std::vector<double>& row : supports) {
        for (const double value : row) result.supports.push_back(static_cast<float>(value));
    }
    parallel_for(frames, [&](std::int64_t n) {
        const auto place = at(n);
        result.sequence.shapes[place] =
            pose(head, supports, result.weights.data() + place * result.component_names.size());
    });
    return result;
}

}  // namespace mscomp
