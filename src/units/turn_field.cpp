// SPDX-License-Identifier: MIT
#include "units/turn_field.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <tuple>
#include <utility>

#include "acap/rotation.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"
#include "mscomp/linear/block_cholesky.h"

namespace mscomp {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kFullTurn = 2 * std::numbers::pi;

/// The rotation vector of R that is nearest to `near`.
Vector3d log_near(const Matrix3d& rotation, const Vector3d& near) {
    Vector3d principal = rotation_log(rotation);
    const double angle = principal.norm();
    Vector3d axis = principal;
    if (angle > 1e-9) {
        axis /= angle;
    } else {
        axis = near;
        if (!(near.norm() > 1e-9)) return principal;
        axis.normalize();
    }
    const double turns = std::round((near.dot(axis) - angle) / kFullTurn);
    return principal + kFullTurn * turns * axis;
}

/// J_l(r)⁻¹ of r on any turn; at whole turns, where there is none, the least change.
Matrix3d inverse_left_jacobian(const Vector3d& r) {
    const Matrix3d jacobian = rotation_left_jacobian(r);
    const Matrix3d square = jacobian.transpose() * jacobian + 1e-14 * Matrix3d::Identity();
    return square.inverse() * jacobian.transpose();
}

template <class Body>
void for_chunks(std::size_t count, const Body& body) {
    const Chunks chunks{static_cast<std::int64_t>(count), 256};
    parallel_for(chunks.count(), [&](std::int64_t c) {
        for (std::int64_t i = chunks.begin(c); i < chunks.end(c); ++i) body(at(i));
    });
}

}  // namespace

/// One correction of rotations, and all from the tree to the last rotations.
struct TurnField::Pass {
    std::vector<Matrix3d> rotations;   // (V) before it
    std::vector<Matrix3d> seen;        // (E) R_i exp(ρ) R_jᵀ
    std::vector<Vector3d> residuals;   // (E) its logarithm
    std::vector<Vector3d> correction;  // (V) δ
};

struct TurnField::State {
    std::array<Pass, 2> passes;
    std::vector<Vector3d> vectors;  // (V) of the last rotations
};

TurnField::TurnField(const TriangleMesh& mesh, std::vector<int> roots)
    : vertex_count_(mesh.vertex_count()) {
    const OneRings rings = one_rings_of_faces(vertex_count_, mesh.faces);
    for (int i = 0; i < vertex_count_; ++i) {
        for (int n = rings.offsets[at(i)]; n < rings.offsets[at(i) + 1]; ++n) {
            const int j = rings.neighbors[at(n)];
            if (i < j) edges_.push_back({i, j});  // rising, as neighbours are
        }
    }
    grow_tree(roots);
    factorise();
}

TurnField::TurnField(TurnField&&) noexcept = default;
TurnField& TurnField::operator=(TurnField&&) noexcept = default;
TurnField::~TurnField() = default;

/// Nearest to the root first, in numbers of edges.
void TurnField::grow_tree(const std::vector<int>& wanted) {
    std::vector<std::vector<std::pair<int, int>>> beside(at(vertex_count_));
    for (std::size_t e = 0; e < edges_.size(); ++e) {
        const auto [i, j] = edges_[e];
        beside[at(i)].emplace_back(j, static_cast<int>(e));
        beside[at(j)].emplace_back(i, static_cast<int>(e));
    }
    std::vector<char> is_reached(beside.size(), 0);
    const auto grow = [&](int root) {
        roots_.push_back(root);
        first_step_.push_back(steps_.size());
        is_reached[at(root)] = 1;
        std::vector<int> front{root};
        for (std::size_t next = 0; next < front.size(); ++next) {
            for (const auto& [to, edge] : beside[at(front[next])]) {
                if (is_reached[at(to)] != 0) continue;
                is_reached[at(to)] = 1;
                steps_.push_back({edge, front[next], to});
                front.push_back(to);
            }
        }
    };
    for (const int root : wanted) {
        if (root < 0 || root >= vertex_count_ || is_reached[at(root)] != 0) {
            throw UsageError(fmt::format("vertex {} as the root of a piece of its own", root));
        }
        grow(root);
    }
    for (int v = 0; v < vertex_count_; ++v) {
        if (is_reached[at(v)] != 0) continue;
        if (!wanted.empty()) throw UsageError(fmt::format("no root in the piece of vertex {}", v));
        grow(v);
    }
    first_step_.push_back(steps_.size());
}

