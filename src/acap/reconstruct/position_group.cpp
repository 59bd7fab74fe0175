// SPDX-License-Identifier: MIT
#include "position_group.h"

#include <algorithm>
#include <cassert>

#include "mscomp/base/index.h"
#include "mscomp/base/vector_widths.h"

// Products and sums stay apart in this file, so that a lane gets the same bits in vectors of any
// width.

namespace mscomp {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::size_t kLanes = PositionGroup::kSize;
using Matrices = PositionGroup::Matrices;
using Rows = std::array<Lanes<kLanes>*, 3>;
using ConstRows = std::array<const Lanes<kLanes>*, 3>;

/// A vertex with its neighbours and what it pulls them with.
struct Ring {
    std::size_t vertex, size;
    const int* neighbors;
    const Vector3d* pulls;
};

Ring ring_of(const LinearPositions& positions, std::size_t vertex) {
    const int begin = positions.rings.offsets[vertex];
    return {vertex, at(positions.rings.offsets[vertex + 1] - begin),
            positions.rings.neighbors.data() + begin, positions.pulls.data() + begin};
}

/// T q to the rows of the neighbours, minus their sum to the own.
MSCOMP_FOR_EACH_VECTOR_WIDTH
void pull_neighbors(const Ring& ring, const Matrices& changes, const Rows& rows) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double* t = changes[3 * axis].data();
        double own[kLanes] = {};
        for (std::size_t n = 0; n < ring.size; ++n) {
            const double* q = ring.pulls[n].data();
            double* other = rows[axis][ring.neighbors[n]].data();
#pragma omp simd
            for (std::size_t l = 0; l < kLanes; ++l) {
                const double pull = t[l] * q[0] + t[kLanes + l] * q[1] + t[2 * kLanes + l] * q[2];
                other[l] += pull;
                own[l] -= pull;
            }
        }
        double* row = rows[axis][ring.vertex].data();
        for (std::size_t l = 0; l < kLanes; ++l) row[l] += own[l];
    }
}

/// Its adjoint: result += Σ_j (x_j - x_v) q_jᵀ.
MSCOMP_FOR_EACH_VECTOR_WIDTH
void gather_from_neighbors(const Ring& ring, const ConstRows& rows, Matrices& result) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double* own = rows[axis][ring.vertex].data();
        double sum[3 * kLanes] = {};
        for (std::size_t n = 0; n < ring.size; ++n) {
            const double* q = ring.pulls[n].data();
            const double* other = rows[axis][ring.neighbors[n]].data();
#pragma omp simd
            for (std::size_t l = 0; l < kLanes; ++l) {
                const double edge = other[l] - own[l];
                sum[l] += edge * q[0];
                sum[kLanes + l] += edge * q[1];
                sum[2 * kLanes + l] += edge * q[2];
            }
        }
        double* to = result[3 * axis].data();
        for (std::size_t l = 0; l < 3 * kLanes; ++l) to[l] += sum[l];
    }
}

}  // namespace

PositionGroup::PositionGroup(const LinearPositions& positions) : positions_(positions) {
    for (auto& rows : rows_) rows.resize(vertex_count());
    if (positions.placement.has_joints()) changes_.resize(vertex_count());
}

void PositionGroup::clear() {
    for (auto& rows : rows_) std::ranges::fill(rows, Lanes<kSize>{});
    std::ranges::fill(changes_, Matrices{});
}

void PositionGroup::add(std::size_t vertex, const Matrices& changes) {
    pull_neighbors(ring_of(positions_, vertex), changes,
                   {rows_[0].data(), rows_[1].data(), rows_[2].data()});
    if (!changes_.empty()) changes_[vertex] = changes;
}

void PositionGroup::add(std::size_t vertex, std::size_t shape, const Matrix3d& change) {
    const Ring ring = ring_of(positions_, vertex);
    Vector3d own = Vector3d::Zero();
    for (std::size_t n = 0; n < ring.size; ++n) {
        const Vector3d pull = change * ring.pulls[n];
        add_to_row(at(ring.neighbors[n]), shape, pull);
        own -= pull;
    }
    add_to_row(vertex, shape, own);
    if (!changes_.empty()) set_matrix(changes_[vertex], shape, change);
}

void PositionGroup::solve() {
    for (auto& rows : rows_) positions_.system.solve(rows, work_, scratch_);
}

