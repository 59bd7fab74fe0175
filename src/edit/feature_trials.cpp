// SPDX-License-Identifier: MIT
#include "feature_trials.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "mscomp/base/index.h"

namespace mscomp {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kBlock = 64;  // vertices whose derivatives are a dense matrix for a moment

/// The columns of `all` that are of codes `which`.
std::vector<const CodeColumn*> chosen(std::span<const CodeColumn> all, std::span<const int> which) {
    std::vector<const CodeColumn*> result;
    for (const int k : which) result.push_back(&all[at(k)]);
    return result;
}

/// Σ over the entries of a column, squared after they are scaled.
double squared_length(const CodeColumn& column, const MetricScale& scale) {
    double sum = 0;
    for (std::size_t n = 0; n < column.vertices.size(); ++n) {
        for (std::size_t c = 0; c < kFeatureDim; ++c) {
            const double x = static_cast<double>(column.values[kFeatureDim * n + c]) *
                             scale.scale_factor(at(column.vertices[n]), c);
            sum += x * x;
        }
    }
    return sum;
}

/// The prior of a ridge; 1 where no code does anything.
double prior_of(const FeatureObjective& objective, std::span<const float> start,
                std::span<const int> moving) {
    const std::vector<CodeColumn> all = objective.model.derivatives(start);
    double sum = 0;
    for (const CodeColumn* column : chosen(all, moving)) {
        sum += squared_length(*column, objective.scale);
    }
    const double entries = static_cast<double>(objective.model.vertex_count()) * kFeatureDim;
    const double mean = sum / (entries * static_cast<double>(moving.size()));
    return objective.ridge * (mean > 0 && std::isfinite(mean) ? mean : 1);
}

/// Walks through sparse columns, some vertices at a time.
class ColumnWalk {
  public:
    ColumnWalk(std::vector<const CodeColumn*> columns, const MetricScale& scale)
        : columns_(std::move(columns)), scale_(scale), next_(columns_.size(), 0) {}

    /// Adds what the vertices from `first` up to `end`, at most kBlock, give: JᵀJ and Jᵀr, r (n,9)
    /// their residuals, scaled as the derivatives are.
    void add(int first, int end, const VectorXd& r, NormalEquations& equations) {
        acting_.clear();
        for (std::size_t k = 0; k < columns_.size(); ++k) {
            const CodeColumn& column = *columns_[k];
            if (next_[k] == column.vertices.size() || column.vertices[next_[k]] >= end) continue;
            const auto n = static_cast<Eigen::Index>(acting_.size());
            acting_.push_back(static_cast<Eigen::Index>(k));
            block_.col(n).head(r.size()).setZero();
            for (; next_[k] < column.vertices.size() && column.vertices[next_[k]] < end;
                 ++next_[k]) {
                const int v = column.vertices[next_[k]];
                for (std::size_t c = 0; c < kFeatureDim; ++c) {
                    block_(kFeatureDim * (v - first) + static_cast<Eigen::Index>(c), n) =
                        static_cast<double>(column.values[kFeatureDim * next_[k] + c]) *
                        scale_.scale_factor(at(v), c);
                }
            }
        }
        const auto J = block_.topLeftCorner(r.size(), static_cast<Eigen::Index>(acting_.size()));
        const MatrixXd squares = J.transpose() * J;
        const VectorXd slopes = J.transpose() * r;
        for (Eigen::Index a = 0; a < slopes.size(); ++a) {
            equations.g[acting_[at(a)]] += slopes[a];
            for (Eigen::Index b = 0; b < slopes.size(); ++b) {
                equations.H(acting_[at(b)], acting_[at(a)]) += squares(b, a);
            }
        }
    }

  private:
    std::vector<const CodeColumn*> columns_;
    const MetricScale& scale_;
    std::vector<std::size_t> next_;  // of each column, the first entry not yet seen
    std::vector<Eigen::Index> acting_;
    MatrixXd block_{kBlock * kFeatureDim, static_cast<Eigen::Index>(columns_.size())};
};

}  // namespace

FeatureTrials::FeatureTrials(const FeatureObjective& objective, std::span<const float> truth,
                             std::span<const float> start, std::span<const int> moving)
    : CodeTrials({start, moving, VectorXd::Ones(static_cast<Eigen::Index>(moving.size())),
                  prior_of(objective, start, moving)}),
      objective_(objective),
      truth_(truth) {}

std::vector<float> FeatureTrials::rows(std::span<const float> codes) const {
    return objective_.model.decode(codes);
}

void FeatureTrials::compare(Trial& trial) const {
    double squares = 0;
    for (std::size_t i = 0; i < truth_.size(); ++i) {
        const double away = static_cast<double>(trial.rows[i]) - static_cast<double>(truth_[i]);
        const double x = away * objective_.scale.scale_factor(i / kFeatureDim, i % kFeatureDim);
        squares += x * x;
    }
    trial.error = squares / static_cast<double>(truth_.size());
}

NormalEquations FeatureTrials::error_equations(const Trial& trial) const {
    const std::vector<CodeColumn> all = objective_.model.derivatives(trial.codes);
    const auto count = static_cast<Eigen::Index>(freedom().moving.size());
    NormalEquations equations{MatrixXd::Zero(count, count), VectorXd::Zero(count)};
    ColumnWalk walk(chosen(all, freedom().moving), objective_.scale);
    const int vertices = objective_.model.vertex_count();
    for (int first = 0; first < vertices; first += kBlock) {
        const int end = std::min(first + kBlock, vertices);
        VectorXd r(kFeatureDim * (end - first));
        for (Eigen::Index i = 0; i < r.size(); ++i) {
            const std::size_t entry = kFeatureDim * at(first) + at(i);
            r[i] = (static_cast<double>(trial.rows[entry]) - static_cast<double>(truth_[entry])) *
                   objective_.scale.scale_factor(entry / kFeatureDim, entry % kFeatureDim);
        }
        walk.add(first, end, r, equations);
    }
    const double share = 1 / static_cast<double>(truth_.size());
    equations.H *= share;
    equations.g *= share;
    return equations;
}

}  // namespace mscomp
