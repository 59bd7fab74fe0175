// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

namespace mscomp {

/// What the shapes of a generated set are made of (docs/generated-data.md).
struct TrueComponents {
    std::vector<std::string> names;   // (U) at least one, all differently
    std::vector<int> scales;          // (U) 0 coarse, 1 fine
    std::vector<std::string> frames;  // (N) names of the shapes, all differently
    std::vector<double> weights;      // (N,U)

    int count() const { return static_cast<int>(names.size()); }
};

/// Of a truth.json: an object with the lists `names`, `scales`, `frames` and `weights`; other keys
/// are passed over. Throws IoError, or InputError with what is wrong and where.
TrueComponents read_true_components(const std::string& path);

/// Weights (n,U) of the shapes `names` (n) of the feature file `features`, in their order, each by
/// its name. Throws InputError naming the truth for a shape that it does not know.
std::vector<double> weights_of_shapes(const TrueComponents& truth, const std::string& path,
                                      const std::vector<std::string>& names,
                                      const std::string& features);

/// The file of the supports that belongs to a truth: truth.json -> truth_supports.safetensors.
std::string true_supports_path(const std::string& truth_path);

/// "supports" (U,V) f32 in [0, 1] for the components `names` (U) and a mesh of V vertices. Throws
/// IoError, or InputError: no sound file, another shape, numbers out of range, names of other
/// components.
std::vector<float> read_true_supports(const std::string& path,
                                      const std::vector<std::string>& names, int vertex_count);

}  // namespace mscomp