void PositionGroup::get(std::span<double> changes) const {
    const std::size_t size = 3 * vertex_count();
    const std::size_t shape_count = size > 0 ? changes.size() / size : 0;
    assert(changes.size() == shape_count * size && shape_count <= kSize);
    const std::vector<int>& component = positions_.placement.component();
    const std::vector<Vectors> shifts = shifts_of_components(shape_count);
    Vectors mean{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t i = 0; i < vertex_count(); ++i) {
            const Lanes<kSize>& shift = shifts[at(component[i])][axis];
            for (std::size_t k = 0; k < kSize; ++k) mean[axis][k] += rows_[axis][i][k] + shift[k];
        }
        for (double& x : mean[axis]) x /= static_cast<double>(vertex_count());
    }
    for (std::size_t i = 0; i < vertex_count(); ++i) {
        const Vectors& shift = shifts[at(component[i])];
        for (std::size_t k = 0; k < shape_count; ++k) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                changes[k * size + 3 * i + axis] =
                    rows_[axis][i][k] + shift[axis][k] - mean[axis][k];
            }
        }
    }
}

void PositionGroup::set(std::span<const double> by_position) {
    const std::size_t size = 3 * vertex_count();
    const std::size_t shape_count = size > 0 ? by_position.size() / size : 0;
    assert(by_position.size() == shape_count * size && shape_count <= kSize);
    clear();
    for (std::size_t i = 0; i < vertex_count(); ++i) {
        for (std::size_t k = 0; k < shape_count; ++k) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                rows_[axis][i][k] = by_position[k * size + 3 * i + axis];
            }
        }
    }
    for (auto& rows : rows_) {
        Lanes<kSize> mean{};
        for (const Lanes<kSize>& row : rows) {
            for (std::size_t k = 0; k < kSize; ++k) mean[k] += row[k];
        }
        for (double& x : mean) x /= static_cast<double>(vertex_count());
        for (Lanes<kSize>& row : rows) {
            for (std::size_t k = 0; k < kSize; ++k) row[k] -= mean[k];
        }
    }
    if (!changes_.empty()) take_back_shifts(shape_count);
}

void PositionGroup::solve_adjoint() { solve(); }  // the matrix is symmetric

void PositionGroup::by_gradient(std::size_t vertex, Matrices& result) const {
    result = changes_.empty() ? Matrices{} : changes_[vertex];
    gather_from_neighbors(ring_of(positions_, vertex),
                          {rows_[0].data(), rows_[1].data(), rows_[2].data()}, result);
}

std::vector<PositionGroup::Vectors> PositionGroup::shifts_of_components(
    std::size_t shape_count) const {
    const Placement& placement = positions_.placement;
    std::vector<Vectors> result(at(placement.component_count()), Vectors{});
    if (changes_.empty()) return result;
    for (std::size_t k = 0; k < shape_count; ++k) {
        const std::vector<Vector3d> shifts =
            placement.shifts([&](int v) { return row(at(v), k); },
                             [&](int v) { return matrix(changes_[at(v)], k); });
        for (std::size_t c = 0; c < shifts.size(); ++c) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                result[c][axis][k] = shifts[c][static_cast<Eigen::Index>(axis)];
            }
        }
    }
    return result;
}

/// The adjoint of the above.
void PositionGroup::take_back_shifts(std::size_t shape_count) {
    const Placement& placement = positions_.placement;
    for (std::size_t k = 0; k < shape_count; ++k) {
        std::vector<Vector3d> by_shift(at(placement.component_count()), Vector3d::Zero());
        for (std::size_t i = 0; i < vertex_count(); ++i) {
            by_shift[at(placement.component()[i])] += row(i, k);
        }
        placement.take_back_shifts(
            by_shift, [&](int v, const Vector3d& value) { add_to_row(at(v), k, value); },
            [&](int v, const Matrix3d& value) {
                Matrices& sums = changes_[at(v)];
                set_matrix(sums, k, matrix(sums, k) + value);
            });
    }
}

void PositionGroup::add_to_row(std::size_t vertex, std::size_t shape, const Vector3d& value) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        rows_[axis][vertex][shape] += value[static_cast<Eigen::Index>(axis)];
    }
}

Vector3d PositionGroup::row(std::size_t vertex, std::size_t shape) const {
    return {rows_[0][vertex][shape], rows_[1][vertex][shape], rows_[2][vertex][shape]};
}

}  // namespace mscomp
