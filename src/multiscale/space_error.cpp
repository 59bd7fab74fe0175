// SPDX-License-Identifier: MIT
#include "multiscale/space_error.h"

#include <algorithm>

#include "edit/reduced_normal_equations.h"
#include "mscomp/acap/alignment.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/points.h"
#include "multiscale/code_columns.h"
#include "multiscale/vertex_loops.h"

namespace mscomp {
namespace {

using ShapeValues = Eigen::Matrix<double, Eigen::Dynamic, 9>;  // of a vertex

constexpr int kAtOnce = 16;  // shapes whose features and positions are there together

std::vector<Point> as_points(std::span<const double> positions) {
    std::vector<Point> points;
    for (std::size_t i = 0; i < positions.size(); i += 3) {
        points.push_back({positions[i], positions[i + 1], positions[i + 2]});
    }
    return points;
}

/// p - g P for the best rigid motion g.
std::vector<Point> left_of(const std::vector<Point>& positions, const std::vector<Point>& target) {
    std::vector<Point> left = moved(target, best_rigid_motion(target, positions));
    for (std::size_t v = 0; v < left.size(); ++v) left[v] = minus(positions[v], left[v]);
    return left;
}

}  // namespace

template <class Scaled>
std::vector<double> SpaceError::unscaled(int count, const Scaled& scaled) const {
    const std::size_t size = at(vertices_) * kFeatureDim;
    std::vector<double> rows(at(count) * size);
    for_vertices(vertices_, [&](int v) {
        const ShapeValues values = scaled(v);
        for (std::size_t c = 0; c < kFeatureDim; ++c) {
            const double factor = scale_.unscale_factor(at(v), c), offset = scale_.offset[c];
            double* to = rows.data() + at(v) * kFeatureDim + c;
            for (Eigen::Index m = 0; m < count; ++m) {
                to[at(m) * size] = offset + factor * values(m, static_cast<Eigen::Index>(c));
            }
        }
    });
    return rows;
}

/// Of components and codes.
std::vector<double> SpaceError::features(const BallComponents& components,
                                         const Eigen::MatrixXd& codes, int first, int count) const {
    const Eigen::MatrixXd z = codes.middleCols(first, count).transpose();
    return unscaled(count, [&](int v) {
        const auto acting = components.at_vertex(v);
        const ValuesAtVertex values = values_at(components, v);
        ShapeValues sum = ShapeValues::Zero(count, 9);
        for (std::size_t a = 0; a < acting.size(); ++a) {
            sum.noalias() += z.col(acting[a]) * values.row(static_cast<Eigen::Index>(a));
        }
        return sum;
    });
}

SpaceError::SpaceError(const TriangleMesh& reference, const std::string& weights,
                       const MetricScale& scale, const MetricRows& shapes)
    : scale_(scale),
      vertices_(reference.vertex_count()),
      shape_count_(shapes.shape_count()),
      layer_(reference, parse_edge_weights(weights), LayerEquations::tangential) {
    const double s = unit_ball_scale(reference.vertices);
    weight_ = 1e6 * s * s / (3.0 * vertices_);
    const std::size_t size = 3 * at(vertices_);
    for (int first = 0; first < shape_count_; first += kAtOnce) {
        const int count = std::min(kAtOnce, shape_count_ - first);
        const std::vector<double> rows = unscaled(count, [&](int v) {
            return ShapeValues(shapes_at(shapes, v).middleCols(first, count).transpose());
        });
        std::vector<double> positions(at(count) * size);
        layer_.positions(rows, positions);
        for (int m = 0; m < count; ++m) {
            targets_.push_back(as_points(std::span(positions).subspan(at(m) * size, size)));
        }
    }
}

/// E of one shape, and its derivative in the positions.
double SpaceError::compare(int m, std::span<const double> positions,
                           std::span<double> gradient) const {
    const std::vector<Point> left = left_of(as_points(positions), targets_[at(m)]);
    double error = 0;
    for (std::size_t v = 0; v < left.size(); ++v) {
        error += weight_ * dot(left[v], left[v]);
        for (std::size_t x = 0; x < 3; ++x) gradient[3 * v + x] = 2 * weight_ * left[v][x];
    }
    return error;
}

/// Derivatives in features (count,V,9) of shapes `first` on as those in scaled ones.
void SpaceError::take_gradient(std::span<const double> by_feature, int first, int count,
                               MetricRows& gradient) const {
    const std::size_t size = at(vertices_) * kFeatureDim;
    for_vertices(vertices_, [&](int v) {
        for (std::size_t c = 0; c < kFeatureDim; ++c) {
            const double factor = scale_.unscale_factor(at(v), c);
            const std::size_t i = at(v) * kFeatureDim + c;
            for (int m = 0; m < count; ++m) {
                const double derivative = factor * by_feature[at(m) * size + i];
                gradient.set(i, first + m, static_cast<float>(derivative));
            }
        }
    });
}

std::vector<double> SpaceError::evaluate(const BallComponents& components,
                                         const Eigen::MatrixXd& codes, MetricRows* gradient) const {
    std::vector<double> errors(at(shape_count_));
    const std::size_t vertices = at(vertices_);
    std::vector<double> positions, by_position, by_feature;
    for (int first = 0; first < shape_count_; first += kAtOnce) {
        const int count = std::min(kAtOnce, shape_count_ - first);
        const std::vector<double> rows = features(components, codes, first, count);
        positions.resize(at(count) * vertices * 3);
        by_position.resize(positions.size());
        by_feature.resize(rows.size());
        layer_.positions(rows, positions);
        parallel_for(count, [&](std::int64_t m) {
            const std::size_t begin = at(m) * vertices * 3;
            errors[at(first + m)] = compare(first + static_cast<int>(m),
                                            std::span(positions).subspan(begin, 3 * vertices),
                                            std::span(by_position).subspan(begin, 3 * vertices));
        });
        if (gradient == nullptr) continue;
        layer_.adjoint(rows, by_position, by_feature);
        take_gradient(by_feature, first, count, *gradient);
    }
    return errors;
}

std::vector<Eigen::MatrixXd> SpaceError::normal_matrices(
    const BallComponents& components, const Eigen::MatrixXd& codes,
    const LosslessReconstruction& lossless) const {
    const std::size_t size = 3 * at(vertices_);
    const std::vector<CodeColumn> columns = code_columns(components, RowMap(scale_));
    std::vector<FeatureDirection> directions;
    for (const CodeColumn& column : columns) directions.push_back({column.vertices, column.values});
    std::vector<Eigen::MatrixXd> matrices(at(shape_count_));
    parallel_for(shape_count_, [&](std::int64_t m) {
        const std::vector<double> row = features(components, codes, static_cast<int>(m), 1);
        std::vector<double> positions(size), derivatives(directions.size() * size);
        layer_.positions(row, positions);
        lossless.derivatives(std::vector<float>(row.begin(), row.end()), directions, derivatives);
        const std::vector<Point> points = as_points(positions);
        const std::vector<Point> left = left_of(points, targets_[at(m)]);
        matrices[at(m)] = weight_ * reduced_normal_equations(derivatives, points, left).H;
    });
    return matrices;
}

}  // namespace mscomp
