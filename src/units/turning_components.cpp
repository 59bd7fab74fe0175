// SPDX-License-Identifier: MIT
#include "units/turning_components.h"

#include <Eigen/QR>
#include <algorithm>
#include <iterator>
#include <utility>

#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"
#include "units/unit_components.h"

namespace mscomp {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;

// Turns add up along a limb: less may be left out.
constexpr double kLeastTurnPart = 0.02;
// Codes are fitted to where units turn most first: a strong unit beside a weak one is read there
// without it.
constexpr double kMostTurningPart = 0.2;
constexpr int kRounds = 3;

/// z and then z², of shapes (N,K) or of one.
MatrixXd with_squares(const MatrixXd& codes) {
    MatrixXd both(codes.rows(), 2 * codes.cols());
    both << codes, codes.cwiseAbs2();
    return both;
}

std::vector<float> with_squares(std::span<const float> codes) {
    std::vector<float> both(codes.begin(), codes.end());
    for (const float z : codes) both.push_back(z * z);
    return both;
}

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
            return squares_[at(a)] < squares_[at(b)] ||
                   (squares_[at(a)] == squares_[at(b)] && a < b);
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

TurningComponents::TurningComponents(TurnField field, BallComponents turns, MatrixXd roots,
                                     BallComponents stretches)
    : field_(std::move(field)),
      turns_(std::move(turns)),
      roots_(std::move(roots)),
      stretches_(std::move(stretches)),
      joint_codes_(turns_) {}

Eigen::VectorXd TurningComponents::codes_of(std::span<const float> features) const {
    return joint_codes_.solve(products(turns_, field_.turns_of(features)));
}

MatrixXd TurningComponents::codes_of(const MetricRows& turns) const {
    return joint_codes_.solve(products(turns_, turns)).transpose();
}

/// Σ_k z_k of what components do.
TurnField::Direction TurningComponents::weighted(std::span<const float> codes) const {
    TurnField::Direction sum;
    sum.turns.assign(at(field_.edge_count()), Vector3d::Zero());
    for (int e = 0; e < field_.edge_count(); ++e) {
        const std::span<const int> acting = turns_.at_vertex(e);
        const std::span<const float> values = turns_.values(e);
        for (std::size_t a = 0; a < acting.size(); ++a) {
            sum.turns[at(e)] +=
                static_cast<double>(codes[at(acting[a])]) *
                Eigen::Map<const Eigen::Vector3f>(values.data() + 3 * a).cast<double>();
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

std::vector<float> TurningComponents::stretched(std::span<const float> codes) const {
    return weighted_sum(stretches_, with_squares(codes));
}

std::vector<CodeColumn> TurningComponents::derivatives(std::span<const float> codes,
                                                       const RowMap& map) const {
    const TurnField::Direction turned = weighted(codes);
    std::vector<TurnField::Direction> directions;
    for (std::size_t k = 0; k < codes.size(); ++k) {
        std::vector<float> one(codes.size(), 0.0F);
        one[k] = 1;
        directions.push_back(weighted(one));
    }
    const auto spins = field_.derivatives(turned.turns, turned.roots, directions);
    std::vector<CodeColumn> columns(codes.size());
    parallel_for(std::ssize(columns), [&](std::int64_t k) {
        std::vector<float> factors(2 * codes.size(), 0.0F);
        factors[at(k)] = 1;
        factors[codes.size() + at(k)] = 2 * codes[at(k)];
        std::vector<float> row = weighted_sum(stretches_, factors);
        CodeColumn& column = columns[at(k)];
        for (int v = 0; v < field_.vertex_count(); ++v) {
            const auto values = std::span(row).subspan(at(v) * kFeatureDim, kFeatureDim);
            map.unmap_change(v, values);
            Eigen::Map<Eigen::Vector3f>(values.data()) = spins[at(k)][at(v)].cast<float>();
            if (std::ranges::all_of(values, [](float x) { return x == 0; })) continue;
            column.vertices.push_back(v);
            column.values.insert(column.values.end(), values.begin(), values.end());
        }
    });
    return columns;
}

std::vector<int> TurningComponents::vertices_of(int k) const {
    std::vector<int> vertices;
    for (const int e : turns_.balls()[at(k)].vertices) {
        const auto [i, j] = field_.edges()[at(e)];
        vertices.push_back(i);
        vertices.push_back(j);
    }
    std::ranges::sort(vertices);
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    return vertices;
}

int TurningComponents::most_turning(int k) const {
    const std::vector<float> values = turns_.component(k);
    const std::vector<int>& edges = turns_.balls()[at(k)].vertices;
    float most = 0;
    int vertex = -1;
    for (std::size_t n = 0; n < edges.size(); ++n) {
        const float square = Eigen::Map<const Eigen::Vector3f>(values.data() + 3 * n).squaredNorm();
        if (!(square > most)) continue;
        most = square;
        vertex = field_.edges()[at(edges[n])][0];
    }
    return vertex;
}

/// A unit is where it turns and stretches, and not where it carries what lies beyond.
std::vector<ComponentPlace> TurningComponents::places() const {
    std::vector<ComponentPlace> places;
    for (int k = 0; k < count(); ++k) {
        const Ball& stretch = stretches_.balls()[at(k)];
        std::vector<int> both;
        std::ranges::set_union(vertices_of(k), stretch.vertices, std::back_inserter(both));
        const int most = most_turning(k);
        const int center = most >= 0 ? most : stretch.center;
        places.push_back({center, center, static_cast<int>(both.size())});
    }
    return places;
}

namespace {

/// Part of the square of z² that z does not tell.
double told_by_square_alone(const Eigen::VectorXd& z) {
    const Eigen::VectorXd square = z.cwiseAbs2();
    const double all = z.squaredNorm() * square.squaredNorm();
    return all > 0 ? 1 - z.dot(square) * z.dot(square) / all : 0;
}

/// Where components stretch: A by its length, Q where the component turns. Where that would be more
/// than half as many as there are shapes, and for codes that hardly take more than two values, A
/// alone.
std::vector<Ball> stretch_balls(const MetricRows& stretches, const MatrixXd& codes,
                                const std::vector<std::vector<int>>& turned) {
    std::vector<Ball> balls = unit_components(stretches, codes, kLeastTurnPart).balls();
    const std::size_t count = balls.size();
    std::vector<int> acting(at(stretches.vertex_count()), 0);
    for (const Ball& ball : balls) {
        for (const int v : ball.vertices) ++acting[at(v)];
    }
    for (const std::vector<int>& vertices : turned) {
        for (const int v : vertices) ++acting[at(v)];
    }
    constexpr double kLeastTold = 0.02;
    for (std::size_t k = 0; k < count; ++k) {
        Ball ball{balls[k].center, {}};
        const bool has_square =
            told_by_square_alone(codes.col(static_cast<Index>(k))) >= kLeastTold;
        for (const int v : turned[k]) {
            if (!has_square) break;
            if (2 * acting[at(v)] <= stretches.shape_count()) ball.vertices.push_back(v);
        }
        balls.push_back(std::move(ball));
    }
    return balls;
}

}  // namespace

TurningComponents turning_components(const TurningShapes& shapes, const MetricRows& stretches,
                                     const MatrixXd& codes, const TriangleMesh& mesh) {
    const auto codes_on = [&](const BallComponents& turns) {
        return MatrixXd(JointCodes(turns).solve(products(turns, shapes.turns())).transpose());
    };
    MatrixXd fitted = codes;
    for (int round = 0; round < kRounds; ++round) {
        fitted = codes_on(unit_components(shapes.turns(), fitted, kMostTurningPart));
    }
    BallComponents turns = unit_components(shapes.turns(), fitted, kLeastTurnPart);
    const MatrixXd last = codes_on(turns);
    MatrixXd roots = last.completeOrthogonalDecomposition().solve(shapes.roots());
    TurningComponents found(TurnField(mesh, shapes.field().roots()), std::move(turns),
                            std::move(roots), {});
    std::vector<std::vector<int>> turned;
    for (int k = 0; k < found.count(); ++k) turned.push_back(found.vertices_of(k));
    found.set_stretches(
        fitted_components(stretches, with_squares(last), stretch_balls(stretches, last, turned)));
    return found;
}

}  // namespace mscomp
