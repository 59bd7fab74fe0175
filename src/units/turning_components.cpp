// SPDX-License-Identifier: MIT
#include "units/turning_components.h"

#include <Eigen/QR>
#include <algorithm>
#include <utility>

#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "units/unit_components.h"

namespace mscomp {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;

// Turns add up along a limb: less may be left out.
constexpr double kLeastTurn = 0.02;

}  // namespace

void TurningShapes::add(int m, std::span<const float> features) {
    turns_.set(m, field_.turns_of(features));
    for (std::size_t v = 0; v < squares_.size(); ++v) {
        for (std::size_t x = 0; x < kRotationDim; ++x) {
            const auto r = static_cast<double>(features[v * kFeatureDim + x]);
            squares_[v] += r * r;
        }
    }
}

void TurningShapes::place_roots(const TriangleMesh& mesh) {
    std::vector<int> roots;
    for (const std::vector<int>& piece : field_.pieces()) {
        roots.push_back(*std::ranges::min_element(piece, [&](int a, int b) {
            return squares_[at(a)] < squares_[at(b)] || (squares_[at(a)] == squares_[at(b)] && a < b);
        }));
    }
    field_ = TurnField(mesh, std::move(roots));
}

void TurningShapes::add_roots(int m, std::span<const float> features) {
    for (std::size_t p = 0; p < field_.roots().size(); ++p) {
        for (std::size_t x = 0; x < kRotationDim; ++x) {
            roots_(m, static_cast<Index>(kRotationDim * p + x)) =
                static_cast<double>(features[at(field_.roots()[p]) * kFeatureDim + x]);
        }
    }
}

std::vector<Point> TurningShapes::middles(const TriangleMesh& mesh, const TurnField& field) {
    std::vector<Point> middles;
    for (const auto& [i, j] : field.edges()) {
        const Point &p = mesh.vertices[at(i)], &q = mesh.vertices[at(j)];
        middles.push_back({(p[0] + q[0]) / 2, (p[1] + q[1]) / 2, (p[2] + q[2]) / 2});
    }
    return middles;
}

TurningComponents::TurningComponents(TurnField field, BallComponents turns, MatrixXd roots)
    : field_(std::move(field)),
      turns_(std::move(turns)),
      roots_(std::move(roots)),
      joint_codes_(turns_) {}

Eigen::VectorXd TurningComponents::codes_of(std::span<const float> features) const {
    return joint_codes_.solve(products(turns_, field_.turns_of(features)));
}

/// Σ_k z_k of what components do.
TurnField::Direction TurningComponents::weighted(std::span<const float> codes) const {
    TurnField::Direction sum;
    sum.turns.assign(at(field_.edge_count()), Vector3d::Zero());
    for (int e = 0; e < field_.edge_count(); ++e) {
        const std::span<const int> acting = turns_.at_vertex(e);
        const std::span<const float> values = turns_.values(e);
        for (std::size_t a = 0; a < acting.size(); ++a) {
            sum.turns[at(e)] += static_cast<double>(codes[at(acting[a])]) *
                                Eigen::Map<const Eigen::Vector3f>(values.data() + 3 * a)
                                    .cast<double>();
        }
    }
    for (Index p = 0; p < roots_.cols() / 3; ++p) {
        Vector3d root = Vector3d::Zero();
        for (Index k = 0; k < roots_.rows(); ++k) {
            root += static_cast<double>(codes[at(k)]) * roots_.row(k).segment<3>(3 * p).transpose();
        }
        sum.roots.push_back(root);
    }
    return sum;
}

std::vector<Vector3d> TurningComponents::rotations(std::span<const float> codes) const {
    const TurnField::Direction turned = weighted(codes);
    return field_.integrated(turned.turns, turned.roots);
}

std::vector<std::vector<Vector3d>> TurningComponents::derivatives(
    std::span<const float> codes) const {
    const TurnField::Direction turned = weighted(codes);
    std::vector<TurnField::Direction> directions;
    for (int k = 0; k < turns_.count(); ++k) {
        std::vector<float> one(codes.size(), 0.0F);
        one[at(k)] = 1;
        directions.push_back(weighted(one));
    }
    return field_.derivatives(turned.turns, turned.roots, directions);
}

std::vector<int> TurningComponents::vertices_of(int k) const {
    std::vector<int> vertices;
    for (const int e : turns_.balls()[at(k)].vertices) {
        const auto [i, j] = field_.edges()[at(e)];
        vertices.push_back(i);
        vertices.push_back(j);
    }
    std::ranges::sort(vertices);
    const auto same = std::ranges::unique(vertices);
    vertices.erase(same.begin(), same.end());
    return vertices;
}

int TurningComponents::most_turning(int k) const {
    const std::vector<float> values = turns_.component(k);
    const std::vector<int>& edges = turns_.balls()[at(k)].vertices;
    float most = 0;
    int vertex = 0;
    for (std::size_t n = 0; n < edges.size(); ++n) {
        const float square =
            Eigen::Map<const Eigen::Vector3f>(values.data() + 3 * n).squaredNorm();
        if (!(square > most)) continue;
        most = square;
        vertex = field_.edges()[at(edges[n])][0];
    }
    return vertex;
}

TurningComponents turning_components(const TurningShapes& shapes, const MatrixXd& codes,
                                     const TriangleMesh& mesh) {
    const BallComponents first = unit_components(shapes.turns(), codes, kLeastTurn);
    const MatrixXd fitted = JointCodes(first).solve(products(first, shapes.turns())).transpose();
    BallComponents turns = unit_components(shapes.turns(), fitted, kLeastTurn);
    const MatrixXd last = JointCodes(turns).solve(products(turns, shapes.turns())).transpose();
    MatrixXd roots = last.completeOrthogonalDecomposition().solve(shapes.roots());
    return {TurnField(mesh, shapes.field().roots()), std::move(turns), std::move(roots)};
}

}  // namespace mscomp
