// SPDX-License-Identifier: MIT
#include "deformation_gradient.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

// Smallest to largest eigenvalue of M below which a ring spans less than space.
constexpr double kDegenerate = 1e-13;

Eigen::Matrix3d cofactor(const Eigen::Matrix3d& m) {
    Eigen::Matrix3d result;
    result.col(0) = m.col(1).cross(m.col(2));
    result.col(1) = m.col(2).cross(m.col(0));
    result.col(2) = m.col(0).cross(m.col(1));
    return result;
}

}  // namespace

bool keeps_orientation(const Eigen::Matrix3d& edge_moment, const Eigen::Vector3d& normal,
                       const Eigen::Vector3d& image) {
    return image.dot(cofactor(edge_moment) * normal) >= 0;
}

DeformationGradients::DeformationGradients(const TriangleMesh& reference, EdgeWeights weights)
    : reference_(reference),
      mesh_(reference),
      normals_(ring_normals(reference.vertices, reference.faces, mesh_.faces_around(), rings())) {
    EdgeWeightTable table = edge_weights(reference, rings(), weights);
    weights_ = std::move(table.weights);
    zero_area_faces_ = table.zero_area_faces;
    if (zero_area_faces_.count == reference.face_count()) {
        throw MeshError("the reference has no face with an area: features need a surface");
    }
    invert_moments();
    prepare_duals();
}

void DeformationGradients::invert_moments() {
    const std::size_t count = reference_.vertices.size();
    inverse_moments_.assign(count, Eigen::Matrix3d::Zero());
    usable_.assign(count, 0);
    for (std::size_t i = 0; i < count; ++i) {
        if (rings().degree(static_cast<int>(i)) == 0) {
            isolated_.add(static_cast<int>(i));
            continue;
        }
        const Eigen::Vector3d pseudo_edge = normals_.height[i] * normals_.normal[i];
        Eigen::Matrix3d moment = pseudo_edge * pseudo_edge.transpose();
        for (int place = rings().offsets[i]; place < rings().offsets[i + 1]; ++place) {
            const auto k = at(place);
            const Eigen::Vector3d edge = as_vector(reference_.vertices[at(rings().neighbors[k])]) -
                                         as_vector(reference_.vertices[i]);
            moment += weights_[k] * edge * edge.transpose();
        }
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(moment);
        const Eigen::Vector3d& values = eigen.eigenvalues();
        if (!(values[0] > kDegenerate * values[2])) {
            degenerate_.add(static_cast<int>(i));
            continue;
        }
        usable_[i] = 1;
        inverse_moments_[i] = eigen.eigenvectors() * values.cwiseInverse().asDiagonal() *
                              eigen.eigenvectors().transpose();
    }
}

Eigen::Matrix3d DeformationGradients::edge_moment(std::size_t vertex,
                                                  const std::vector<Point>& shape) const {
    Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
    for (int place = rings().offsets[vertex]; place < rings().offsets[vertex + 1]; ++place) {
        const auto k = at(place);
        const auto j = at(rings().neighbors[k]);
        const Eigen::Vector3d before =
            as_vector(reference_.vertices[j]) - as_vector(reference_.vertices[vertex]);
        const Eigen::Vector3d after = as_vector(shape[j]) - as_vector(shape[vertex]);
        moment += (weights_[k] * after) * before.transpose();
    }
    return moment;
}

void DeformationGradients::prepare_duals() {
    edge_duals_.assign(rings().neighbors.size(), Eigen::Vector3d::Zero());
    normal_duals_.assign(inverse_moments_.size(), Eigen::Vector3d::Zero());
    for (std::size_t i = 0; i < inverse_moments_.size(); ++i) {
        normal_duals_[i] = inverse_moments_[i] * (normals_.height[i] * normals_.normal[i]);
        for (int place = rings().offsets[i]; place < rings().offsets[i + 1]; ++place) {
            const auto k = at(place);
            const Eigen::Vector3d edge = as_vector(reference_.vertices[at(rings().neighbors[k])]) -
                                         as_vector(reference_.vertices[i]);
            edge_duals_[k] = inverse_moments_[i] * (weights_[k] * edge);
        }
    }
}

