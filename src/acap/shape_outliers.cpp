// SPDX-License-Identifier: MIT
#include "mscomp/acap/shape_outliers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <mutex>

#include "check/check_edges.h"
#include "check/pinched_rings.h"
#include "check/stretch_histogram.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

double stretch_of(std::span<const float> feature) {
    double largest = 0;
    for (std::size_t k = kRotationDim; k < at(kFeatureDim); ++k) {
        largest = std::max(largest, std::abs(static_cast<double>(feature[k]) -
                                             static_cast<double>(kReferenceFeature[k])));
    }
    return largest;
}

}  // namespace

struct ShapeOutliers::State {
    /// What is kept of one shape.
    struct ShapeFacts {
        bool permuted = false, other_size = false;
        double largest_stretch = 0;  // |S - I|
        bool opens_a_pinch = false;  // there
    };

    State(const TriangleMesh& surface, int shape_count)
        : reference(surface.vertices),
          rings(one_rings_of_faces(surface.vertex_count(), surface.faces)),
          edges(reference, rings),
          pinch(reference, rings),
          shapes(at(shape_count)) {}
    State(const State&) = delete;
    State& operator=(const State&) = delete;

    /// "n of N shapes (first: 'name')" of those for which `is_odd`; empty without one.
    std::string shapes_where(const std::vector<std::string>& names,
                             const std::function<bool(const ShapeFacts&)>& is_odd) const {
        const auto first = std::ranges::find_if(shapes, is_odd);
        if (first == shapes.end()) return {};
        return fmt::format("{} of {} shapes (first: '{}')", std::ranges::count_if(shapes, is_odd),
                           shapes.size(), names[at(first - shapes.begin())]);
    }

    std::vector<Point> reference;
    OneRings rings;
    EdgeStretchTest edges;
    PinchedRings pinch;
    std::vector<ShapeFacts> shapes;
    std::mutex mutex;
    StretchHistogram stretches;
};

ShapeOutliers::ShapeOutliers(const TriangleMesh& surface, int shape_count)
    : state_(std::make_unique<State>(surface, shape_count)) {}
ShapeOutliers::~ShapeOutliers() = default;

void ShapeOutliers::look_at(int index, const std::vector<Point>& positions,
                            std::span<const float> features) {
    const EdgeStretch edges = state_->edges.compare(positions);
    State::ShapeFacts& facts = state_->shapes[at(index)];
    facts = {edges.permuted, edges.is_other_unit()};
    StretchHistogram own;
    int vertex = -1;
    for (std::size_t v = 0; v < positions.size(); ++v) {
        const double stretch = stretch_of(features.subspan(v * kFeatureDim, kFeatureDim));
        own.add(stretch);
        if (!(stretch > facts.largest_stretch)) continue;
        facts.largest_stretch = stretch;
        vertex = static_cast<int>(v);
    }
    facts.opens_a_pinch =
        vertex >= 0 && state_->pinch.opens_a_pinch(positions, vertex, edges.median_ratio);
    const std::lock_guard<std::mutex> lock(state_->mutex);
    state_->stretches.add(own);
}

std::vector<std::string> ShapeOutliers::warnings(const std::vector<std::string>& names) const {
    std::vector<std::string> result;
    const auto warn = [&](const std::string& shapes, std::string_view what) {
        if (!shapes.empty()) result.push_back(shapes + " " + std::string(what));
    };
    warn(state_->shapes_where(names, [](const State::ShapeFacts& s) { return s.permuted; }),
         "seem to have their vertices in another order than the reference: 'acapfeat check' says "
         "where");
    warn(state_->shapes_where(names, [](const State::ShapeFacts& s) { return s.other_size; }),
         "have another size than the reference, as in another unit: it is taken for deformation");
    const double usual = state_->stretches.quantile(kMostStretches);
    const auto is_outlier = [&](bool opens_a_pinch) {
        return [usual, opens_a_pinch](const State::ShapeFacts& s) {
            return s.opens_a_pinch == opens_a_pinch && is_stretch_outlier(s.largest_stretch, usual);
        };
    };
    warn(state_->shapes_where(names, is_outlier(false)),
         fmt::format("stretch somewhere far more than the {:.3g} that 99.9 % of all vertices stay "
                     "below: one scale serves all, so everything else becomes small",
                     usual));
    warn(state_->shapes_where(names, is_outlier(true)),
         fmt::format("are open where the reference is pinched, and stretch there far more than the "
                     "{:.3g} that 99.9 % of all vertices stay below: one scale serves all; extract "
                     "with another --reference",
                     usual));
    return result;
}

}  // namespace mscomp
