// SPDX-License-Identifier: MIT
#include "multiscale/component_gradient.h"

#include <algorithm>

#include "multiscale/joint_codes.h"
#include "multiscale/vertex_loops.h"

namespace mscomp {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Of one vertex, with the codes (shapes,K).
void add_vertex(const BallComponents& components, const MatrixXd& codes, int v,
                const ShapesOfVertex& by_row, double weight, std::vector<float>& gradient) {
    const auto acting = components.at_vertex(v);
    float* to = gradient.data() + components.first_value(v);
    for (std::size_t a = 0; a < acting.size(); ++a) {
        const Eigen::Matrix<double, 9, 1> sum = weight * (by_row * codes.col(acting[a]));
        for (Index c = 0; c < 9; ++c) to[9 * a + at(c)] += static_cast<float>(sum[c]);
    }
}

}  // namespace

void add_component_gradient(const BallComponents& components, const MatrixXd& codes,
                            const MetricRows& by_row, double weight, std::vector<float>& gradient) {
    const MatrixXd z = codes.transpose();
    for_vertices(components.vertex_count(), [&](int v) {
        add_vertex(components, z, v, shapes_at(by_row, v), weight, gradient);
    });
}

double feature_error(const MetricRows& rows, const BallComponents& components,
                     std::vector<float>& gradient) {
    const MatrixXd codes = JointCodes(components).solve(products(components, rows)).transpose();
    const double count = rows.shape_count();
    std::ranges::fill(gradient, 0.0F);
    const double sum = sum_over_vertices(rows.vertex_count(), [&](int v) {
        ShapesOfVertex left = shapes_at(rows, v);
        const auto acting = components.at_vertex(v);
        const ValuesAtVertex values = values_at(components, v);
        for (std::size_t a = 0; a < acting.size(); ++a) {
            left.noalias() -=
                values.row(static_cast<Index>(a)).transpose() * codes.col(acting[a]).transpose();
        }
        add_vertex(components, codes, v, left, -2 / count, gradient);
        return left.squaredNorm();
    });
    return sum / count;
}

}  // namespace mscomp
