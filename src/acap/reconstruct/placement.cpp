// SPDX-License-Identifier: MIT
#include "placement.h"

#include <fmt/format.h>

#include <utility>

#include "acap/edge_weights.h"
#include "mscomp/acap/alignment.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/points.h"

namespace mscomp {
Placement::Placement(const OneRings& rings, std::vector<Point> reference)
    : component_(connected_components(rings)) {
    for (std::size_t i = 0; i < component_.size(); ++i) {
        if (component_[i] != component_count_) continue;
        ++component_count_;
        first_vertices_.push_back(static_cast<int>(i));
    }
    reference_ = std::move(reference);
    reference_centroids_ = centroids(reference_);
    joints_ = piece_joints(reference_, component_);
}

std::vector<Eigen::Vector3d> Placement::shifts(
    const std::function<Eigen::Vector3d(int)>& position,
    const std::function<Eigen::Matrix3d(int)>& gradient) const {
    std::vector<Eigen::Vector3d> shifts(at(component_count_), Eigen::Vector3d::Zero());
    for (const PieceJoint& joint : joints_) {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (const PieceLink& link : joint.links) {
            const Eigen::Matrix3d mean = 0.5 * (gradient(link.from) + gradient(link.to));
            sum += position(link.from) + mean * edge(link) - position(link.to);
        }
        shifts[at(joint.to)] =
            shifts[at(joint.from)] + sum / static_cast<double>(joint.links.size());
    }
    return shifts;
}

void Placement::take_back_shifts(
    std::vector<Eigen::Vector3d>& by_shift,
    const std::function<void(int, const Eigen::Vector3d&)>& add_to_position,
    const std::function<void(int, const Eigen::Matrix3d&)>& add_to_gradient) const {
    for (auto next = joints_.rbegin(); next != joints_.rend(); ++next) {
        const PieceJoint& joint = *next;
        by_shift[at(joint.from)] += by_shift[at(joint.to)];
        const Eigen::Vector3d share =
            by_shift[at(joint.to)] / static_cast<double>(joint.links.size());
        for (const PieceLink& link : joint.links) {
            const Eigen::Matrix3d by_gradient = 0.5 * share * edge(link).transpose();
            add_to_position(link.from, share);
            add_to_position(link.to, -share);
            add_to_gradient(link.from, by_gradient);
            add_to_gradient(link.to, by_gradient);
        }
    }
}

Eigen::Vector3d Placement::edge(const PieceLink& link) const {
    return as_vector(reference_[at(link.to)]) - as_vector(reference_[at(link.from)]);
}

void Placement::check_size(std::span<const Point> like) const {
    if (like.empty() || like.size() == component_.size()) return;
    throw MeshError(fmt::format("placement like a shape of {} vertices, wanted {}", like.size(),
                                component_.size()));
}

std::vector<Point> Placement::centroids(std::span<const Point> positions) const {
    const auto count = at(component_count_);
    std::vector<Point> sums(count, Point{});
    std::vector<int> sizes(count, 0);
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const auto c = at(component_[i]);
        ++sizes[c];
        for (std::size_t axis = 0; axis < 3; ++axis) sums[c][axis] += positions[i][axis];
    }
    for (std::size_t c = 0; c < count; ++c) {
        for (double& x : sums[c]) x /= sizes[c];
    }
    return sums;
}

void Placement::apply(std::span<const Point> like, std::vector<Point>& positions,
                      const std::vector<char>& left_alone) const {
    check_size(like);
    const std::vector<Point> wanted = like.empty() ? reference_centroids_ : centroids(like);
    const std::vector<Point> found = centroids(positions);
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const auto c = at(component_[i]);
        if (!left_alone.empty() && left_alone[c] != 0) continue;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            positions[i][axis] += wanted[c][axis] - found[c][axis];
        }
    }
}

void Placement::join(const std::vector<Eigen::Matrix3d>& gradients, std::span<const Point> like,
                     std::vector<Point>& positions) const {
    check_size(like);
    if (positions.empty()) return;
    if (has_joints()) {
        const std::vector<Eigen::Vector3d> moves =
            shifts([&](int v) -> Eigen::Vector3d { return as_vector(positions[at(v)]); },
                   [&](int v) { return gradients[at(v)]; });
        for (std::size_t i = 0; i < positions.size(); ++i) {
            Eigen::Map<Eigen::Vector3d>(positions[i].data()) += moves[at(component_[i])];
        }
    }
    const Point wanted = mean_point(like.empty() ? std::span<const Point>(reference_) : like);
    const Point move = minus(wanted, mean_point(positions));
    for (Point& position : positions) {
        for (std::size_t axis = 0; axis < 3; ++axis) position[axis] += move[axis];
    }
}

}  // namespace mscomp
