// SPDX-License-Identifier: MIT
#include "turn_problem.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "mscomp/base/index.h"
#include "step_queue.h"

namespace mscomp {
namespace {

// A smaller angle says nothing about the axis: rotation noise of a file with six digits.
constexpr double kFreeAngle = 1e-4;

}  // namespace

TurnProblem::TurnProblem(const ConsistencyGraph& graph, const std::vector<Eigen::Vector3d>& vectors)
    : graph_(graph), axis_(vectors), angle_(vectors.size()), root_(vectors.size(), 0) {
    for (const int root : graph.roots) root_[at(root)] = 1;
    std::vector<char> known(vectors.size(), 0);
    bool all_known = true;
    for (std::size_t i = 0; i < axis_.size(); ++i) {
        angle_[i] = axis_[i].norm();
        known[i] = angle_[i] > kFreeAngle ? 1 : 0;
        all_known = all_known && known[i] != 0;
        if (known[i] != 0) axis_[i] /= angle_[i];
    }
    if (!all_known) choose_free_axes(std::move(known));

    const OneRings& rings = graph.rings;
    cosine_.resize(rings.neighbors.size());
    for (std::size_t i = 0; i < axis_.size(); ++i) {
        for (int place = rings.offsets[i]; place < rings.offsets[i + 1]; ++place) {
            const auto k = at(place);
            const auto j = at(rings.neighbors[k]);
            if (j < i) continue;
            const double cosine = std::clamp(axis_[i].dot(axis_[j]), -1.0, 1.0);
            cosine_[k] = cosine_[at(graph.reverse[k])] = cosine;
        }
    }
}

void TurnProblem::choose_free_axes(std::vector<char> known) {
    const OneRings& rings = graph_.rings;
    const auto neighbor = [&](int place) { return at(rings.neighbors[at(place)]); };
    // Layer by layer away from the known axes.
    std::vector<std::size_t> layer;
    const auto add_free_neighbors = [&](std::size_t vertex, std::vector<std::size_t>& found) {
        for (int place = rings.offsets[vertex]; place < rings.offsets[vertex + 1]; ++place) {
            const std::size_t j = neighbor(place);
            if (known[j] != 0) continue;
            known[j] = 2;  // in the next layer
            found.push_back(j);
        }
    };
    for (std::size_t i = 0; i < axis_.size(); ++i) {
        if (known[i] == 1) add_free_neighbors(i, layer);
    }
    while (!layer.empty()) {
        std::vector<Eigen::Vector3d> lines(layer.size());
        for (std::size_t k = 0; k < layer.size(); ++k) {
            // An axis has no sign, so lines are averaged. The weight sin²(θ/2) keeps the noisy axes
            // of small angles out.
            Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
            for (int place = rings.offsets[layer[k]]; place < rings.offsets[layer[k] + 1];
                 ++place) {
                const std::size_t j = neighbor(place);
                if (known[j] != 1) continue;
                const double sine = std::sin(0.5 * std::max(angle_[j], kFreeAngle));
                spread += sine * sine * axis_[j] * axis_[j].transpose();
            }
            spread /= spread.trace();
            const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(spread);
            lines[k] = eigen.eigenvectors().col(2);
        }
        for (std::size_t k = 0; k < layer.size(); ++k) {
            angle_[layer[k]] = lines[k].dot(axis_[layer[k]]);
            axis_[layer[k]] = lines[k];
            known[layer[k]] = 1;
        }
        std::vector<std::size_t> next;
        for (const std::size_t vertex : layer) add_free_neighbors(vertex, next);
        layer = std::move(next);
    }
    for (std::size_t i = 0; i < axis_.size(); ++i) {
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
    std::vector<Eigen::Vector3d> vectors(turns.size());
    for (std::size_t i = 0; i < turns.size(); ++i) {
        vectors[i] = rotation_vector(static_cast<int>(i), turns[i]);
    }
    double sum = 0;
    for (const auto& [i, j] : graph_.edges) {
        sum += (vectors[at(i)] - vectors[at(j)]).squaredNorm();
    }
    return sum;
}

double TurnProblem::pull(const Turns& turns, int vertex) const {
    const OneRings& rings = graph_.rings;
    const auto v = at(vertex);
    double sum = 0;
    for (int place = rings.offsets[v]; place < rings.offsets[v + 1]; ++place) {
        const auto j = at(rings.neighbors[at(place)]);
        sum += cosine_[at(place)] * (angle_[j] + kTurn * turns[j]);
    }
    return sum;
}

double TurnProblem::change(const Turns& turns, int vertex, int turn) const {
    // As a function of x = θ + 2π t the energy is degree x² - 2 x pull + constant.
    const auto v = at(vertex);
    const double before = angle_[v] + kTurn * turns[v], after = angle_[v] + kTurn * turn;
    const int degree = graph_.rings.degree(vertex);
    return (after - before) * (degree * (after + before) - 2 * pull(turns, vertex));
}

int TurnProblem::best_turn(const Turns& turns, int vertex) const {
    const int degree = graph_.rings.degree(vertex);
    if (is_root(vertex) || degree == 0) return turns[at(vertex)];
    return static_cast<int>(std::lround((pull(turns, vertex) / degree - angle(vertex)) / kTurn));
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
    const double middle = std::round((y - x) / kTurn);
    for (int k = -2; k <= 2; ++k) {
        const double delta = x - y + kTurn * (middle + k);
        const double shifted = y + kTurn * std::round((-0.5 * delta - y) / kTurn);
        least = std::min(least, delta * delta + 2 * (1 - c) * shifted * (shifted + delta));
    }
    return least;
}

TurnProblem::Turns TurnProblem::propagated() const {
    const OneRings& rings = graph_.rings;
    std::vector<double> sines(axis_.size()), halves(axis_.size());  // of the unit quaternions
    for (std::size_t i = 0; i < axis_.size(); ++i) {
        sines[i] = std::sin(0.5 * angle_[i]);
        halves[i] = std::cos(0.5 * angle_[i]);
    }
    Turns turns(axis_.size(), 0);
    std::vector<char> reached(axis_.size(), 0);
    StepQueue steps;
    const auto reach = [&](std::size_t i) {
        reached[i] = 1;
        for (int place = rings.offsets[i]; place < rings.offsets[i + 1]; ++place) {
            const auto k = at(place);
            const auto j = at(rings.neighbors[k]);
            if (reached[j] != 0) continue;
            // 1 - |<q_i, q_j>| grows with the angle between the rotations.
            const double cosine = halves[i] * halves[j] + sines[i] * sines[j] * cosine_[k];
            steps.push(1 - std::abs(cosine), place);
        }
    };
    for (const int root : graph_.roots) reach(at(root));
    while (!steps.empty()) {
        const auto k = at(steps.pop());
        const auto to = at(rings.neighbors[k]);
        if (reached[to] != 0) continue;
        const auto back = at(graph_.reverse[k]);
        const auto from = at(rings.neighbors[back]);
        const double target = cosine_[k] * (angle_[from] + kTurn * turns[from]);
        turns[to] = static_cast<int>(std::lround((target - angle_[to]) / kTurn));
        reach(to);
    }
    return turns;
}

}  // namespace mscomp
