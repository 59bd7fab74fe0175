// SPDX-License-Identifier: MIT
// What a multiscale model keeps in a model file beside its components.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "mscomp/base/error.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/safetensors.h"
#include "mscomp/model/stored_arrays.h"
#include "multiscale/multiscale_model.h"

namespace mscomp {
namespace {

constexpr const char* kSpaceCodes = "space/codes";  // (shapes,K)
constexpr const char* kMoment1 = "space/adam_m";    // in the order of the vertices
constexpr const char* kMoment2 = "space/adam_v";
constexpr const char* kSteps = "space/steps";
constexpr const char* kFillUpTo = "training/fill_up_to";

}  // namespace

/// None for a file without.
std::optional<SpaceState> MultiscaleModel::load_space_state(const SafetensorsFile& file) const {
    if (!file.contains(kSpaceCodes)) return std::nullopt;
    const auto entries = static_cast<std::int64_t>(components().all_values().size()) / kFeatureDim;
    const auto codes = file.data<double>(kSpaceCodes, {-1, code_count()});
    const auto moment1 = file.data<float>(kMoment1, {entries, kFeatureDim});
    const auto moment2 = file.data<float>(kMoment2, {entries, kFeatureDim});
    const auto steps = file.data<std::int64_t>(kSteps, {1});
    const bool is_sound = !codes.empty() && steps[0] >= 0 &&
                          std::ranges::none_of(moment2, [](float x) { return x < 0; });
    if (!is_sound) throw CheckpointError(file.path(), "a state in space that no training leaves");
    return SpaceState{
        Eigen::Map<const Eigen::MatrixXd>(codes.data(), code_count(),
                                          static_cast<Eigen::Index>(codes.size()) / code_count()),
        {moment1.begin(), moment1.end()},
        {moment2.begin(), moment2.end()},
        steps[0]};
}

void MultiscaleModel::save(StoredArrays& arrays) const {
    save_balls(arrays);
    arrays.keep<int>(kFillUpTo, {1}, {fill_up_to});
    if (!space_state) return;
    const auto entries = static_cast<std::int64_t>(components().all_values().size()) / kFeatureDim;
    const Eigen::MatrixXd& codes = space_state->codes;
    arrays.keep<double>(kSpaceCodes, {codes.cols(), codes.rows()},
                        {codes.data(), codes.data() + codes.size()});
    arrays.keep<float>(kMoment1, {entries, kFeatureDim}, space_state->moment1);
    arrays.keep<float>(kMoment2, {entries, kFeatureDim}, space_state->moment2);
    arrays.keep<std::int64_t>(kSteps, {1}, {space_state->steps});
}

void MultiscaleModel::load(const SafetensorsFile& file) {
    BallComponents components = load_balls(file);
    const int count = components.count();
    if (count < local_count() || count > local_count() + settings_.global_components) {
        throw CheckpointError(
            file.path(), fmt::format("{} components, wanted {} and up to {} global ones", count,
                                     local_count(), settings_.global_components));
    }
    set_components(std::move(components));
    set_parents(load_parents(file));
    space_state = load_space_state(file);
    fill_up_to = file.data<int>(kFillUpTo, {1})[0];
    if (fill_up_to < 0 || fill_up_to > kMostFilledUpTo) {
        throw CheckpointError(file.path(), fmt::format("filled up to {} shapes", fill_up_to));
    }
}

}  // namespace mscomp
