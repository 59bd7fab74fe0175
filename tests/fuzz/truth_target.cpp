// SPDX-License-Identifier: MIT
// The two files that say what a generated set is made of.
#include <array>
#include <cmath>
#include <set>

#include "fuzz/memory_file.h"
#include "fuzz/promises.h"
#include "fuzz/targets.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "mscomp/eval/support_overlap.h"
#include "report/true_components.h"

namespace mscomp::fuzz {
namespace {

void require_distinct(const std::vector<std::string>& names) {
    require(
        !names.empty() && std::set<std::string>(names.begin(), names.end()).size() == names.size(),
        "there are names, all different");
}

}  // namespace

void check_truth(std::span<const std::byte> input) {
    static const MemoryFile memory;
    const std::string path = memory.filled_with(input);
    const auto truth = unless_refused(path, [&] { return read_true_components(path); });
    if (!truth) return;
    require_distinct(truth->names);
    require_distinct(truth->frames);
    require(truth->scales.size() == truth->names.size(), "every component has a scale");
    for (const int scale : truth->scales) require(scale == 0 || scale == 1, "there are two scales");
    require(truth->weights.size() == truth->names.size() * truth->frames.size(),
            "every frame has all weights");
    for (const double w : truth->weights) require(std::isfinite(w), "weights are finite");
    require(weights_of_shapes(*truth, path, truth->frames, "features") == truth->weights,
            "frames are found by their names");
    std::vector<std::string> others = truth->frames;
    others.push_back("no such frame");
    unless_refused(path, [&] { return weights_of_shapes(*truth, path, others, "features"); });
}

void check_supports(std::span<const std::byte> input) {
    constexpr int kVertexCount = 4;
    static const MemoryFile memory;
    const std::string path = memory.filled_with(input);
    const auto supports = unless_refused(path, [&] {
        return read_true_supports(path, {"a", "b"}, kVertexCount);
    });
    if (!supports) return;
    require(supports->size() == 2 * at(kVertexCount), "every component has a support");
    for (const float x : *supports) require(x >= 0 && x <= 1, "supports are from 0 to 1");
    std::array<float, at(kVertexCount) * at(kFeatureDim)> change{};
    for (std::size_t i = 0; i < change.size(); ++i) change[i] = static_cast<float>(i % 7);
    const std::array<std::span<const float>, 1> changes{change};
    for (const SupportOverlap& overlap :
         support_matches(changes, *supports, kVertexCount).overlaps) {
        require(overlap.iou >= 0 && overlap.iou <= 1, "overlaps are from 0 to 1");
        require(overlap.soft_iou >= 0 && overlap.soft_iou <= 1, "overlaps are from 0 to 1");
    }
}

}  // namespace mscomp::fuzz
