// SPDX-License-Identifier: MIT
#include "multiscale/alternating_squares.h"

#include <numeric>
#include <vector>

#include "mscomp/base/parallel.h"
#include "multiscale/joint_codes.h"

namespace mscomp {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using DoubleNines = Eigen::Matrix<double, Eigen::Dynamic, 9, Eigen::RowMajor>;

/// What a vertex needs of the codes.
struct CodeEquations {
    MatrixXd codes;  // (shapes,K)
    MatrixXd gram;   // (K,K), damped
    double mu = 0;

    CodeEquations(const MatrixXd& z, double damping) : codes(z.transpose()), gram(z * z.transpose()) {
        const double mean = gram.trace() / static_cast<double>(gram.rows());
        mu = mean > 0 ? damping * mean : 1; gram.diagonal().array() += mu;
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

/// The squared error at a vertex, and its new values.
double fit_vertex(const MetricRows& rows, const CodeEquations& equations, int v,
                  BallComponents& components, const BallComponents& old, const OneRings& rings, std::span<const float> roots) {
    static const double sm = getenv("SMOOTH") ? atof(getenv("SMOOTH")) : 0;
    const std::span<const int> acting = components.at_vertex(v);
    const std::span<float> values = components.values(v);
    const auto count = static_cast<Index>(acting.size());
    MatrixXd x = Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, 9>>(
                     rows.vertex(v).data(), rows.shape_count(), 9)
                     .cast<double>();
    DoubleNines right(count, 9);
    for (Index a = 0; a < count; ++a) {
        right.row(a).noalias() = equations.codes.col(acting[at(a)]).transpose() * x;
    }
    for (Index a = 0; a < count; ++a) {
        const auto before = Eigen::Map<const Eigen::Matrix<float, 1, 9>>(values.data() + 9 * a);
        x.noalias() -= equations.codes.col(acting[at(a)]) * before.cast<double>();
    }
    const double error = x.squaredNorm();
    if (count == 0) return error;
    if (sm > 0) {
        DoubleNines mean = DoubleNines::Zero(count, 9);
        const int first = rings.offsets[at(v)], last = rings.offsets[at(v) + 1];
        for (int e = first; e < last; ++e) {
            const int u = rings.neighbors[at(e)];
            const auto other = old.at_vertex(u);
            const auto vals = old.values(u);
            std::size_t b = 0;
            for (Index a = 0; a < count; ++a) {
                while (b < other.size() && other[b] < acting[at(a)]) ++b;
                if (b < other.size() && other[b] == acting[at(a)]) {
                    mean.row(a) += (roots[at(v)] / roots[at(u)] / (last - first)) * Eigen::Map<const Eigen::Matrix<float, 1, 9>>(vals.data() + 9 * b).cast<double>();
                }
            }
        }
        right += sm * equations.mu * mean;
    }
    const DoubleNines solved = equations.gram_of(acting).llt().solve(right);
    for (Index i = 0; i < solved.size(); ++i) values[at(i)] = static_cast<float>(solved.data()[i]);
    return error;
}

}  // namespace

double alternate(const MetricRows& rows, double damping, BallComponents& components, const OneRings& rings, std::span<const float> roots) {
    const BallComponents old = components;
    const MatrixXd codes = JointCodes(components).solve(products(components, rows));
    const CodeEquations equations(codes, damping);
    const Chunks chunks{rows.vertex_count(), 64};
    std::vector<double> errors(at(chunks.count()), 0.0);
    parallel_for(chunks.count(), [&](std::int64_t i) {
        for (std::int64_t v = chunks.begin(i); v < chunks.end(i); ++v) {
            errors[at(i)] += fit_vertex(rows, equations, static_cast<int>(v), components, old, rings, roots);
        }
    });
    components.normalize();
    return std::accumulate(errors.begin(), errors.end(), 0.0) / rows.shape_count();
}

}  // namespace mscomp
