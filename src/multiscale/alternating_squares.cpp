// SPDX-License-Identifier: MIT
#include "multiscale/alternating_squares.h"

#include <algorithm>

#include "multiscale/joint_codes.h"
#include "multiscale/vertex_loops.h"

namespace mscomp {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

}  // namespace

/// What a vertex needs of the codes.
struct AlternatingSquares::CodeEquations {
    MatrixXd codes;  // (shapes,K)
    MatrixXd gram;   // (K,K), damped
    double damping;  // of it

    CodeEquations(const MatrixXd& z, double relative)
        : codes(z.transpose()), gram(z * z.transpose()) {
        const double mean = gram.trace() / static_cast<double>(gram.rows());
        damping = mean > 0 ? relative * mean : 1;
        // Components that are zero have no codes, and still an equation each.
        gram.diagonal().array() += std::max(damping, 1e-12 * mean);
    }
    MatrixXd gram_of(std::span<const int> acting) const {
        const auto count = static_cast<Index>(acting.size());
        MatrixXd part(count, count);
        for (Index b = 0; b < count; ++b) {
            for (Index a = 0; a < count; ++a) part(a, b) = gram(acting[at(a)], acting[at(b)]);
        }
        return part;
    }
};

/// Mean of what the neighbours of v have of the components that act at v.
ValuesAtVertex AlternatingSquares::ring_mean(const BallComponents& components, int v) const {
    const std::span<const int> acting = components.at_vertex(v);
    ValuesAtVertex mean = ValuesAtVertex::Zero(static_cast<Index>(acting.size()), 9);
    const int first = rings_.offsets[at(v)], last = rings_.offsets[at(v) + 1];
    for (int entry = first; entry < last; ++entry) {
        const int u = rings_.neighbors[at(entry)];
        const std::span<const int> others = components.at_vertex(u);
        const float* values = components.values(u).data();
        const double share = scale_.root(at(v)) / (scale_.root(at(u)) * (last - first));
        std::size_t b = 0;
        for (std::size_t a = 0; a < acting.size(); ++a) {
            while (b < others.size() && others[b] < acting[a]) ++b;
            if (b == others.size() || others[b] != acting[a]) continue;
            mean.row(static_cast<Index>(a)) +=
                share * Eigen::Map<const Eigen::Matrix<float, 1, 9>>(values + 9 * b).cast<double>();
        }
    }
    return mean;
}

/// The squared error at a vertex, and its new values.
double AlternatingSquares::fit_vertex(const MetricRows& rows, const CodeEquations& equations,
                                      const BallComponents& before, int v,
                                      BallComponents& components) const {
    const std::span<const int> acting = components.at_vertex(v);
    const std::span<float> values = components.values(v);
    const auto count = static_cast<Index>(acting.size());
    MatrixXd x = shapes_at(rows, v).transpose();
    ValuesAtVertex right = equations.damping * ring_mean(before, v);
    for (Index a = 0; a < count; ++a) {
        right.row(a).noalias() += equations.codes.col(acting[at(a)]).transpose() * x;
    }
    for (Index a = 0; a < count; ++a) {
        const auto own = Eigen::Map<const Eigen::Matrix<float, 1, 9>>(values.data() + 9 * a);
        x.noalias() -= equations.codes.col(acting[at(a)]) * own.cast<double>();
    }
    const double error = x.squaredNorm();
    if (count == 0) return error;
    const ValuesAtVertex solved = equations.gram_of(acting).llt().solve(right);
    for (Index i = 0; i < solved.size(); ++i) values[at(i)] = static_cast<float>(solved.data()[i]);
    return error;
}

double AlternatingSquares::round(const MetricRows& rows, BallComponents& components) const {
    const MatrixXd codes = JointCodes(components).solve(products(components, rows));
    const CodeEquations equations(codes, damping_);
    const BallComponents before = components;
    const double error = sum_over_vertices(rows.vertex_count(), [&](int v) {
        return fit_vertex(rows, equations, before, v, components);
    });
    components.normalize();
    return error / rows.shape_count();
}

}  // namespace mscomp
