// SPDX-License-Identifier: MIT
#include "mscomp/eval/sted.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/points.h"
#include "mscomp/eval/measures.h"

namespace mscomp {
namespace {

double distance(const Point& p, const Point& q) { return std::sqrt(square_distance(p, q)); }

/// s(v,f) over the edges of one vertex, none where no edge has a length.
class EdgeDeviation {
  public:
    void clear() { edges_.clear(); }
    void add(double truth, double result) {
        if (truth == 0) return;
        edges_.push_back({truth, std::abs(result - truth) / truth});
    }
    std::optional<double> value() const {
        if (edges_.empty()) return std::nullopt;
        double weight = 0, mean = 0, squares = 0;
        for (const Edge& edge : edges_) {
            weight += edge.length;
            mean += edge.length * edge.change;
        }
        mean /= weight;
        for (const Edge& edge : edges_) {
            squares += edge.length * (edge.change - mean) * (edge.change - mean);
        }
        return std::sqrt(squares / weight);
    }

  private:
    struct Edge {
        double length, change;
    };
    std::vector<Edge> edges_;
};

}  // namespace

Sted::Sted(const TriangleMesh& reference, ShapeOrder order, const StedOptions& options)
    : rings_(one_rings_of_faces(reference.vertex_count(), reference.faces)),
      scale_(unit_ball_scale(reference.vertices)),
      order_(order),
      options_(options) {
    if (reference.vertices.empty()) throw MeshError("STED of a reference without vertices");
    if (options.window < 0 || !(options.dt > 0) || !(options.temporal_weight >= 0)) {
        throw UsageError(fmt::format(
            "STED: window {}, dt {}, temporal weight {}; wanted at least 0, above 0, at least 0",
            options.window, options.dt, options.temporal_weight));
    }
}

void Sted::add(const std::vector<Point>& truth, const std::vector<Point>& result) {
    if (static_cast<int>(truth.size()) != rings_.vertex_count()) {
        throw MeshError(fmt::format("STED of a shape of {} vertices, the reference has {}",
                                    truth.size(), rings_.vertex_count()));
    }
    std::vector<Point> aligned = aligned_to(truth, result);
    EdgeDeviation deviation;
    for (std::size_t v = 0; v < truth.size(); ++v) {
        deviation.clear();
        for (int e = rings_.offsets[v]; e < rings_.offsets[v + 1]; ++e) {
            const auto other = at(rings_.neighbors[at(e)]);
            deviation.add(distance(truth[v], truth[other]), distance(aligned[v], aligned[other]));
        }
        const std::optional<double> value = deviation.value();
        deviations_ += value.value_or(0);
        deviation_count_ += value ? 1 : 0;
    }
    if (order_ == ShapeOrder::set) return;
    if (!truth_before_.empty()) add_step(truth, aligned);
    truth_before_ = truth;
    aligned_before_ = std::move(aligned);
}

void Sted::add_step(const std::vector<Point>& truth, const std::vector<Point>& aligned) {
    const auto length = [this](const Point& from, const Point& to) {
        return std::hypot(scale_ * distance(from, to), options_.dt);
    };
    Step step;
    for (std::size_t v = 0; v < truth.size(); ++v) {
        const double wanted = length(truth_before_[v], truth[v]);
        step.length.push_back(wanted);
        step.difference.push_back(std::abs(length(aligned_before_[v], aligned[v]) - wanted));
    }
    recent_.push_back(std::move(step));
    ++step_count_;
    for (; done_ + options_.window < step_count_; ++done_) changes_ += change_in(done_);
    for (; first_recent_ < done_ - options_.window; ++first_recent_) recent_.pop_front();
}

/// Σ_v |t'(v,f) - t(v,f)| / M(v,f) over the steps known so far.
double Sted::change_in(int step) const {
    const int begin = std::max(0, step - options_.window);
    const int end = std::min(step_count_, step + options_.window + 1);
    const auto recent = [this](int index) -> const Step& {
        return recent_[at(index - first_recent_)];
    };
    double sum = 0;
    for (std::size_t v = 0; v < truth_before_.size(); ++v) {
        double lengths = 0;
        for (int g = begin; g < end; ++g) lengths += recent(g).length[v];
        sum += recent(step).difference[v] * (end - begin) / lengths;
    }
    return sum;
}

StedError Sted::value() const {
    StedError error;
    error.spatial = deviation_count_ > 0 ? deviations_ / deviation_count_
                                         : std::numeric_limits<double>::quiet_NaN();
    if (step_count_ == 0) return error;
    double changes = changes_;
    for (int step = done_; step < step_count_; ++step) changes += change_in(step);
    error.temporal =
        changes / (static_cast<double>(step_count_) * static_cast<double>(rings_.vertex_count()));
    error.value = std::hypot(error.spatial, options_.temporal_weight * *error.temporal);
    return error;
}

}  // namespace mscomp
