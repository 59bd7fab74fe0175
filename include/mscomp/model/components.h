// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mscomp/base/distance_rows.h"
#include "mscomp/base/metric_scale.h"
#include "mscomp/model/config.h"
#include "mscomp/model/shape_model.h"

namespace mscomp {

/// A code that moves along with another one.
struct FollowingCode {
    int code = 0;
    double ratio = 0;  // how far it goes where that one goes by 1
};

/// One deformation component of a trained model.
struct Component {
    std::string id;  // path from the coarsest level: "3" is component 3 of level 0, "3.1" its child
    int level = 0;
    std::string parent;                 // id of the component one level coarser, empty at level 0
    int code = 0;                       // its entry among all codes
    int index = 0;                      // among those of its level with the same parent
    int center = 0;                     // vertex its support lies around
    int longest = 0;                    // vertex where the component weights are longest
    double code_min = 0, code_max = 0;  // over the training shapes
    double code_reference = 0;          // code of the reference
    double code_end = 0;                // the end (min or max) that moves the shape more
    double code_other = 0;              // the other end
    double strength = 0;                // I(X) of [A] eq. 7
    double distance = 0;                // |difference|, how far the end is from the reference ([B]
                                        // §5.1): the order of components
    bool kept = true;
    std::string reason;  // why it was dropped or merged, empty if kept
    /// What is lost without it, the codes of the others refitted, as a share of the squares that
    /// the training shapes move: beside all that are kept; of those dropped or merged, when they
    /// were.
    double cost = 0;
    std::string merged_into;  // id of the component that stands for it, too; empty: none does
    std::vector<FollowingCode> others;  // codes of those that were merged into this one; its range,
                                        // ends and all that follows from them are of all together
    std::vector<double> reading;  // (K) of a kept one: what all codes, counted from those of the
                                  // reference, make its code where only kept ones act
    int support = 0;  // vertices with component weights that are not exactly zero; where others
                      // were merged into it, vertices whose rows change
    int moving = 0;   // vertices whose rows change at all: the support and what the convolution
                      // of the decoder sees around it
    double localization_radius = 0;  // largest normalised geodesic distance from the centre, over
                                     // the vertices where the difference exceeds epsilon_1
    std::optional<ComponentTrust> trust;  // where the method says how sure it is
    std::vector<float>
        difference;  // rows (ShapeModel::rows) at code_end minus those at code_reference
    std::vector<float> other_difference;  // the same at code_other
};

/// Puts a component at `code`, with the codes that move along with it; `codes` (K) hold those of
/// the reference, or what other components have made of them.
void put_at(std::span<float> codes, const Component& component, float code);

/// All components, coarse to fine, in the order of their ids. `codes` are those of the training
/// shapes; the filter counts errors of features as `metric` scales them, beside `squared_error`,
/// that of the model (ModelContext), none: not known. A component's rows are those of the reference
/// plus Dec(z_end) - Dec(z_r), with the reference code z_r except for its own entry (method §4,
/// analysis). Strength and distance are in the unit of the model.
std::vector<Component> extract_components(ShapeModel& model, const CodeTable& codes,
                                          const FilterConfig& filter, DistanceRows& distances,
                                          const MetricScale& metric = {},
                                          std::optional<double> squared_error = {});

/// The one ranking of components, [B] §5.1: the one whose end is farthest from the reference first,
/// as listed where they are equal.
std::vector<int> farthest_first(const std::vector<Component>& components);

/// Where each component of `components` comes in the order of analysis: coarse to fine, within a
/// level the one whose end is farthest from the reference first, as listed where they are equal.
std::vector<int> strongest_first(const std::vector<Component>& components);

/// Mean share of the vertices that the components of `level` act on (kept and dropped alike).
double mean_support(const std::vector<Component>& components, int level, int vertex_count);
/// The same of the kept components of all levels.
double mean_support_of_kept(const std::vector<Component>& components, int vertex_count);

}  // namespace mscomp
