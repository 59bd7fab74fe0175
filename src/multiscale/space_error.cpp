// SPDX-License-Identifier: MIT
#include "multiscale/space_error.h"

#include <algorithm>

#include "edit/reduced_normal_equations.h"
#include "mscomp/acap/alignment.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/parallel.h"
#include "mscomp/base/points.h"

namespace mscomp {
namespace {

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

SpaceError::SpaceError(const TriangleMesh& reference, const std::string& weights,
                       const MetricScale& scale, const MetricRows& shapes)
    : scale_(scale),
      shape_count_(shapes.shape_count()),
      layer_(reference, parse_edge_weights(weights), LayerEquations::tangential),
      lossless_(reference, parse_edge_weights(weights)) {
    const double s = unit_ball_scale(reference.vertices);
    weight_ = 1e6 * s * s / (3.0 * reference.vertex_count());
    const std::size_t size = at(scale.vertex_count()) * kFeatureDim;
    std::vector<double> row(size), positions(3 * at(scale.vertex_count()));
    for (int m = 0; m < shape_count_; ++m) {
        for (std::size_t i = 0; i < size; ++i) {
            const int v = static_cast<int>(i / kFeatureDim);
            const std::size_t c = i % kFeatureDim;
            row[i] = scale.offset(c) +
                     scale.unmap_factor(v, c) * static_cast<double>(shapes.value(i, m));
        }
        layer_.positions(row, positions);
        targets_.push_back(as_points(positions));
    }
}

/// Unscaled features (count,V,9) of shapes `first` on.
std::vector<double> SpaceError::features(const BallComponents& components,
                                         const Eigen::MatrixXd& codes, int first, int count) const {
    using Nine = Eigen::Matrix<double, 9, Eigen::Dynamic>;
    const std::size_t size = at(scale_.vertex_count()) * kFeatureDim;
    std::vector<double> rows(at(count) * size);
    const Eigen::MatrixXd z = codes.middleCols(first, count).transpose();
    const Chunks chunks{scale_.vertex_count(), 256};
    parallel_for(chunks.count(), [&](std::int64_t i) {
        Eigen::Matrix<double, Eigen::Dynamic, 9> sum(count, 9);
        for (std::int64_t n = chunks.begin(i); n < chunks.end(i); ++n) {
            const int v = static_cast<int>(n);
            const auto acting = components.at_vertex(v);
            const Nine values =
                Eigen::Map<const Eigen::Matrix<float, 9, Eigen::Dynamic>>(
                    components.values(v).data(), 9, static_cast<Eigen::Index>(acting.size()))
                    .cast<double>();
            sum.setZero();
            for (std::size_t a = 0; a < acting.size(); ++a) {
                sum.noalias() +=
                    z.col(acting[a]) * values.col(static_cast<Eigen::Index>(a)).transpose();
            }
            for (std::size_t c = 0; c < kFeatureDim; ++c) {
                const double factor = scale_.unmap_factor(v, c), offset = scale_.offset(c);
                double* to = rows.data() + at(v) * kFeatureDim + c;
                for (Eigen::Index m = 0; m < count; ++m) {
                    to[at(m) * size] = offset + factor * sum(m, static_cast<Eigen::Index>(c));
                }
            }
        }
    });
    return rows;
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

/// Derivatives in features (count,V,9) of shapes `first` on as those in mapped ones.
void SpaceError::take_gradient(std::span<const double> by_feature, int first, int count,
                               MetricRows& gradient) const {
    const std::size_t size = at(scale_.vertex_count()) * kFeatureDim;
    const Chunks chunks{scale_.vertex_count(), 256};
    parallel_for(chunks.count(), [&](std::int64_t chunk) {
        for (std::int64_t v = chunks.begin(chunk); v < chunks.end(chunk); ++v) {
            for (std::size_t c = 0; c < kFeatureDim; ++c) {
                const double factor = scale_.unmap_factor(static_cast<int>(v), c);
                const std::size_t i = at(v) * kFeatureDim + c;
                for (int m = 0; m < count; ++m) {
                    gradient.set(i, first + m,
                                 static_cast<float>(factor * by_feature[at(m) * size + i]));
                }
            }
        }
    });
}

std::vector<double> SpaceError::evaluate(const BallComponents& components,
                                         const Eigen::MatrixXd& codes, MetricRows& gradient) const {
    std::vector<double> errors(at(shape_count_));
    const std::size_t vertices = at(scale_.vertex_count());
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
        layer_.adjoint(rows, by_position, by_feature);
        take_gradient(by_feature, first, count, gradient);
    }
    return errors;
}

Eigen::MatrixXd SpaceError::normal_matrix(const BallComponents& components,
                                          const Eigen::VectorXd& codes, int m) const {
    const std::size_t vertices = at(scale_.vertex_count());
    const std::vector<double> row = features(components, codes, 0, 1);
    std::vector<double> positions(3 * vertices);
    layer_.positions(row, positions);
    std::vector<std::vector<float>> changes;
    std::vector<FeatureDirection> directions;
    for (int k = 0; k < components.count(); ++k) {
        const std::vector<int>& ball = components.balls()[at(k)].vertices;
        changes.push_back(components.component(k));
        for (std::size_t n = 0; n < ball.size(); ++n) {
            scale_.unmap_change(ball[n],
                                std::span(changes.back()).subspan(n * kFeatureDim, kFeatureDim));
        }
    }
    for (std::size_t k = 0; k < changes.size(); ++k) {
        directions.push_back({components.balls()[k].vertices, changes[k]});
    }
    std::vector<double> derivatives(changes.size() * 3 * vertices);
    const std::vector<float> rounded(row.begin(), row.end());
    lossless_.derivatives(rounded, directions, derivatives);
    const std::vector<Point> points = as_points(positions);
    return weight_ *
           reduced_normal_equations(derivatives, points, left_of(points, targets_[at(m)])).H;
}

}  // namespace mscomp