void DeformationGradients::choose_signs(const std::vector<Point>& shape,
                                        RingNormals& normals) const {
    for (std::size_t i = 0; i < shape.size(); ++i) {
        if (normals_.folded[i] == 0 && normals.folded[i] == 0) continue;
        if (!keeps_orientation(edge_moment(i, shape), normals_.normal[i], normals.normal[i])) {
            normals.normal[i] = -normals.normal[i];
        }
    }
}

RingNormals DeformationGradients::pseudo_edges(const std::vector<Point>& shape) const {
    RingNormals normals = ring_normals(shape, reference_.faces, mesh_.faces_around(), rings());
    choose_signs(shape, normals);
    return normals;
}

RingNormals DeformationGradients::directions(const std::vector<Point>& shape) const {
    RingNormals normals = ring_directions(shape, reference_.faces, mesh_.faces_around(), rings());
    choose_signs(shape, normals);
    return normals;
}

Eigen::Matrix3d DeformationGradients::ring_gradient(std::size_t vertex,
                                                    const std::vector<Point>& shape,
                                                    const RingNormals& directions) const {
    const Eigen::Vector3d center = as_vector(shape[vertex]);
    // Columns apart: the compiler then keeps them in registers.
    Eigen::Vector3d first = Eigen::Vector3d::Zero(), second = first, third = first;
    double length = 0;
    for (int place = rings().offsets[vertex]; place < rings().offsets[vertex + 1]; ++place) {
        const auto k = at(place);
        const Eigen::Vector3d edge = as_vector(shape[at(rings().neighbors[k])]) - center;
        const Eigen::Vector3d& dual = edge_duals_[k];
        length += edge.norm();
        first += dual.x() * edge;
        second += dual.y() * edge;
        third += dual.z() * edge;
    }
    const double height = kHeightFactor * length / rings().degree(static_cast<int>(vertex));
    const Eigen::Vector3d image = height * directions.normal[vertex];
    const Eigen::Vector3d& dual = normal_duals_[vertex];
    Eigen::Matrix3d gradient;
    gradient.col(0) = first + dual.x() * image;
    gradient.col(1) = second + dual.y() * image;
    gradient.col(2) = third + dual.z() * image;
    return gradient;
}

Eigen::Matrix3d DeformationGradients::mean_of_neighbors(std::size_t vertex,
                                                        const std::vector<Point>& shape,
                                                        const RingNormals& directions) const {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    int count = 0;
    for (int place = rings().offsets[vertex]; place < rings().offsets[vertex + 1]; ++place) {
        const auto j = at(rings().neighbors[at(place)]);
        if (usable_[j] == 0) continue;
        sum += ring_gradient(j, shape, directions);
        ++count;
    }
    return count > 0 ? Eigen::Matrix3d(sum / count) : Eigen::Matrix3d::Identity();
}

void DeformationGradients::compute(const std::vector<Point>& shape, const RingNormals& directions,
                                   std::size_t first, std::span<Eigen::Matrix3d> gradients) const {
    for (std::size_t n = 0; n < gradients.size(); ++n) {
        const std::size_t i = first + n;
        gradients[n] = usable_[i] != 0 ? ring_gradient(i, shape, directions)
                                       : mean_of_neighbors(i, shape, directions);
    }
}

DeformationGradients::Result DeformationGradients::compute(const std::vector<Point>& shape) const {
    const RingNormals normals = directions(shape);
    Result result{std::vector<Eigen::Matrix3d>(shape.size()), normals.zero_area_faces,
                  normals.folded_rings};
    compute(shape, normals, 0, result.gradients);
    return result;
}

}  // namespace mscomp
