// SPDX-License-Identifier: MIT
#include "anchored_system.h"

#include <algorithm>

#include "mscomp/base/index.h"

namespace mscomp {

void add_laplacian(const OneRings& rings, const std::vector<double>& weights, double share,
                   MatrixEntries& entries) {
    entries.reserve(entries.size() + 3 * (rings.neighbors.size() / 2));
    for (int i = 0; i < rings.vertex_count(); ++i) {
        for (int place = rings.offsets[at(i)]; place < rings.offsets[at(i) + 1]; ++place) {
            const auto k = at(place);
            entries.emplace_back(i, i, share * weights[k]);
            if (rings.neighbors[k] > i) continue;
            entries.emplace_back(i, rings.neighbors[k], -share * weights[k]);
        }
    }
}

void add_ring_squares(const OneRings& rings, const std::vector<Eigen::Vector3d>& factors,
                      MatrixEntries& entries) {
    std::size_t count = 0;
    for (int i = 0; i < rings.vertex_count(); ++i) {
        const auto size = at(rings.degree(i)) + 1;
        count += size * (size + 1) / 2;
    }
    entries.reserve(entries.size() + count);
    std::vector<int> members;
    std::vector<Eigen::Vector3d> columns;
    for (int i = 0; i < rings.vertex_count(); ++i) {
        members.assign(1, i);
        columns.assign(1, Eigen::Vector3d::Zero());
        for (int place = rings.offsets[at(i)]; place < rings.offsets[at(i) + 1]; ++place) {
            const auto k = at(place);
            members.push_back(rings.neighbors[k]);
            columns.push_back(factors[k]);
            columns.front() -= factors[k];
        }
        for (std::size_t a = 0; a < members.size(); ++a) {
            for (std::size_t b = 0; b < members.size(); ++b) {
                if (members[b] > members[a]) continue;
                entries.emplace_back(members[a], members[b], columns[a].dot(columns[b]));
            }
        }
    }
}

AnchoredSystem::AnchoredSystem(MatrixEntries entries, int vertex_count,
                               const std::vector<int>& anchors, const std::string& name,
                               const AnchoredSystem* like)
    : unknown_(at(vertex_count), 0) {
    for (const int anchor : anchors) unknown_[at(anchor)] = -1;
    for (int& row : unknown_) {
        if (row == 0) row = unknown_count_++;
    }
    std::size_t kept = 0;
    for (const auto& entry : entries) {
        const int row = unknown_[at(entry.row())];
        const int column = unknown_[at(entry.col())];
        if (row >= 0 && column >= 0) entries[kept++] = {row, column, entry.value()};
    }
    entries.resize(kept);
    if (unknown_count_ == 0) return;
    Eigen::SparseMatrix<double> matrix(unknown_count_, unknown_count_);
    matrix.setFromTriplets(entries.begin(), entries.end());
    entries = {};
    if (like != nullptr) {
        factor_.emplace(matrix, name, *like->factor_);
    } else {
        factor_.emplace(matrix, name);
    }
}

std::vector<Lanes<4>> AnchoredSystem::rows_of_unknowns(const std::vector<Point>& points) const {
    std::vector<Lanes<4>> rows(at(unknown_count_));
    for (std::size_t i = 0; i < unknown_.size(); ++i) {
        if (unknown_[i] < 0) continue;
        const auto& [x, y, z] = points[i];
        rows[at(unknown_[i])] = {x, y, z, 0};
    }
    return rows;
}

std::vector<Point> AnchoredSystem::points_of_rows(const std::vector<Lanes<4>>& rows) const {
    std::vector<Point> result(unknown_.size(), Point{});
    for (std::size_t i = 0; i < unknown_.size(); ++i) {
        if (unknown_[i] < 0) continue;
        const auto& [x, y, z, empty] = rows[at(unknown_[i])];
        result[i] = {x, y, z};
    }
    return result;
}

std::vector<Point> AnchoredSystem::solve(const std::vector<Point>& right_hand_sides) const {
    std::vector<Lanes<4>> rows = rows_of_unknowns(right_hand_sides), work;
    if (factor_) factor_->solve(rows, work);
    return points_of_rows(rows);
}

Eigen::VectorXd AnchoredSystem::whitened(const std::vector<Point>& right_hand_sides) const {
    std::vector<Lanes<4>> rows = rows_of_unknowns(right_hand_sides), work;
    if (factor_) factor_->solve_half(rows, work);
    Eigen::VectorXd y(3 * unknown_count_);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        std::copy_n(rows[i].data(), 3, y.data() + 3 * i);
    }
    return y;
}

std::vector<Point> AnchoredSystem::from_whitened(const Eigen::Ref<const Eigen::VectorXd>& y) const {
    std::vector<Lanes<4>> rows(at(unknown_count_), Lanes<4>{}), work;
    for (std::size_t i = 0; i < rows.size(); ++i) std::copy_n(y.data() + 3 * i, 3, rows[i].data());
    if (factor_) factor_->solve_transposed_half(rows, work);
    return points_of_rows(rows);
}

void AnchoredSystem::solve(std::vector<Lanes<8>>& rows, std::vector<Lanes<8>>& work,
                           std::vector<Lanes<8>>& scratch) const {
    work.resize(at(unknown_count_));
    for (std::size_t i = 0; i < unknown_.size(); ++i) {
        if (unknown_[i] >= 0) work[at(unknown_[i])] = rows[i];
    }
    if (factor_) factor_->solve(work, scratch);
    for (std::size_t i = 0; i < unknown_.size(); ++i) {
        rows[i] = unknown_[i] < 0 ? Lanes<8>{} : work[at(unknown_[i])];
    }
}

}  // namespace mscomp
