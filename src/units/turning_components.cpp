// SPDX-License-Identifier: MIT
#include "units/turning_components.h"

#include <Eigen/QR>
#include <algorithm>
#include <iterator>
#include <utility>

#include "acap/rotation.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "mscomp/base/interruption.h"
#include "mscomp/base/parallel.h"
#include "multiscale/joint_codes.h"
#include "units/quiet_codes.h"
#include "units/turn_fit.h"
#include "units/unit_components.h"

namespace mscomp {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;

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

/// The rotation vectors (V,3) of features (V,9).
std::vector<float> vectors_of(std::span<const float> features) {
    std::vector<float> vectors;
    vectors.reserve(features.size() / kFeatureDim * kRotationDim);
    for (std::size_t i = 0; i < features.size(); ++i) {
        if (i % kFeatureDim < kRotationDim) vectors.push_back(features[i]);
    }
    return vectors;
}

}  // namespace

void TurningShapes::set(int m, std::span<const float> features) {
    const std::vector<float> vectors = vectors_of(features);
    rotations_.set(m, vectors);
    turns_.set(m, field_.turns_of(vectors));
}

std::vector<int> TurningShapes::least_turning() const {
    std::vector<double> squares;
    for (int v = 0; v < rotations_.vertex_count(); ++v) {
        double square = 0;
        for (const float x : rotations_.vertex(v)) {
            square += static_cast<double>(x) * static_cast<double>(x);
        }
        squares.push_back(square);
    }
    std::vector<int> roots;
    for (const std::vector<int>& piece : field_.pieces()) {
        roots.push_back(*std::ranges::min_element(piece, [&](int a, int b) {
            return squares[at(a)] < squares[at(b)] || (squares[at(a)] == squares[at(b)] && a < b);
        }));
    }
    return roots;
}

MatrixXd TurningShapes::roots() const {
    MatrixXd roots(rotations_.shape_count(), 3 * std::ssize(field_.roots()));
    for (Index i = 0; i < roots.cols(); ++i) {
        const std::size_t from = 3 * at(field_.roots()[at(i / 3)]) + at(i % 3);
        for (Index m = 0; m < roots.rows(); ++m) {
            roots(m, i) = static_cast<double>(rotations_.value(from, static_cast<int>(m)));
        }
    }
    return roots;
}

std::vector<Point> TurningShapes::middles(const TriangleMesh& mesh, const TurnField& field) {
    std::vector<Point> middles;
    for (const auto& [i, j] : field.edges()) {
        const Point &p = mesh.vertices[at(i)], &q = mesh.vertices[at(j)];
        middles.push_back({(p[0] + q[0]) / 2, (p[1] + q[1]) / 2, (p[2] + q[2]) / 2});
    }
    return middles;
}

namespace {

BallComponents chosen(const BallComponents& all, const std::vector<int>& which) {
    std::vector<Ball> balls;
    for (const int k : which) balls.push_back(all.balls()[at(k)]);
    BallComponents result(all.vertex_count(), std::move(balls), all.width());
    for (std::size_t n = 0; n < which.size(); ++n) {
        result.set_component(static_cast<int>(n), all.component(which[n]));
    }
    return result;
}

}  // namespace

TurningComponents::TurningComponents(TurnField field, BallComponents turns, MatrixXd roots,
                                     BallComponents stretches)
    : field_(std::move(field)),
      turns_(std::move(turns)),
      roots_(std::move(roots)),
      stretches_(std::move(stretches)) {}

void TurningComponents::choose(const std::vector<int>& which) {
    std::vector<int> of_stretches = which;
    for (const int k : which) of_stretches.push_back(count() + k);
    stretches_ = chosen(stretches_, of_stretches);
    roots_ = roots_(which, Eigen::all).eval();
    turns_ = chosen(turns_, which);
}

Eigen::VectorXd TurningComponents::codes_of(std::span<const float> features) const {
    const std::vector<float> vectors = vectors_of(features);
    return codes_of(vectors, field_.turns_of(vectors));
}

MatrixXd TurningComponents::codes_of(const TurningShapes& shapes) const {
    MatrixXd codes(shapes.turns().shape_count(), count());
    for (int m = 0; m < shapes.turns().shape_count(); ++m) {
        throw_if_interrupted(kSearchInterrupted);
        codes.row(m) = codes_of(shapes.rotations().row(m), shapes.turns().row(m));
    }
    return codes;
}

/// Of rotation vectors (V,3) and their turns (E,3).
Eigen::VectorXd TurningComponents::codes_of(std::span<const float> vectors,
                                            std::span<const float> turns) const {
    std::vector<Eigen::Matrix3d> rotations(at(field_.vertex_count()));
    for (std::size_t v = 0; v < rotations.size(); ++v) {
        rotations[v] =
            rotation_exp(Eigen::Map<const Eigen::Vector3f>(vectors.data() + 3 * v).cast<double>());
    }
    // Turns as the shape has them in space, those of each component and last its own.
    MatrixXd added(3 * field_.vertex_count(), count() + 1);
    parallel_for(count() + 1, [&](std::int64_t k) {
        std::vector<Vector3d> turned(at(field_.edge_count()), Vector3d::Zero());
        const auto put = [&](int e, const float* turn) {
            turned[at(e)] = rotations[at(field_.edges()[at(e)][0])] *
                            Eigen::Map<const Eigen::Vector3f>(turn).cast<double>();
        };
        if (k == count()) {
            for (int e = 0; e < field_.edge_count(); ++e) put(e, turns.data() + 3 * at(e));
        } else {
            const std::vector<float> values = turns_.component(static_cast<int>(k));
            const std::vector<int>& edges = turns_.balls()[at(k)].vertices;
            for (std::size_t n = 0; n < edges.size(); ++n) put(edges[n], values.data() + 3 * n);
        }
        const std::vector<Vector3d> sums = field_.added_up(turned);
        added.col(k) = Eigen::Map<const Eigen::VectorXd>(sums.front().data(), added.rows());
    });
    const auto own = added.leftCols(count());
    return JointCodes(own.transpose() * own).solve(own.transpose() * added.rightCols(1));
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
    std::vector<Ball> balls = unit_components(stretches, codes).balls();
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

FittedTurning turning_components(const TurningShapes& shapes, const MetricRows& stretches,
                                 const MatrixXd& codes, const TriangleMesh& mesh) {
    const auto codes_on = [&](const BallComponents& turns) {
        return MatrixXd(JointCodes(turns).solve(products(turns, shapes.turns())).transpose());
    };
    const auto carrying = [&](const MatrixXd& given) {
        BallComponents turns = unit_components(shapes.turns(), given);
        return TurningComponents(
            TurnField(mesh, shapes.field().roots()),
            fitted_to_carry(shapes.field(), shapes.turns(), given, std::move(turns)), {}, {});
    };
    MatrixXd fitted = codes;
    for (int round = 0; round < kRounds; ++round) {
        fitted = codes_on(unit_components(shapes.turns(), fitted, kMostTurningPart));
    }
    TurningComponents found = carrying(carrying(fitted).codes_of(shapes));
    MatrixXd last = found.codes_of(shapes);
    found.set_roots(last.completeOrthogonalDecomposition().solve(shapes.roots()));
    std::vector<std::vector<int>> turned;
    for (int k = 0; k < found.count(); ++k) turned.push_back(found.vertices_of(k));
    found.set_stretches(
        fitted_components(stretches, with_squares(last), stretch_balls(stretches, last, turned)));
    return {std::move(found), std::move(last)};
}

}  // namespace mscomp
