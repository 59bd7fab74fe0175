// SPDX-License-Identifier: MIT
#include "multiscale/space_descent.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "multiscale/component_gradient.h"
#include "multiscale/joint_codes.h"
#include "multiscale/vertex_loops.h"

namespace mscomp {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Of Adam, beside the root mean square of a value: so much of the part of the features that is not
// explained, and at most.
constexpr double kRate = 0.3, kMostRate = 0.03;
constexpr double kRateSteps = 25;  // after so many steps it is 1 / sqrt(2) of that
// So many first steps grow up to it: before Adam knows the size of a derivative, every value would
// go the whole step its own way at once, and limbs with them.
constexpr double kGrowingSteps = 10;
constexpr double kDecay1 = 0.9, kDecay2 = 0.99;
constexpr double kCodeDamping = 0.02;  // of normal matrices
constexpr double kCodeStep = 0.5;

double mean_of(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double root_mean_square(std::span<const float> values) {
    double sum = 0;
    std::size_t count = 0;
    for (const float x : values) {
        sum += static_cast<double>(x) * static_cast<double>(x);
        count += x != 0 ? 1 : 0;
    }
    return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0;
}

}  // namespace

/// Gauss-Newton steps of the codes of every shape, with matrices of one moment.
class SpaceDescent::Codes {
  public:
    /// Around `start` (K,shapes), with the matrices (K,K) of each shape.
    Codes(const MatrixXd& start, std::vector<MatrixXd> matrices)
        : start_(start), stiffness_(start.rows()) {
        // As the prior of VertexFit, whose error is 10⁻⁶ of this.
        for (Index k = 0; k < start.rows(); ++k) {
            const double square = start.row(k).squaredNorm() / static_cast<double>(start.cols());
            stiffness_[k] = square > 0 ? 1 / (square * static_cast<double>(start.rows())) : 1;
        }
        for (MatrixXd& h : matrices) {
            h.diagonal() *= 1 + kCodeDamping;
            h.diagonal() += stiffness_;
            factors_.emplace_back(h);
        }
    }
    void step(const MatrixXd& gradient, MatrixXd& codes) const {
        for (Index m = 0; m < codes.cols(); ++m) {
            const VectorXd wanted =
                0.5 * gradient.col(m) + stiffness_.cwiseProduct(codes.col(m) - start_.col(m));
            codes.col(m) -= kCodeStep * factors_[at(m)].solve(wanted);
        }
    }

  private:
    const MatrixXd& start_;
    VectorXd stiffness_;
    std::vector<Eigen::LLT<MatrixXd>> factors_;
};

SpaceState SpaceDescent::begin(const BallComponents& components) const {
    const std::size_t size = components.all_values().size();
    return {JointCodes(components).solve(products(components, rows_)),
            std::vector<float>(size, 0.0F), std::vector<float>(size, 0.0F), 0};
}

SpaceDescent::SpaceDescent(const TriangleMesh& reference, const std::string& weights,
                           const MetricScale& scale, const MetricRows& rows, double feature_share)
    : scale_(scale),
      rows_(rows),
      error_(reference, weights, scale, rows),
      lossless_(reference, parse_edge_weights(weights)),
      feature_share_(feature_share) {
    energy_ = sum_over_vertices(rows.vertex_count(),
                                [&](int v) { return shapes_at(rows, v).squaredNorm(); }) /
              rows.shape_count();
}

/// Adam, whose steps are of the size of the rate: beside the root mean square of a value, and more
/// where a vertex counts more.
void SpaceDescent::update(double rate, const std::vector<float>& gradient,
                          BallComponents& components, SpaceState& state) const {
    constexpr double kTiny = 1e-30;
    const auto steps = static_cast<double>(++state.steps);
    const double step =
        rate * std::min(1.0, steps / kGrowingSteps) / std::sqrt(1 + steps / kRateSteps);
    const double bias1 = 1 - std::pow(kDecay1, steps), bias2 = 1 - std::pow(kDecay2, steps);
    const std::span<float> values = components.all_values();
    for_vertices(components.vertex_count(), [&](int v) {
        const std::size_t first = components.first_value(v);
        const std::size_t count = components.values(v).size();
        for (std::size_t i = first; i < first + count; ++i) {
            const auto g = static_cast<double>(gradient[i]);
            const double m = kDecay1 * static_cast<double>(state.moment1[i]) + (1 - kDecay1) * g;
            const double q =
                kDecay2 * static_cast<double>(state.moment2[i]) + (1 - kDecay2) * g * g;
            state.moment1[i] = static_cast<float>(m);
            state.moment2[i] = static_cast<float>(q);
            if (!(q > kTiny)) continue;
            values[i] =
                static_cast<float>(static_cast<double>(values[i]) -
                                   step * scale_.root(at(v)) * (m / bias1) / std::sqrt(q / bias2));
        }
    });
}

/// Goes with the part of the features that is not explained, as far as that is small.
double SpaceDescent::step_size(const BallComponents& components, double features) const {
    const double part = energy_ > 0 ? std::sqrt(features / energy_) : 0;
    return std::min(kMostRate, kRate * part) * root_mean_square(components.all_values());
}

SpaceDescent::Report SpaceDescent::run_epoch(double rate, BallComponents& components,
                                             SpaceState& state) const {
    const MatrixXd start = state.codes;
    const Codes gauss_newton(start, error_.normal_matrices(components, start, lossless_));
    MetricRows by_row(rows_.vertex_count(), rows_.shape_count());
    std::vector<float> gradient(components.all_values().size());
    Report report;
    double weight = 0, size = 0;
    for (int step = 0; step < kSteps; ++step) {
        const double space = mean_of(error_.evaluate(components, state.codes, &by_row));
        const double features = feature_error(rows_, components, gradient);
        if (step == 0) {
            weight = features > 0 ? feature_share_ * space / features : 0;
            size = rate * step_size(components, features);
            report.first = space + weight * features;
        }
        for (float& g : gradient) g = static_cast<float>(weight * static_cast<double>(g));
        add_component_gradient(components, state.codes, by_row, 1.0 / rows_.shape_count(),
                               gradient);
        gauss_newton.step(products(components, by_row), state.codes);
        update(size, gradient, components, state);
        report.space += space / kSteps;
        report.features += features / kSteps;
        report.total += (space + weight * features) / kSteps;
    }
    return report;
}

}  // namespace mscomp
