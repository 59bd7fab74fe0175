// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mscomp/base/distance_rows.h"
#include "mscomp/model/config.h"
#include "mscomp/model/shape_model.h"

namespace mscomp {

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
    std::string reason;  // why it was dropped, empty if kept
    int support = 0;     // vertices with component weights that are not exactly zero
    int moving = 0;      // vertices whose rows change at all: the support and what the convolution
                         // of the decoder sees around it
    double localization_radius = 0;  // largest normalised geodesic distance from the centre, over
                                     // the vertices where the difference exceeds epsilon_1
    std::optional<ComponentTrust> trust;  // where the method says how sure it is
    std::vector<float>
        difference;  // rows (ShapeModel::rows) at code_end minus those at code_reference
    std::vector<float> other_difference;  // the same at code_other
};

/// All components, coarse to fine, in the order of their ids. `codes` are those of the training
/// shapes. A component's rows are those of the reference plus Dec(z_end) - Dec(z_r), with the
/// reference code z_r except for its own entry (method §4, analysis). Strength and distance are in
/// the unit of the model.
std::vector<Component> extract_components(ShapeModel& model, const CodeTable& codes,
                                          const FilterConfig& filter, DistanceRows& distances);

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