void TurnField::factorise() {
    unknown_.assign(at(vertex_count_), 0);
    for (const int root : roots_) unknown_[at(root)] = -1;
    int count = 0;
    for (int& place : unknown_) {
        if (place == 0) place = count++;
    }
    if (count == 0) return;
    std::vector<Eigen::Triplet<double>> entries;
    for (const auto& [i, j] : edges_) {
        const int a = unknown_[at(i)], b = unknown_[at(j)];
        if (a >= 0) entries.emplace_back(a, a, 1.0);
        if (b >= 0) entries.emplace_back(b, b, 1.0);
        if (a >= 0 && b >= 0) entries.emplace_back(std::max(a, b), std::min(a, b), -1.0);
    }
    Eigen::SparseMatrix<double> matrix(count, count);
    matrix.setFromTriplets(entries.begin(), entries.end());
    laplacian_ = std::make_unique<BlockCholesky>(matrix, "the Laplacian of rotations");
}

std::vector<std::vector<int>> TurnField::pieces() const {
    std::vector<std::vector<int>> pieces;
    for (std::size_t p = 0; p < roots_.size(); ++p) {
        std::vector<int> piece{roots_[p]};
        for (std::size_t s = first_step_[p]; s < first_step_[p + 1]; ++s) {
            piece.push_back(steps_[s].to);
        }
        pieces.push_back(std::move(piece));
    }
    return pieces;
}

std::vector<float> TurnField::turns_of(std::span<const float> vectors) const {
    std::vector<Matrix3d> rotations(at(vertex_count_));
    for_chunks(rotations.size(), [&](std::size_t v) {
        rotations[v] =
            rotation_exp(Eigen::Map<const Eigen::Vector3f>(vectors.data() + 3 * v).cast<double>());
    });
    std::vector<float> turns(3 * edges_.size());
    for_chunks(edges_.size(), [&](std::size_t e) {
        const auto [i, j] = edges_[e];
        Eigen::Map<Eigen::Vector3f>(turns.data() + 3 * e) =
            rotation_log(rotations[at(i)].transpose() * rotations[at(j)]).cast<float>();
    });
    return turns;
}

TurnField::State TurnField::state_of(const std::vector<Vector3d>& turns,
                                     const std::vector<Vector3d>& roots) const {
    std::vector<Matrix3d> rotations(at(vertex_count_));
    std::vector<Vector3d> near(rotations.size());
    for (std::size_t p = 0; p < roots_.size(); ++p) {
        rotations[at(roots_[p])] = rotation_exp(roots[p]);
        near[at(roots_[p])] = roots[p];
    }
    for (const Step& step : steps_) {
        const bool is_forth = edges_[at(step.edge)][0] == step.from;
        const Vector3d& turn = turns[at(step.edge)];
        rotations[at(step.to)] =
            rotations[at(step.from)] * rotation_exp(is_forth ? turn : Vector3d(-turn));
        near[at(step.to)] = log_near(rotations[at(step.to)], near[at(step.from)]);
    }
    State state;
    for (Pass& pass : state.passes) {
        pass.rotations = rotations;
        correct(turns, pass);
        for_chunks(rotations.size(), [&](std::size_t v) {
            rotations[v] = rotation_exp(pass.correction[v]) * pass.rotations[v];
        });
    }
    state.vectors.resize(rotations.size());
    for_chunks(rotations.size(),
               [&](std::size_t v) { state.vectors[v] = log_near(rotations[v], near[v]); });
    return state;
}

/// All of it from the rotations.
void TurnField::correct(const std::vector<Vector3d>& turns, Pass& pass) const {
    pass.seen.resize(edges_.size());
    pass.residuals.resize(edges_.size());
    for_chunks(edges_.size(), [&](std::size_t e) {
        const auto [i, j] = edges_[e];
        pass.seen[e] =
            pass.rotations[at(i)] * rotation_exp(turns[e]) * pass.rotations[at(j)].transpose();
        pass.residuals[e] = rotation_log(pass.seen[e]);
    });
    pass.correction = corrected(pass.residuals);
}

std::vector<Vector3d> TurnField::corrected(const std::vector<Vector3d>& residuals) const {
    std::vector<Vector3d> correction(at(vertex_count_), Vector3d::Zero());
    for (std::size_t e = 0; e < edges_.size(); ++e) {
        correction[at(edges_[e][0])] -= residuals[e];
        correction[at(edges_[e][1])] += residuals[e];
    }
    solve_laplacian(correction);
    return correction;
}

void TurnField::solve_laplacian(std::vector<Vector3d>& values) const {
    std::vector<Lanes<4>> sides(at(vertex_count_) - roots_.size(), Lanes<4>{}), work;
    for (std::size_t v = 0; v < values.size(); ++v) {
        const Vector3d& value = values[v];
        if (unknown_[v] >= 0) sides[at(unknown_[v])] = {value[0], value[1], value[2], 0};
    }
    if (laplacian_) laplacian_->solve<4>(sides, work);
    for (std::size_t v = 0; v < values.size(); ++v) {
        if (unknown_[v] < 0) {
            values[v].setZero();
        } else {
            const Lanes<4>& found = sides[at(unknown_[v])];
            values[v] = {found[0], found[1], found[2]};
        }
    }
}

