// SPDX-License-Identifier: MIT
#include "multiscale/joint_codes.h"

#include <algorithm>
#include <array>

#include "multiscale/vertex_loops.h"

namespace mscomp {
namespace {

using Eigen::MatrixXd;

/// At most 64 chunks, so that one partial sum for each takes up little memory.
Chunks vertex_chunks(int vertices) {
    constexpr std::int64_t kLeast = 128, kMost = 64;
    return {vertices, std::max(kLeast, (vertices + kMost - 1) / kMost)};
}

/// The sum over all vertices of what add(v, sum) adds, for matrices of this size.
template <class Add>
MatrixXd sum_of_matrices(int vertices, Eigen::Index rows, Eigen::Index columns, const Add& add) {
    const Chunks chunks = vertex_chunks(vertices);
    std::vector<MatrixXd> parts(at(chunks.count()));
    parallel_for(chunks.count(), [&](std::int64_t i) {
        MatrixXd& part = parts[at(i)];
        part.setZero(rows, columns);
        for (std::int64_t v = chunks.begin(i); v < chunks.end(i); ++v)
            add(static_cast<int>(v), part);
    });
    MatrixXd sum = MatrixXd::Zero(rows, columns);
    for (const MatrixXd& part : parts) sum += part;
    return sum;
}

/// Adds a matrix over the components that act at a vertex to one over all.
void add_pairs(std::span<const int> acting, const MatrixXd& pairs, MatrixXd& sum) {
    for (std::size_t a = 0; a < acting.size(); ++a) {
        for (std::size_t b = 0; b < acting.size(); ++b) {
            sum(acting[a], acting[b]) +=
                pairs(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b));
        }
    }
}

}  // namespace

MatrixXd gram_matrix(const BallComponents& components) {
    const int count = components.count();
    return with_width(components.width(), [&]<int Width>() {
        return sum_of_matrices(components.vertex_count(), count, count, [&](int v, MatrixXd& sum) {
            const auto values = values_at<Width>(components, v);
            add_pairs(components.at_vertex(v), values * values.transpose(), sum);
        });
    });
}

MatrixXd overlaps(const BallComponents& components) {
    const int count = components.count();
    return with_width(components.width(), [&]<int Width>() {
        return sum_of_matrices(components.vertex_count(), count, count, [&](int v, MatrixXd& sum) {
            const Eigen::VectorXd squares = values_at<Width>(components, v).rowwise().squaredNorm();
            add_pairs(components.at_vertex(v), squares * squares.transpose(), sum);
        });
    });
}

MatrixXd products(const BallComponents& components, const MetricRows& rows) {
    const int shapes = rows.shape_count();
    // Shapes are columns, contiguous for each component.
    const auto add = [&]<int Width>(int v, MatrixXd& sum) {
        const auto x = shapes_at<Width>(rows, v);
        const auto values = values_at<Width>(components, v);
        const auto acting = components.at_vertex(v);
        for (std::size_t a = 0; a < acting.size(); ++a) {
            sum.col(acting[a]).noalias() +=
                x.transpose() * values.row(static_cast<Eigen::Index>(a)).transpose();
        }
    };
    return with_width(components.width(), [&]<int Width>() {
        return MatrixXd(
            sum_of_matrices(rows.vertex_count(), shapes, components.count(),
                            [&](int v, MatrixXd& sum) { add.template operator()<Width>(v, sum); })
                .transpose());
    });
}

Eigen::VectorXd products(const BallComponents& components, std::span<const float> row) {
    const auto add = [&]<int Width>(int v, MatrixXd& sum) {
        using Row = Eigen::Matrix<float, Width, 1>;
        const auto x = Eigen::Map<const Row>(row.data() + at(Width) * at(v));
        const Eigen::VectorXd all = values_at<Width>(components, v) * x.template cast<double>();
        const auto acting = components.at_vertex(v);
        for (std::size_t a = 0; a < acting.size(); ++a) {
            sum(acting[a], 0) += all[static_cast<Eigen::Index>(a)];
        }
    };
    return with_width(components.width(), [&]<int Width>() {
        return sum_of_matrices(
            components.vertex_count(), components.count(), 1,
            [&](int v, MatrixXd& sum) { add.template operator()<Width>(v, sum); });
    });
}

std::vector<float> weighted_sum(const BallComponents& components, std::span<const float> codes) {
    const auto count = static_cast<int>(codes.size());
    std::vector<float> row(at(components.vertex_count()) * at(components.width()));
    const auto add = [&]<int Width>(int v) {
        const auto acting = components.at_vertex(v);
        const auto values = components.values(v);
        std::array<double, Width> total{};
        for (std::size_t a = 0; a < acting.size() && acting[a] < count; ++a) {
            const auto code = static_cast<double>(codes[at(acting[a])]);
            for (std::size_t c = 0; c < total.size(); ++c) {
                total[c] += code * static_cast<double>(values[total.size() * a + c]);
            }
        }
        for (std::size_t c = 0; c < total.size(); ++c) {
            row[at(v) * total.size() + c] = static_cast<float>(total[c]);
        }
    };
    with_width(components.width(), [&]<int Width>() {
        for_vertices(components.vertex_count(), [&](int v) { add.template operator()<Width>(v); });
    });
    return row;
}

JointCodes::JointCodes(MatrixXd gram) {
    constexpr double kDamping = 1e-7;
    for (Eigen::Index k = 0; k < gram.rows(); ++k) {
        if (gram(k, k) == 0) gram(k, k) = 1;
    }
    gram.diagonal().array() += kDamping * gram.trace() / static_cast<double>(gram.rows());
    factor_.compute(gram);
}

}  // namespace mscomp
