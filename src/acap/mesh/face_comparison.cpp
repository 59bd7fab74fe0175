// SPDX-License-Identifier: MIT
#include "face_comparison.h"

#include <algorithm>
#include <compare>

#include "mscomp/base/index.h"

namespace mscomp {
namespace {

std::strong_ordering compare(std::span<const int> a, std::span<const int> b) {
    return std::lexicographical_compare_three_way(a.begin(), a.end(), b.begin(), b.end());
}

}  // namespace

// In linear time even where corners repeat: two candidates advance; the one that loses a comparison
// also rules out the starts passed on the way.
std::size_t smallest_rotation(std::span<const int> face) {
    const std::size_t count = face.size();
    const auto corner = [&](std::size_t i) { return face[i < count ? i : i - count]; };
    std::size_t a = 0, b = 1, equal = 0;
    while (a < count && b < count && equal < count) {
        if (corner(a + equal) == corner(b + equal)) {
            ++equal;
            continue;
        }
        (corner(a + equal) > corner(b + equal) ? a : b) += equal + 1;
        if (a == b) ++b;
        equal = 0;
    }
    return std::min(a, b);
}

SortedFaces::SortedFaces(const PolygonMesh& mesh) : ends_(mesh.ends) {
    corners_.reserve(mesh.corners.size());
    for (std::size_t i = 0; i < mesh.face_count(); ++i) {
        const std::span<const int> face = mesh.face(i);
        const auto start = face.begin() + static_cast<std::ptrdiff_t>(smallest_rotation(face));
        corners_.insert(corners_.end(), start, face.end());
        corners_.insert(corners_.end(), face.begin(), start);
    }
    sort_by_first_corner(mesh.vertices.size());
    sort_faces_of_one_corner();
}

/// Counts and places: a comparison sort takes several times as long for a million faces.
void SortedFaces::sort_by_first_corner(std::size_t vertex_count) {
    std::vector<std::size_t> next(vertex_count + 1);
    for (std::size_t i = 0; i < ends_.size(); ++i) {
        ++next[at(face(i).front()) + 1];
    }
    for (std::size_t v = 0; v < vertex_count; ++v) next[v + 1] += next[v];
    order_.resize(ends_.size());
    for (std::size_t i = 0; i < ends_.size(); ++i) {
        order_[next[at(face(i).front())]++] = i;
    }
}

void SortedFaces::sort_faces_of_one_corner() {
    for (auto begin = order_.begin(); begin != order_.end();) {
        const int corner = face(*begin).front();
        const auto end = std::find_if(begin, order_.end(),
                                      [&](std::size_t i) { return face(i).front() != corner; });
        std::sort(begin, end, [&](std::size_t i, std::size_t j) {
            const auto order = compare(face(i), face(j));
            return std::is_neq(order) ? std::is_lt(order) : i < j;
        });
        begin = end;
    }
}

std::optional<std::size_t> SortedFaces::first_missing_in(const SortedFaces& other) const {
    std::size_t first = order_.size();
    auto theirs = other.order_.begin();
    for (const std::size_t mine : order_) {
        auto order = std::strong_ordering::greater;  // of theirs, against mine
        for (; theirs != other.order_.end(); ++theirs) {
            order = compare(other.face(*theirs), face(mine));
            if (std::is_gteq(order)) break;
        }
        if (std::is_eq(order)) {
            ++theirs;
        } else {
            first = std::min(first, mine);
        }
    }
    if (first == order_.size()) return std::nullopt;
    return first;
}

}  // namespace mscomp
