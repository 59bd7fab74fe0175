// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "mscomp/units/units.h"
#include "multiscale/ball_model.h"

namespace mscomp {

/// Units as components of features or of positions, on one level or two.
class UnitModel final : public BallModel {
  public:
    UnitModel(const Config& config, const ModelPlace& place);

    std::vector<LevelSize> levels() const override;
    std::unique_ptr<Learner> learner(const ShapeSet& shapes, std::span<const int> train) override;
    void save(StoredArrays& arrays) const override;
    void load(const SafetensorsFile& file) override;

    /// Votes are read-outs.
    std::vector<ComponentTrust> trust() const override { return trust_; }

    /// `levels` units on each level, in the order of the components.
    void set_units(BallComponents components, std::vector<int> levels,
                   std::vector<ComponentTrust> trust);

  private:
    bool has_global_level() const override { return false; }

    const UnitSettings settings_;
    std::vector<int> levels_{0};
    std::vector<ComponentTrust> trust_;
};

}  // namespace mscomp
