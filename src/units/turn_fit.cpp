// SPDX-License-Identifier: MIT
#include "units/turn_fit.h"

#include <utility>
#include <vector>

#include "mscomp/base/index.h"
#include "mscomp/base/interruption.h"
#include "mscomp/base/parallel.h"
#include "units/quiet_codes.h"

namespace mscomp {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using EdgeTurns = std::vector<Vector3d>;  // along all edges

constexpr double kLocalPart = 0.01;
constexpr int kSteps = 20;

/// Of each component, at the edges of its ball.
using Parts = std::vector<Eigen::Matrix3Xd>;

double dot(const Parts& a, const Parts& b) {
    double sum = 0;
    for (std::size_t k = 0; k < a.size(); ++k) sum += (a[k].array() * b[k].array()).sum();
    return sum;
}

class CarriedFit {
  public:
    CarriedFit(const TurnField& field, const MetricRows& turns, const MatrixXd& codes,
               const BallComponents& components)
        : field_(field), components_(components), gram_(codes.transpose() * codes) {
        std::vector<double> local(at(components.count())), carried(local.size());
        sides_.resize(local.size());
        std::vector<EdgeTurns> products(local.size());
        parallel_for(std::ssize(local), [&](std::int64_t k) {
            const EdgeTurns all = product(turns, codes.col(k));
            products[at(k)] = field_.shared_out(field_.added_up(all));
            for (std::size_t e = 0; e < all.size(); ++e) {
                local[at(k)] += all[e].squaredNorm();
                carried[at(k)] += all[e].dot(products[at(k)][e]);
            }
            sides_[at(k)] = on_ball(all, static_cast<int>(k));
        });
        double locals = 0, all_carried = 0;
        for (std::size_t k = 0; k < local.size(); ++k) {
            locals += local[k];
            all_carried += carried[k];
        }
        local_ = locals > 0 ? kLocalPart * all_carried / locals : 0;
        for (std::size_t k = 0; k < local.size(); ++k) {
            sides_[k] = local_ * sides_[k] + on_ball(products[k], static_cast<int>(k));
        }
    }

    Parts solved(Parts x) const {
        Parts residual = sides_;
        add(residual, -1, applied(x));
        Parts z = preconditioned(residual), direction = z;
        double square = dot(residual, z);
        const double least = 1e-12 * dot(sides_, preconditioned(sides_));
        for (int step = 0; step < kSteps && square > least; ++step) {
            throw_if_interrupted(kSearchInterrupted);
            const Parts moved = applied(direction);
            const double length = square / dot(direction, moved);
            add(x, length, direction);
            add(residual, -length, moved);
            z = preconditioned(residual);
            const double next = dot(residual, z);
            for (std::size_t k = 0; k < z.size(); ++k) {
                direction[k] = z[k] + next / square * direction[k];
            }
            square = next;
        }
        return x;
    }

  private:
    /// Σ_n z_n x_n.
    static EdgeTurns product(const MetricRows& turns, const Eigen::VectorXd& code) {
        EdgeTurns sum(at(turns.vertex_count()));
        using Rows3 = Eigen::Map<const Eigen::Matrix<float, 3, Eigen::Dynamic, Eigen::RowMajor>>;
        for (int e = 0; e < turns.vertex_count(); ++e) {
            sum[at(e)] =
                Rows3(turns.vertex(e).data(), 3, turns.shape_count()).cast<double>() * code;
        }
        return sum;
    }
    Eigen::Matrix3Xd on_ball(const EdgeTurns& turns, int k) const {
        const std::vector<int>& edges = components_.balls()[at(k)].vertices;
        Eigen::Matrix3Xd part(3, std::ssize(edges));
        for (std::size_t n = 0; n < edges.size(); ++n) {
            part.col(static_cast<Index>(n)) = turns[at(edges[n])];
        }
        return part;
    }
    static void add(Parts& to, double factor, const Parts& parts) {
        for (std::size_t k = 0; k < to.size(); ++k) to[k] += factor * parts[k];
    }
    Parts preconditioned(Parts parts) const {
        for (std::size_t k = 0; k < parts.size(); ++k) {
            const double square = gram_(static_cast<Index>(k), static_cast<Index>(k));
            if (square > 0) parts[k] /= square;
        }
        return parts;
    }
    /// (W + μ w) B G on the balls.
    Parts applied(const Parts& parts) const {
        Parts applied(parts.size());
        parallel_for(std::ssize(parts), [&](std::int64_t l) {
            EdgeTurns sum(at(field_.edge_count()), Vector3d::Zero());
            for (std::size_t k = 0; k < parts.size(); ++k) {
                const std::vector<int>& edges = components_.balls()[k].vertices;
                const double factor = gram_(static_cast<Index>(k), l);
                for (std::size_t n = 0; n < edges.size(); ++n) {
                    sum[at(edges[n])] += factor * parts[k].col(static_cast<Index>(n));
                }
            }
            applied[at(l)] = local_ * on_ball(sum, static_cast<int>(l)) +
                             on_ball(field_.shared_out(field_.added_up(sum)), static_cast<int>(l));
        });
        return applied;
    }

    const TurnField& field_;
    const BallComponents& components_;
    MatrixXd gram_;  // of codes
    Parts sides_;
    double local_ = 0;
};

}  // namespace

BallComponents fitted_to_carry(const TurnField& field, const MetricRows& turns,
                               const MatrixXd& codes, BallComponents start) {
    const CarriedFit fit(field, turns, codes, start);
    Parts parts;
    for (int k = 0; k < start.count(); ++k) {
        const std::vector<float> values = start.component(k);
        parts.emplace_back(
            Eigen::Map<const Eigen::Matrix3Xf>(values.data(), 3, std::ssize(values) / 3)
                .cast<double>());
    }
    parts = fit.solved(std::move(parts));
    for (int k = 0; k < start.count(); ++k) {
        const Eigen::Matrix3Xf values = parts[at(k)].cast<float>();
        start.set_component(k, std::span(values.data(), at(values.size())));
    }
    return start;
}

}  // namespace mscomp
