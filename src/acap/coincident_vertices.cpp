// SPDX-License-Identifier: MIT
#include "coincident_vertices.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "mscomp/base/index.h"
#include "mscomp/base/points.h"

namespace mscomp {
namespace {

constexpr double kSameOfSize = 1e-7;
/// Beside the largest coordinate: two units in the last place of float32, for what was written so.
constexpr double kSameOfCoordinate = 2.4e-7;
/// Cells of the grid, in distances that count as none: so large that nearly every vertex has to
/// look into its own only.
constexpr double kCell = 1000;

using Cell = std::array<std::int64_t, 3>;

struct Bounds {
    Point lowest, highest;

    explicit Bounds(const std::vector<Point>& points) {
        lowest.fill(std::numeric_limits<double>::infinity());
        highest.fill(-std::numeric_limits<double>::infinity());
        for (const Point& p : points) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                lowest[axis] = std::min(lowest[axis], p[axis]);
                highest[axis] = std::max(highest[axis], p[axis]);
            }
        }
    }
    /// How far apart vertices may be that lie on each other.
    double tolerance() const {
        double size = 0, coordinate = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            size = std::max(size, highest[axis] - lowest[axis]);
            coordinate = std::max({coordinate, std::abs(lowest[axis]), std::abs(highest[axis])});
        }
        return std::max(kSameOfSize * size, std::min(kSameOfCoordinate * coordinate, 1e-5 * size));
    }
};

std::vector<Point> chosen(const std::vector<Point>& points, const std::vector<int>& which) {
    std::vector<Point> result;
    result.reserve(which.size());
    for (const int v : which) result.push_back(points[at(v)]);
    return result;
}

/// Groups of indices of points that lie on each other: those on the lowest index, the lowest of
/// what is left, and so on.
std::vector<std::vector<int>> groups_of(const std::vector<Point>& points) {
    const Bounds bounds(points);
    const double tolerance = bounds.tolerance(), width = kCell * tolerance;
    if (!(width > 0)) return {};
    const auto cell_of = [&](const Point& p, double shift) {
        Cell cell;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            cell[axis] = static_cast<std::int64_t>(
                std::floor((p[axis] + shift - bounds.lowest[axis]) / width));
        }
        return cell;
    };
    std::vector<std::pair<Cell, int>> cells;
    cells.reserve(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        cells.emplace_back(cell_of(points[i], 0), static_cast<int>(i));
    }
    std::ranges::sort(cells);
    std::vector<char> taken(points.size(), 0);
    std::vector<std::vector<int>> groups;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (taken[i] != 0) continue;
        std::vector<int> group{static_cast<int>(i)};
        const Cell low = cell_of(points[i], -tolerance), high = cell_of(points[i], tolerance);
        for (Cell c = low; c[0] <= high[0]; ++c[0]) {
            for (c[1] = low[1]; c[1] <= high[1]; ++c[1]) {
                // Cells along the last axis follow each other in the order of the cells.
                const Cell first{c[0], c[1], low[2]}, last{c[0], c[1], high[2]};
                auto entry = std::ranges::lower_bound(cells, std::pair(first, static_cast<int>(i)));
                for (; entry != cells.end() && entry->first <= last; ++entry) {
                    const auto j = at(entry->second);
                    if (j <= i || taken[j] != 0) continue;
                    if (square_distance(points[i], points[j]) > tolerance * tolerance) continue;
                    group.push_back(entry->second);
                }
            }
        }
        if (group.size() < 2) continue;
        std::ranges::sort(group);
        for (const int member : group) taken[at(member)] = 1;
        groups.push_back(std::move(group));
    }
    return groups;
}

std::vector<int> vertices_in(const std::vector<Face>& faces) {
    std::vector<int> result;
    result.reserve(3 * faces.size());
    for (const Face& face : faces) result.insert(result.end(), face.begin(), face.end());
    std::ranges::sort(result);
    result.erase(std::unique(result.begin(), result.end()), result.end());
    return result;
}

}  // namespace

CoincidentVertices::CoincidentVertices(const TriangleMesh& reference)
    : vertex_count_(reference.vertices.size()), used_(vertices_in(reference.faces)) {
    for (const std::vector<int>& group : groups_of(chosen(reference.vertices, used_))) {
        const auto first = static_cast<int>(members_.size());
        for (const int member : group) {
            members_.push_back(used_[at(member)]);
            first_.push_back(first);
        }
        group_ends_.push_back(members_.size());
    }
}

bool CoincidentVertices::any() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (std::size_t m = 0; m < first_.size(); ++m) {
        if (at(first_[m]) != m) return true;
    }
    return false;
}

std::vector<int> CoincidentVertices::firsts_in(const std::vector<Point>& shape) const {
    const double tolerance = Bounds(chosen(shape, used_)).tolerance();
    const double square = tolerance * tolerance;
    std::vector<int> firsts(members_.size());
    std::size_t begin = 0;
    for (const std::size_t end : group_ends_) {
        std::vector<std::size_t> leaders;
        for (std::size_t m = begin; m < end; ++m) {
            const Point& p = shape[at(members_[m])];
            const auto leader = std::ranges::find_if(leaders, [&](std::size_t l) {
                return square_distance(p, shape[at(members_[l])]) <= square;
            });
            if (leader == leaders.end()) {
                leaders.push_back(m);
                firsts[m] = static_cast<int>(m);
            } else {
                firsts[m] = static_cast<int>(*leader);
            }
        }
        begin = end;
    }
    return firsts;
}

void CoincidentVertices::keep(const std::vector<Point>& shape) {
    if (members_.empty()) return;
    const std::vector<int> own = firsts_in(shape);
    const std::lock_guard<std::mutex> lock(mutex_);
    std::map<std::pair<int, int>, int> first_of_both;
    for (std::size_t m = 0; m < first_.size(); ++m) {
        first_[m] =
            first_of_both.try_emplace({first_[m], own[m]}, static_cast<int>(m)).first->second;
    }
}

std::vector<int> CoincidentVertices::lowest() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::vector<int> result(vertex_count_);
    std::iota(result.begin(), result.end(), 0);
    for (std::size_t m = 0; m < members_.size(); ++m) {
        result[at(members_[m])] = members_[at(first_[m])];
    }
    return result;
}

}  // namespace mscomp
