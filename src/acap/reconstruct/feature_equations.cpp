// SPDX-License-Identifier: MIT
#include "feature_equations.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "mscomp/base/index.h"

namespace mscomp {
namespace {

Eigen::Map<Eigen::Vector3d> writable(Point& point) {
    return Eigen::Map<Eigen::Vector3d>(point.data());
}

}  // namespace

double squared_size(const std::vector<Eigen::Matrix3d>& wanted) {
    double sum = 0;
    for (const Eigen::Matrix3d& entry : wanted) sum += entry.squaredNorm();
    return sum;
}

FeatureEquations::FeatureEquations(const TriangleMesh& reference, EdgeWeights weights)
    : gradients_(reference, weights) {
    const OneRings& rings = gradients_.rings();
    const std::size_t count = reference.vertices.size();
    edge_factors_.assign(rings.neighbors.size(), Eigen::Vector3d::Zero());
    normal_factors_.assign(count, Eigen::Vector3d::Zero());
    root_moments_.assign(count, Eigen::Matrix3d::Zero());
    tangential_.assign(count, Eigen::Matrix3d::Identity());
    const RingNormals& normals = gradients_.reference_pseudo_edges();
    for (std::size_t i = 0; i < count; ++i) {
        if (!gradients_.has_gradient(static_cast<int>(i))) continue;
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> inverse(
            gradients_.inverse_moments()[i]);
        const Eigen::Matrix3d inverse_root = inverse.operatorSqrt();
        root_moments_[i] = inverse.operatorInverseSqrt();
        normal_factors_[i] = normals.height[i] * (inverse_root * normals.normal[i]);
        const Eigen::Vector3d along = normal_factors_[i].normalized();
        tangential_[i] -= along * along.transpose();
        for (int place = rings.offsets[i]; place < rings.offsets[i + 1]; ++place) {
            const auto k = at(place);
            const auto j = at(rings.neighbors[k]);
            const Eigen::Vector3d edge =
                mscomp::as_vector(reference.vertices[j]) - mscomp::as_vector(reference.vertices[i]);
            edge_factors_[k] = gradients_.weights()[k] * (inverse_root * edge);
        }
    }
}

std::vector<Eigen::Matrix3d> FeatureEquations::wanted(
    const std::vector<Eigen::Matrix3d>& gradients) const {
    std::vector<Eigen::Matrix3d> result(gradients.size());
    for (std::size_t i = 0; i < result.size(); ++i) result[i] = gradients[i] * root_moments_[i];
    return result;
}

Eigen::Matrix3d FeatureEquations::residual(std::size_t vertex, const std::vector<Point>& shape,
                                           const RingNormals& normals,
                                           const std::vector<Eigen::Matrix3d>& wanted) const {
    const OneRings& rings = gradients_.rings();
    Eigen::Matrix3d result =
        (normals.height[vertex] * normals.normal[vertex]) * normal_factors_[vertex].transpose() -
        wanted[vertex];
    const auto center = mscomp::as_vector(shape[vertex]);
    for (int place = rings.offsets[vertex]; place < rings.offsets[vertex + 1]; ++place) {
        const auto k = at(place);
        const auto j = at(rings.neighbors[k]);
        result += (mscomp::as_vector(shape[j]) - center) * edge_factors_[k].transpose();
    }
    return result;
}

double FeatureEquations::energy(const std::vector<Point>& shape,
                                const std::vector<Eigen::Matrix3d>& wanted,
                                std::vector<Point>& derivative) const {
    const OneRings& rings = gradients_.rings();
    const RingNormals normals = gradients_.pseudo_edges(shape);
    derivative.assign(shape.size(), Point{});
    std::vector<Eigen::Vector3d> by_pseudo_edge(shape.size());
    double sum = 0;
    for (std::size_t i = 0; i < shape.size(); ++i) {
        const Eigen::Matrix3d value = residual(i, shape, normals, wanted);
        sum += value.squaredNorm();
        const Eigen::Matrix3d by_residual = 2 * value;
        by_pseudo_edge[i] = by_residual * normal_factors_[i];
        for (int place = rings.offsets[i]; place < rings.offsets[i + 1]; ++place) {
            const auto k = at(place);
            const Eigen::Vector3d by_edge = by_residual * edge_factors_[k];
            writable(derivative[at(rings.neighbors[k])]) += by_edge;
            writable(derivative[i]) -= by_edge;
        }
    }
    add_pseudo_edge_derivative(shape, normals, by_pseudo_edge, derivative);
    return sum;
}

/// Takes dE/d(h' n') through h' = 0.3 x mean |e'| and n' = Σ u_f / |Σ u_f| to the positions.
void FeatureEquations::add_pseudo_edge_derivative(
    const std::vector<Point>& shape, const RingNormals& normals,
    const std::vector<Eigen::Vector3d>& by_pseudo_edge, std::vector<Point>& derivative) const {
    const OneRings& rings = gradients_.rings();
    std::vector<Eigen::Vector3d> by_normal_sum(shape.size(), Eigen::Vector3d::Zero());
    for (std::size_t i = 0; i < shape.size(); ++i) {
        const Eigen::Vector3d& normal = normals.normal[i];
        const double by_height = by_pseudo_edge[i].dot(normal);
        const int degree = rings.degree(static_cast<int>(i));
        for (int place = rings.offsets[i]; place < rings.offsets[i + 1]; ++place) {
            const auto j = at(rings.neighbors[at(place)]);
            const Eigen::Vector3d edge = mscomp::as_vector(shape[j]) - mscomp::as_vector(shape[i]);
            const double length = edge.norm();
            if (!(length > 0)) continue;
            const Eigen::Vector3d by_edge = (by_height * kHeightFactor / degree / length) * edge;
            writable(derivative[j]) += by_edge;
            writable(derivative[i]) -= by_edge;
        }
        if (normals.folded[i] != 0 || degree == 0) continue;
        by_normal_sum[i] =
            (normals.height[i] / normals.sum_length[i]) * (by_pseudo_edge[i] - by_height * normal);
    }
    for (const Face& face : gradients_.reference().faces) {
        const auto a = at(face[0]), b = at(face[1]), c = at(face[2]);
        const auto normal = face_normal(shape, face);
        if (!normal) continue;
        const Eigen::Vector3d ab = mscomp::as_vector(shape[b]) - mscomp::as_vector(shape[a]);
        const Eigen::Vector3d ac = mscomp::as_vector(shape[c]) - mscomp::as_vector(shape[a]);
        const Eigen::Vector3d by_normal = by_normal_sum[a] + by_normal_sum[b] + by_normal_sum[c];
        const Eigen::Vector3d by_cross =
            (by_normal - normal->dot(by_normal) * *normal) / ab.cross(ac).norm();
        const Eigen::Vector3d by_ab = ac.cross(by_cross), by_ac = by_cross.cross(ab);
        writable(derivative[b]) += by_ab;
        writable(derivative[c]) += by_ac;
        writable(derivative[a]) -= by_ab + by_ac;
    }
}

}  // namespace mscomp
