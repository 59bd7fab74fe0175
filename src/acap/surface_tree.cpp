// SPDX-License-Identifier: MIT
#include "surface_tree.h"

#include <algorithm>
#include <array>
#include <tuple>

#include "edge_weights.h"

namespace mscomp {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kLeaf = 4;
/// Faces are halved at every level, so that more of them than memory can hold need no more.
constexpr std::size_t kDeepest = 64;

/// Weights of the point of segment ab that is nearest to p, for a and b.
std::array<double, 2> nearest_on_edge(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
    const Vector3d ab = b - a;
    const double t = std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
    return {1 - t, t};
}

/// Weights of the point of a triangle that is nearest to p (Ericson, Real-Time Collision Detection,
/// 5.1.5).
Vector3d nearest_weights(const Vector3d& p, const Vector3d& a, const Vector3d& b,
                         const Vector3d& c) {
    const Vector3d ab = b - a, ac = c - a;
    const double a_ab = ab.dot(p - a), a_ac = ac.dot(p - a);
    if (a_ab <= 0 && a_ac <= 0) return {1, 0, 0};
    const double b_ab = ab.dot(p - b), b_ac = ac.dot(p - b);
    if (b_ab >= 0 && b_ac <= b_ab) return {0, 1, 0};
    const double c_ab = ab.dot(p - c), c_ac = ac.dot(p - c);
    if (c_ac >= 0 && c_ab <= c_ac) return {0, 0, 1};
    const double of_c = a_ab * b_ac - b_ab * a_ac;
    if (of_c <= 0 && a_ab >= 0 && b_ab <= 0) {
        const auto [first, second] = nearest_on_edge(p, a, b);
        return {first, second, 0};
    }
    const double of_b = c_ab * a_ac - a_ab * c_ac;
    if (of_b <= 0 && a_ac >= 0 && c_ac <= 0) {
        const auto [first, second] = nearest_on_edge(p, a, c);
        return {first, 0, second};
    }
    const double of_a = b_ab * c_ac - c_ab * b_ac;
    if (of_a <= 0 && b_ac >= b_ab && c_ab >= c_ac) {
        const auto [first, second] = nearest_on_edge(p, b, c);
        return {0, first, second};
    }
    return Vector3d(of_a, of_b, of_c).cwiseMax(0) / (of_a + of_b + of_c);
}

}  // namespace

SurfaceTree::SurfaceTree(const TriangleMesh& mesh) : slots_(mesh.faces.size(), 0) {
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        const Face& face = mesh.faces[f];
        if (is_degenerate(face) || !face_normal(mesh.vertices, face)) continue;
        faces_.push_back({as_vector(mesh.vertices[at(face[0])]),
                          as_vector(mesh.vertices[at(face[1])]),
                          as_vector(mesh.vertices[at(face[2])]), static_cast<int>(f)});
    }
    if (faces_.empty()) return;
    nodes_.reserve(faces_.size());
    build(0, faces_.size());
    for (std::size_t i = 0; i < faces_.size(); ++i) {
        slots_[at(faces_[i].face)] = i;
        normals_.push_back(*face_normal(mesh.vertices, mesh.faces[at(faces_[i].face)]));
    }
}

std::size_t SurfaceTree::slot(const SurfacePoint& point) const { return slots_[at(point.face)]; }

int SurfaceTree::build(std::size_t first, std::size_t end) {
    Node node;
    node.low = faces_[first].a;
    node.high = node.low;
    for (std::size_t i = first; i < end; ++i) {
        const auto& [a, b, c, face] = faces_[i];
        node.low = node.low.cwiseMin(a).cwiseMin(b).cwiseMin(c);
        node.high = node.high.cwiseMax(a).cwiseMax(b).cwiseMax(c);
    }
    const auto here = static_cast<int>(nodes_.size());
    nodes_.push_back(node);
    if (end - first <= kLeaf) {
        nodes_.back().first = static_cast<int>(first);
        nodes_.back().count = static_cast<int>(end - first);
        return here;
    }
    Eigen::Index axis = 0;
    (node.high - node.low).maxCoeff(&axis);
    const auto key = [axis](const Corners& corners) {
        return std::tuple(corners.a[axis] + corners.b[axis] + corners.c[axis], corners.face);
    };
    const std::size_t middle = first + (end - first) / 2;
    const auto place = [this](std::size_t i) {
        return faces_.begin() + static_cast<std::ptrdiff_t>(i);
    };
    std::nth_element(place(first), place(middle), place(end),
                     [&](const Corners& p, const Corners& q) { return key(p) < key(q); });
    build(first, middle);
    const int right = build(middle, end);
    nodes_[at(here)].right = right;
    return here;
}

double SurfaceTree::Node::square_distance(const Vector3d& point) const {
    return (low - point).cwiseMax(point - high).cwiseMax(0).squaredNorm();
}

template <class IsWanted>
SurfacePoint SurfaceTree::search(const Vector3d& point, double within, IsWanted&& is_wanted) const {
    struct Visit {
        int node;
        double square;
    };
    SurfacePoint best;
    best.square = within * within;
    std::array<Visit, kDeepest> waiting;
    std::size_t count = 0;
    if (!is_empty()) waiting[count++] = {0, nodes_[0].square_distance(point)};
    while (count > 0) {
        const auto [index, square] = waiting[--count];
        if (square >= best.square) continue;
        const Node& node = nodes_[at(index)];
        for (std::size_t i = at(node.first); i < at(node.first + node.count); ++i) {
            if (!is_wanted(i)) continue;
            const auto& [a, b, c, face] = faces_[i];
            const Vector3d weights = nearest_weights(point, a, b, c);
            const Vector3d position = weights[0] * a + weights[1] * b + weights[2] * c;
            const double distance = (position - point).squaredNorm();
            if (distance < best.square) best = {face, weights, position, distance};
        }
        if (node.count > 0) continue;
        Visit near{index + 1, nodes_[at(index + 1)].square_distance(point)};
        Visit far{node.right, nodes_[at(node.right)].square_distance(point)};
        if (far.square < near.square) std::swap(near, far);
        waiting[count++] = far;
        waiting[count++] = near;
    }
    return best;
}

SurfacePoint SurfaceTree::nearest(const Vector3d& point) const {
    return search(point, std::numeric_limits<double>::infinity(), [](std::size_t) { return true; });
}

SurfacePoint SurfaceTree::nearest_facing(const Vector3d& point, const Vector3d& direction,
                                         double within) const {
    return search(point, within, [&](std::size_t i) { return normals_[i].dot(direction) > 0; });
}

}  // namespace mscomp
