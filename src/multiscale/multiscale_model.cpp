// SPDX-License-Identifier: MIT
#include "multiscale/multiscale_model.h"

#include <utility>

#include "multiscale/multiscale_learner.h"

namespace mscomp {
MultiscaleModel::MultiscaleModel(const Config& config, const ModelPlace& place)
    : BallModel(place.reference, RowMap(place.scale)),
      weights_(place.weights),
      train_(config.train),
      settings_(config.own<MultiscaleSettings>()),
      distances_(place.distances),
      global_count_(settings_.global_components) {
    set_components(
        BallComponents(vertex_count(), std::vector<Ball>(at(global_count_ + local_count()))));
}

int MultiscaleModel::local_count() const {
    int count = 0;
    for (const BallLevel& level : settings_.levels) count += level.components;
    return count;
}

std::vector<LevelSize> MultiscaleModel::levels() const {
    std::vector<LevelSize> sizes;
    if (global_count_ > 0) sizes.push_back({1, global_count_});
    for (const BallLevel& level : settings_.levels) sizes.push_back({1, level.components});
    return sizes;
}

void MultiscaleModel::set_components(BallComponents components) {
    global_count_ = components.count() - local_count();
    set_balls(std::move(components));
}

std::unique_ptr<Learner> MultiscaleModel::learner(const ShapeSet& shapes,
                                                  std::span<const int> train) {
    return std::make_unique<MultiscaleLearner>(
        *this, settings_, train_, LearnerPlace{reference(), weights_, distances_}, shapes, train);
}

}  // namespace mscomp
