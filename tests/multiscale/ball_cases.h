// SPDX-License-Identifier: MIT
// A sphere with components on balls, and shapes that they make.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "mscomp/acap/area_metric.h"
#include "mscomp/base/random.h"
#include "multiscale/ball_components.h"
#include "multiscale/metric_rows.h"
#include "nn/small_training.h"
#include "shapes.h"

namespace mscomp::cases {

struct Sphere {
    TriangleMesh mesh = shapes::icosphere(2);
    nn::SphereDistances distances{mesh.vertices};
    MetricScale scale = around(2);

    static MetricScale around(double factor) {
        MetricScale result;
        for (std::size_t c = 0; c < kFeatureDim; ++c) {
            result.offset[c] = static_cast<double>(kReferenceFeature[c]);
            result.factor[c] = factor;
        }
        return result;
    }
    Sphere() { scale.roots = area_metric(mesh); }

    int vertices() const { return mesh.vertex_count(); }
    Ball ball(int center, double radius) {
        Ball result{center, {}};
        const auto row = distances.row(center);
        for (int v = 0; v < vertices(); ++v) {
            if (row[at(v)] <= radius) result.vertices.push_back(v);
        }
        return result;
    }
    /// Random values of unit length on balls around every `step`-th vertex.
    BallComponents components(int count, double radius, int step = 17, int width = kFeatureDim) {
        std::vector<Ball> balls;
        for (int k = 0; k < count; ++k) balls.push_back(ball(k * step % vertices(), radius));
        BallComponents result(vertices(), std::move(balls), width);
        const CounterRandom random(5, 0);
        for (std::size_t i = 0; i < result.all_values().size(); ++i) {
            result.all_values()[i] = static_cast<float>(random.normal(i));
        }
        result.normalize();
        return result;
    }
};

inline Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns,
                                     std::uint64_t stream) {
    const CounterRandom random(9, stream);
    Eigen::MatrixXd result(rows, columns);
    for (Eigen::Index i = 0; i < result.size(); ++i) {
        result.data()[i] = random.normal(static_cast<std::uint64_t>(i));
    }
    return result;
}

/// All components as columns (width V,K).
inline Eigen::MatrixXd dense(const BallComponents& components) {
    const auto width = at(components.width());
    Eigen::MatrixXd result =
        Eigen::MatrixXd::Zero(components.width() * components.vertex_count(), components.count());
    for (int k = 0; k < components.count(); ++k) {
        const std::vector<float> values = components.component(k);
        const std::vector<int>& ball = components.balls()[at(k)].vertices;
        for (std::size_t i = 0; i < values.size(); ++i) {
            result(components.width() * ball[i / width] + static_cast<Eigen::Index>(i % width), k) =
                static_cast<double>(values[i]);
        }
    }
    return result;
}

/// Rows of shapes (width V,n).
inline MetricRows rows_of(const Eigen::MatrixXd& shapes, int width = kFeatureDim) {
    MetricRows rows(static_cast<int>(shapes.rows()) / width, static_cast<int>(shapes.cols()),
                    width);
    for (Eigen::Index m = 0; m < shapes.cols(); ++m) {
        const Eigen::VectorXf row = shapes.col(m).cast<float>();
        rows.set(static_cast<int>(m), {row.data(), at(row.size())});
    }
    return rows;
}

}  // namespace mscomp::cases
