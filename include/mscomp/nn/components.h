// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "mscomp/base/distance_rows.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/nn/config.h"
#include "nn/model.h"

namespace mscomp::nn {

/// One deformation component of a trained model.
struct Component {
    std::string id;  // path from the coarsest level: "3" is component 3 of level 0, "3.1" its child
    int level = 0;
    std::string parent;                 // id of the component one level coarser, empty at level 0
    int code = 0;                       // its entry among all codes (code_decoder.h)
    int autoencoder = 0;                // within the level
    int index = 0;                      // within the autoencoder
    int center = 0;                     // vertex its support lies around
    int longest = 0;                    // vertex where the component weights are longest
    double code_min = 0, code_max = 0;  // over the training shapes
    double code_reference = 0;          // code of the reference
    double code_end = 0;                // the end (min or max) that moves the shape more
    double code_other = 0;              // the other end
    double strength = 0;                // I(X) of [A] eq. 7, unscaled features
    double distance = 0;                // |difference|, how far the end is from the reference ([B]
                                        // §5.1): the order of components
    bool kept = true;
    std::string reason;  // why it was dropped, empty if kept
    int support = 0;     // vertices with component weights that are not exactly zero
    int moving = 0;  // vertices whose features change at all: the support and one ring around it
    double localization_radius = 0;  // largest normalised geodesic distance from the centre, over
                                     // the vertices where the difference exceeds epsilon_1
    std::vector<float>
        difference;  // (V,9) unscaled features at code_end minus those at code_reference
    std::vector<float> other_difference;  // the same at code_other
};

/// All components, coarse to fine, in the order of their ids. `codes` are the codes of the training
/// shapes per level (n, A*K), `factor` the scaler's (scaled = (feature - offset) factor). A
/// component's features are X_r + Dec(z_end) - Dec(z_r) with the reference code z_r except for its
/// own entry (method §4, analysis). `reference` are the scaled features of the reference, (V,9).
std::vector<Component> extract_components(Model<float>& model,
                                          const std::vector<std::vector<float>>& codes,
                                          std::span<const float> reference,
                                          const std::array<double, kFeatureDim>& factor,
                                          const FilterConfig& filter, DistanceRows& distances);

/// Where each component of `components` comes in the order of analysis: coarse to fine, within a
/// level the one whose end is farthest from the reference first, as listed where they are equal.
std::vector<int> strongest_first(const std::vector<Component>& components);

/// Unscaled features (V,9) at `codes` minus those whose scaled features are `base`.
std::vector<float> feature_change(const CodeDecoder& decoder, std::span<const float> codes,
                                  std::span<const float> base,
                                  const std::array<double, kFeatureDim>& factor);

/// Mean share of the vertices that the components of `level` act on (kept and dropped alike).
double mean_support(const std::vector<Component>& components, int level, int vertex_count);

}  // namespace mscomp::nn
