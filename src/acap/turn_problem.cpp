// SPDX-License-Identifier: MIT
#include "turn_problem.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <queue>
#include <tuple>

namespace mscomp {
namespace {

// A smaller angle says nothing about the axis: rotation noise of a file with six digits.
constexpr double kFreeAngle = 1e-4;

/// Visits every vertex from the roots, always over the cheapest edge that leads to a new one (ties:
/// the lowest vertex); visit(from, to) is called once per vertex that is no root.
template <class Cost, class Visit>
void grow_from_roots(const ConsistencyGraph& graph, const Cost& cost, const Visit& visit) {
    using Step = std::tuple<double, int, int>;  // cost, to, from
    std::priority_queue<Step, std::vector<Step>, std::greater<>> front;
    std::vector<char> reached(graph.component.size(), 0);
    const auto reach = [&](int vertex) {
        const auto v = static_cast<std::size_t>(vertex);
        reached[v] = 1;
        for (int at = graph.rings.offsets[v]; at < graph.rings.offsets[v + 1]; ++at) {
            const int next = graph.rings.neighbors[static_cast<std::size_t>(at)];
            if (reached[static_cast<std::size_t>(next)] == 0) {
                front.emplace(cost(vertex, next), next, vertex);
            }
        }
    };
    for (const int root : graph.roots) reach(root);
    while (!front.empty()) {
        const auto [step_cost, to, from] = front.top();
        front.pop();
        if (reached[static_cast<std::size_t>(to)] != 0) continue;
        visit(from, to);
        reach(to);
    }
}

}  // namespace

TurnProblem::TurnProblem(const ConsistencyGraph& graph,
                         const std::vector<Eigen::Vector3d>& principal)
    : graph_(graph), axis_(principal), angle_(principal.size()), root_(principal.size(), 0) {
    for (const int root : graph.roots) root_[static_cast<std::size_t>(root)] = 1;
    std::vector<char> known(principal.size(), 0);
    bool all_known = true;
    for (std::size_t i = 0; i < axis_.size(); ++i) {
        angle_[i] = axis_[i].norm();
        known[i] = angle_[i] > kFreeAngle ? 1 : 0;
        all_known = all_known && known[i] != 0;
        if (known[i] != 0) axis_[i] /= angle_[i];
    }
    if (!all_known) choose_free_axes(std::move(known));
}

void TurnProblem::choose_free_axes(std::vector<char> known) {
    std::vector<Eigen::Matrix3d> spread(axis_.size(), Eigen::Matrix3d::Zero());
    const OneRings& rings = graph_.rings;
    const auto count = axis_.size();
    // Layer by layer away from the known axes; an axis has no sign, so lines are averaged. The
    // weight sin²(θ/2) keeps the noisy axes of small angles out.
    for (bool grew = true; grew;) {
        grew = false;
        std::vector<char> next = known;
        for (std::size_t i = 0; i < count; ++i) {
            if (known[i] != 0) continue;
            Eigen::Matrix3d lines = Eigen::Matrix3d::Zero();
            for (int at = rings.offsets[i]; at < rings.offsets[i + 1]; ++at) {
                const auto j =
                    static_cast<std::size_t>(rings.neighbors[static_cast<std::size_t>(at)]);
                if (known[j] == 0) continue;
                const double sine = std::sin(0.5 * std::max(angle_[j], kFreeAngle));
                lines += sine * sine * axis_[j] * axis_[j].transpose();
            }
            if (lines.trace() <= 0) continue;
            spread[i] = lines / lines.trace();
            next[i] = 2;
            grew = true;
        }
        for (std::size_t i = 0; i < count; ++i) {
            if (next[i] != 2 || known[i] != 0) continue;
            const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(spread[i]);
            const Eigen::Vector3d line = eigen.eigenvectors().col(2);
            angle_[i] = line.dot(axis_[i]);
            axis_[i] = line;
        }
        known = std::move(next);
    }
    for (std::size_t i = 0; i < count; ++i) {
        if (known[i] != 0) continue;
        angle_[i] = axis_[i].norm();
        axis_[i] = angle_[i] > 0 ? Eigen::Vector3d(axis_[i] / angle_[i]) : Eigen::Vector3d::UnitZ();
    }
}

int TurnProblem::nearest_turn(int vertex, const Eigen::Vector3d& target) const {
    if (is_root(vertex)) return 0;
    return static_cast<int>(std::lround((axis(vertex).dot(target) - angle(vertex)) / kTurn));
}

double TurnProblem::energy(const Turns& turns) const {
    double sum = 0;
    for (const auto& [i, j] : graph_.edges) {
        sum += (rotation_vector(i, turns[static_cast<std::size_t>(i)]) -
                rotation_vector(j, turns[static_cast<std::size_t>(j)]))
                   .squaredNorm();
    }
    return sum;
}

double TurnProblem::edge_minimum(int i, int j) const {
    // With x = θ_i + 2π t_i and y = ±(θ_j + 2π t_j), the sign chosen so that c = |a_i·a_j|, the
    // energy is Δ² + 2 (1 - c) y (y + Δ) for Δ = x - y: at fixed Δ least for y nearest to -Δ/2, and
    // at least Δ²/2, so that |Δ| beyond 5π/2 cannot win.
    const double cosine = axis(i).dot(axis(j));
    const double sign = cosine < 0 ? -1 : 1;
    const double c = std::min(std::abs(cosine), 1.0);
    const double x = angle(i), y = sign * angle(j);
    double least = (x - y) * (x - y) + 2 * (1 - c) * x * y;
    for (int k = -2; k <= 2; ++k) {
        const double delta = x - y + kTurn * k;
        const double shifted = y + kTurn * std::round((-0.5 * delta - y) / kTurn);
        least = std::min(least, delta * delta + 2 * (1 - c) * shifted * (shifted + delta));
    }
    return least;
}

double TurnProblem::lower_bound() const {
    double sum = 0;
    for (const auto& [i, j] : graph_.edges) sum += edge_minimum(i, j);
    return sum;
}

TurnProblem::Turns TurnProblem::propagated() const {
    Turns turns(axis_.size(), 0);
    // 1 - |<q_i, q_j>| of the unit quaternions grows with the angle between the rotations.
    const auto distance = [this](int i, int j) {
        const double a = 0.5 * angle(i), b = 0.5 * angle(j);
        return 1 - std::abs(std::cos(a) * std::cos(b) +
                            std::sin(a) * std::sin(b) * axis(i).dot(axis(j)));
    };
    grow_from_roots(graph_, distance, [&](int from, int to) {
        turns[static_cast<std::size_t>(to)] =
            nearest_turn(to, rotation_vector(from, turns[static_cast<std::size_t>(from)]));
    });
    return turns;
}

std::vector<int> TurnProblem::orientation() const {
    std::vector<int> sign(axis_.size(), 1);
    const auto crossing = [this](int i, int j) { return 1 - std::abs(axis(i).dot(axis(j))); };
    grow_from_roots(graph_, crossing, [&](int from, int to) {
        const int same = axis(from).dot(axis(to)) < 0 ? -1 : 1;
        sign[static_cast<std::size_t>(to)] = same * sign[static_cast<std::size_t>(from)];
    });
    return sign;
}

}  // namespace mscomp
