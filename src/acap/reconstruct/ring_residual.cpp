// SPDX-License-Identifier: MIT
#include "ring_residual.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "mscomp/base/index.h"

namespace mscomp {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d cross_matrix(const Vector3d& v) {
    Matrix3d matrix;
    matrix << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
    return matrix;
}

Vector3d edge(const std::vector<Point>& points, std::size_t from, std::size_t to) {
    return as_vector(points[to]) - as_vector(points[from]);
}

/// The pseudo-edge of vertex 0 of a ring and its derivatives by the positions of the members.
struct PseudoEdge {
    Vector3d value;
    std::vector<Matrix3d> derivatives;  // (degree + 1)
};

PseudoEdge pseudo_edge(const RingShape& ring, const std::vector<Point>& points,
                       bool with_derivatives) {
    const RingNormals normals = ring_normals(points, ring.faces, ring.around, ring.rings);
    Vector3d normal = normals.normal[0];
    double sign = 1;
    if (normals.folded[0] != 0 || ring.reference_folded) {
        Matrix3d moment = Matrix3d::Zero();
        for (std::size_t j = 1; j < points.size(); ++j) {
            moment += edge(points, 0, j) * ring.moments[j - 1].transpose();
        }
        if (!keeps_orientation(moment, ring.reference_normal, normal)) sign = -1;
    }
    normal *= sign;
    PseudoEdge result{normals.height[0] * normal, {}};
    if (!with_derivatives) return result;

    std::vector<Matrix3d>& by = result.derivatives;
    by.assign(points.size(), Matrix3d::Zero());
    for (std::size_t j = 1; j < points.size(); ++j) {
        const Vector3d ray = edge(points, 0, j);
        const double length = ray.norm();
        if (!(length > 0)) continue;
        const double share = kHeightFactor / static_cast<double>(points.size() - 1) / length;
        const Matrix3d by_edge = normal * (share * ray).transpose();
        by[j] += by_edge;
        by[0] -= by_edge;
    }
    if (normals.folded[0] != 0) return result;
    const Matrix3d across = (sign * normals.height[0] / normals.sum_length[0]) *
                            (Matrix3d::Identity() - normal * normal.transpose());
    for (const Face& face : ring.faces) {
        const auto unit = face_normal(points, face);
        if (!unit) continue;
        const auto a = at(face[0]), b = at(face[1]), c = at(face[2]);
        const Vector3d ab = edge(points, a, b), ac = edge(points, a, c);
        const Matrix3d by_cross =
            across * (Matrix3d::Identity() - *unit * unit->transpose()) / ab.cross(ac).norm();
        const Matrix3d by_ab = -by_cross * cross_matrix(ac), by_ac = by_cross * cross_matrix(ab);
        by[b] += by_ab;
        by[c] += by_ac;
        by[a] -= by_ab + by_ac;
    }
    return result;
}

}  // namespace

std::vector<RingShape> ring_shapes(const FeatureEquations& equations) {
    const DeformationGradients& gradients = equations.gradients();
    const TriangleMesh& reference = gradients.reference();
    const OneRings& rings = gradients.rings();
    std::vector<RingShape> shapes(reference.vertices.size());
    for (std::size_t i = 0; i < shapes.size(); ++i) {
        if (!gradients.has_gradient(static_cast<int>(i))) continue;
        RingShape& ring = shapes[i];
        const int degree = rings.degree(static_cast<int>(i));
        ring.members.push_back(static_cast<int>(i));
        ring.rings.offsets.assign(at(degree) + 2, degree);
        ring.rings.offsets.front() = 0;
        for (int place = rings.offsets[i]; place < rings.offsets[i + 1]; ++place) {
            const auto k = at(place);
            const int j = rings.neighbors[k];
            ring.rings.neighbors.push_back(static_cast<int>(ring.members.size()));
            ring.members.push_back(j);
            ring.edge_factors.push_back(equations.edge_factors()[k]);
            ring.moments.push_back(gradients.weights()[k] * edge(reference.vertices, i, at(j)));
        }
        ring.normal_factor = equations.normal_factors()[i];
        ring.reference_normal = gradients.reference_pseudo_edges().normal[i];
        ring.reference_folded = gradients.reference_pseudo_edges().folded[i] != 0;
    }
    for (const Face& face : reference.faces) {
        for (const int corner : face) {
            RingShape& ring = shapes[at(corner)];
            if (ring.members.empty()) continue;
            Face local{};
            for (std::size_t k = 0; k < 3; ++k) {
                local[k] = static_cast<int>(std::ranges::find(ring.members, face[k]) -
                                            ring.members.begin());
            }
            ring.around.faces.push_back(static_cast<int>(ring.faces.size()));
            ring.faces.push_back(local);
        }
    }
    for (RingShape& ring : shapes) {
        ring.around.offsets.assign(ring.members.size() + 1, static_cast<int>(ring.faces.size()));
        ring.around.offsets.front() = 0;
    }
    return shapes;
}

RingResidual::RingResidual(const RingShape& ring, const Matrix3d& wanted)
    : ring_(ring), wanted_(wanted) {
    set_num_residuals(9);
    mutable_parameter_block_sizes()->assign(ring.members.size(), 3);
}

bool RingResidual::Evaluate(double const* const* positions, double* residuals,
                            double** jacobians) const {
    std::vector<Point> points(ring_.members.size());
    for (std::size_t k = 0; k < points.size(); ++k) std::copy_n(positions[k], 3, points[k].data());
    const PseudoEdge pseudo = pseudo_edge(ring_, points, jacobians != nullptr);
    using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    Eigen::Map<RowMajor> residual(residuals);
    residual = pseudo.value * ring_.normal_factor.transpose() - wanted_;
    Vector3d center_factor = Vector3d::Zero();
    for (std::size_t j = 1; j < points.size(); ++j) {
        residual += edge(points, 0, j) * ring_.edge_factors[j - 1].transpose();
        center_factor -= ring_.edge_factors[j - 1];
    }
    if (jacobians == nullptr) return true;
    for (std::size_t k = 0; k < points.size(); ++k) {
        if (jacobians[k] == nullptr) continue;
        const Vector3d& factor = k == 0 ? center_factor : ring_.edge_factors[k - 1];
        Eigen::Map<Eigen::Matrix<double, 9, 3, Eigen::RowMajor>> jacobian(jacobians[k]);
        for (int row = 0; row < 3; ++row) {
            for (int column = 0; column < 3; ++column) {
                jacobian.row(3 * row + column) =
                    ring_.normal_factor[column] * pseudo.derivatives[k].row(row);
                jacobian(3 * row + column, row) += factor[column];
            }
        }
    }
    return true;
}

}  // namespace mscomp