void TurnField::subtract_means(std::vector<Vector3d>& values) const {
    for (std::size_t p = 0; p < roots_.size(); ++p) {
        const std::span<const Step> steps =
            std::span(steps_).subspan(first_step_[p], first_step_[p + 1] - first_step_[p]);
        Vector3d mean = values[at(roots_[p])];
        for (const Step& step : steps) mean += values[at(step.to)];
        mean /= static_cast<double>(steps.size() + 1);
        values[at(roots_[p])] -= mean;
        for (const Step& step : steps) values[at(step.to)] -= mean;
    }
}

std::vector<Vector3d> TurnField::added_up(const std::vector<Vector3d>& turns) const {
    std::vector<Vector3d> sums = corrected(turns);
    subtract_means(sums);
    return sums;
}

std::vector<Vector3d> TurnField::shared_out(std::vector<Vector3d> rotations) const {
    subtract_means(rotations);
    solve_laplacian(rotations);
    std::vector<Vector3d> turns(edges_.size());
    for (std::size_t e = 0; e < edges_.size(); ++e) {
        turns[e] = rotations[at(edges_[e][1])] - rotations[at(edges_[e][0])];
    }
    return turns;
}

std::vector<Vector3d> TurnField::integrated(const std::vector<Vector3d>& turns,
                                            const std::vector<Vector3d>& roots) const {
    return state_of(turns, roots).vectors;
}

namespace {

/// How a correction carries over what changes.
struct Carried {
    std::vector<Matrix3d> forth, of_residual;      // (E)
    std::vector<Matrix3d> of_correction, carried;  // (V)
};

}  // namespace

// Spins θ say how rotations change, dR = θ × R: along the tree, through the residuals of edges and
// the corrections to the rotation vectors.
std::vector<std::vector<Vector3d>> TurnField::derivatives(
    const std::vector<Vector3d>& turns, const std::vector<Vector3d>& roots,
    const std::vector<Direction>& directions) const {
    const State state = state_of(turns, roots);
    const std::size_t vertices = at(vertex_count_);
    std::array<Carried, std::tuple_size_v<decltype(state.passes)>> through;
    for (std::size_t p = 0; p < through.size(); ++p) {
        const Pass& pass = state.passes[p];
        Carried& own = through[p];
        own.forth.resize(edges_.size());
        own.of_residual.resize(edges_.size());
        for_chunks(edges_.size(), [&](std::size_t e) {
            own.forth[e] = pass.rotations[at(edges_[e][0])] * rotation_left_jacobian(turns[e]);
            own.of_residual[e] = inverse_left_jacobian(pass.residuals[e]);
        });
        own.of_correction.resize(vertices);
        own.carried.resize(vertices);
        for_chunks(vertices, [&](std::size_t v) {
            own.of_correction[v] = rotation_left_jacobian(pass.correction[v]);
            own.carried[v] = rotation_exp(pass.correction[v]);
        });
    }
    const std::vector<Matrix3d>& along_tree = state.passes.front().rotations;
    std::vector<Matrix3d> back(edges_.size()), of_vector(vertices);
    for_chunks(edges_.size(), [&](std::size_t e) {
        back[e] = -along_tree[at(edges_[e][1])] * rotation_left_jacobian(-turns[e]);
    });
    for_chunks(vertices,
               [&](std::size_t v) { of_vector[v] = inverse_left_jacobian(state.vectors[v]); });
    std::vector<std::vector<Vector3d>> changes(directions.size());
    parallel_for(std::ssize(directions), [&](std::int64_t d) {
        const Direction& direction = directions[at(d)];
        std::vector<Vector3d> spins(vertices), residuals(edges_.size());
        for (std::size_t p = 0; p < roots_.size(); ++p) {
            spins[at(roots_[p])] = rotation_left_jacobian(roots[p]) * direction.roots[p];
        }
        for (const Step& step : steps_) {
            const auto e = at(step.edge);
            const Matrix3d& moved = edges_[e][0] == step.from ? through.front().forth[e] : back[e];
            spins[at(step.to)] = spins[at(step.from)] + moved * direction.turns[e];
        }
        for (std::size_t p = 0; p < through.size(); ++p) {
            const Carried& own = through[p];
            for (std::size_t e = 0; e < edges_.size(); ++e) {
                const auto [i, j] = edges_[e];
                residuals[e] =
                    own.of_residual[e] * (spins[at(i)] + own.forth[e] * direction.turns[e] -
                                          state.passes[p].seen[e] * spins[at(j)]);
            }
            const std::vector<Vector3d> correction = corrected(residuals);
            for (std::size_t v = 0; v < vertices; ++v) {
                spins[v] = own.of_correction[v] * correction[v] + own.carried[v] * spins[v];
            }
        }
        for (std::size_t v = 0; v < vertices; ++v) spins[v] = of_vector[v] * spins[v];
        changes[at(d)] = std::move(spins);
    });
    return changes;
}

}  // namespace mscomp
