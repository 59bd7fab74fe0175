// SPDX-License-Identifier: MIT
#include "units/unit_components.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>

#include "multiscale/joint_codes.h"
#include "multiscale/vertex_loops.h"

namespace mscomp {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Eigen::LLT<MatrixXd> normal_equations(const MatrixXd& codes, const std::vector<int>& which) {
    constexpr double kDamping = 1e-10;
    const auto count = static_cast<Index>(which.size());
    MatrixXd here(codes.rows(), count);
    for (Index a = 0; a < count; ++a) here.col(a) = codes.col(which[at(a)]);
    MatrixXd normal = here.transpose() * here;
    normal.diagonal().array() += kDamping * normal.trace() / static_cast<double>(count);
    return Eigen::LLT<MatrixXd>(normal);
}

using Rows =
    Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;

/// What the shapes have at a vertex, (shapes,width).
MatrixXd shapes_of(const MetricRows& rows, int v) {
    return Rows(rows.vertex(v).data(), rows.width(), rows.shape_count()).transpose().cast<double>();
}

/// Least squares (n,width) of the components `which` at a vertex.
MatrixXd fitted(const MetricRows& rows, int v, const MatrixXd& codes,
                const std::vector<int>& which) {
    const MatrixXd products = codes.transpose() * shapes_of(rows, v);
    MatrixXd here(static_cast<Index>(which.size()), rows.width());
    for (std::size_t a = 0; a < which.size(); ++a) {
        here.row(static_cast<Index>(a)) = products.row(which[a]);
    }
    return normal_equations(codes, which).solve(here);
}

/// Lengths (V,K) of all components at all vertices.
MatrixXd lengths_of_all(const MetricRows& rows, const MatrixXd& codes) {
    std::vector<int> all(at(codes.cols()));
    std::iota(all.begin(), all.end(), 0);
    const auto factor = normal_equations(codes, all);
    MatrixXd lengths(rows.vertex_count(), codes.cols());
    for_vertices(rows.vertex_count(), [&](int v) {
        const MatrixXd products = codes.transpose() * shapes_of(rows, v);
        lengths.row(v) = factor.solve(products).rowwise().norm().transpose();
    });
    return lengths;
}

/// Where the sorted supports jump most; all of them where there is one scale.
std::size_t count_of_large(const std::vector<int>& supports) {
    constexpr double kJump = 1.5;
    std::size_t count = supports.size();
    double most = kJump;
    const std::size_t least = std::max<std::size_t>(2, (supports.size() + 4) / 5);
    for (std::size_t i = least; i + least <= supports.size(); ++i) {
        const double jump =
            static_cast<double>(supports[i - 1]) / std::max(1.0, static_cast<double>(supports[i]));
        if (jump < most) continue;
        most = jump;
        count = i;
    }
    return count;
}

}  // namespace

MatrixXd gram_of_shapes(const MetricRows& rows) {
    // Few sums, whatever the number of threads.
    const Chunks chunks{rows.vertex_count(),
                        std::max<std::int64_t>(256, (rows.vertex_count() + 15) / 16)};
    std::vector<MatrixXd> parts(at(chunks.count()));
    parallel_for(chunks.count(), [&](std::int64_t i) {
        MatrixXd& part = parts[at(i)];
        part.setZero(rows.shape_count(), rows.shape_count());
        for (std::int64_t v = chunks.begin(i); v < chunks.end(i); ++v) {
            part.selfadjointView<Eigen::Lower>().rankUpdate(shapes_of(rows, static_cast<int>(v)));
        }
    });
    MatrixXd sum = MatrixXd::Zero(rows.shape_count(), rows.shape_count());
    for (const MatrixXd& part : parts) sum += part;
    return sum.selfadjointView<Eigen::Lower>();
}

BallComponents unit_components(const MetricRows& rows, const MatrixXd& codes, double least) {
    const MatrixXd lengths = lengths_of_all(rows, codes);
    std::vector<Ball> balls(at(codes.cols()));
    for (Index k = 0; k < codes.cols(); ++k) {
        Index longest = 0;
        const double most = lengths.col(k).maxCoeff(&longest);
        balls[at(k)].center = static_cast<int>(longest);
        for (int v = 0; v < rows.vertex_count(); ++v) {
            if (lengths(v, k) > least * most) balls[at(k)].vertices.push_back(v);
        }
    }
    return fitted_components(rows, codes, std::move(balls));
}

BallComponents fitted_components(const MetricRows& rows, const MatrixXd& codes,
                                 std::vector<Ball> balls) {
    BallComponents components(rows.vertex_count(), std::move(balls), rows.width());
    for_vertices(rows.vertex_count(), [&](int v) {
        const auto acting = components.at_vertex(v);
        if (acting.empty()) return;
        const MatrixXd values = fitted(rows, v, codes, {acting.begin(), acting.end()});
        const std::span<float> to = components.values(v);
        Eigen::Map<Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
            to.data(), values.rows(), values.cols()) = values.cast<float>();
    });
    return components;
}

double squares_left(const MetricRows& rows, const BallComponents& components) {
    const MatrixXd codes = JointCodes(components).solve(products(components, rows)).transpose();
    const double sum = sum_over_vertices(rows.vertex_count(), [&](int v) {
        MatrixXd left = shapes_of(rows, v);
        const auto acting = components.at_vertex(v);
        const Rows values(components.values(v).data(), std::ssize(acting), rows.width());
        for (std::size_t a = 0; a < acting.size(); ++a) {
            left.noalias() -=
                codes.col(acting[a]) * values.row(static_cast<Index>(a)).cast<double>();
        }
        return left.squaredNorm();
    });
    return sum / rows.shape_count();
}

std::vector<double> movements(const BallComponents& components, const MatrixXd& codes) {
    std::vector<double> moved;
    for (int k = 0; k < components.count(); ++k) {
        double square = 0;
        for (const float x : components.component(k)) {
            square += static_cast<double>(x) * static_cast<double>(x);
        }
        moved.push_back(square * codes.col(k).squaredNorm());
    }
    return moved;
}

std::vector<int> most_moving_first(const std::vector<double>& movements) {
    std::vector<int> units(movements.size());
    std::iota(units.begin(), units.end(), 0);
    std::ranges::stable_sort(units, std::greater{}, [&](int k) { return movements[at(k)]; });
    return units;
}

UnitOrder order_of_units(const std::vector<double>& movements, const std::vector<int>& supports) {
    UnitOrder order{most_moving_first(movements), {}};
    std::vector<int> sorted = supports;
    std::ranges::sort(sorted, std::greater{});
    const std::size_t large = count_of_large(sorted);
    const int least = sorted[large - 1];
    std::stable_partition(order.units.begin(), order.units.end(),
                          [&](int k) { return supports[at(k)] >= least; });
    order.levels.push_back(static_cast<int>(large));
    if (large < sorted.size()) order.levels.push_back(static_cast<int>(sorted.size() - large));
    return order;
}

}  // namespace mscomp
