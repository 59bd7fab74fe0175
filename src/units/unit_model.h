// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "mscomp/units/units.h"
#include "multiscale/ball_model.h"

namespace mscomp {

/// Units as components of features, on one level or two.
class UnitModel final : public BallModel {
  public:
    UnitModel(const Config& config, const ModelPlace& place);

    std::vector<LevelSize> levels() const override;
    std::unique_ptr<Learner> learner(const ShapeSet& shapes, std::span<const int> train) override;
    void save(StoredArrays& arrays) const override;
    void load(const SafetensorsFile& file) override;

    /// How sure a unit is: read-outs that agreed on it, and the part of the random subsets of the
    /// shapes in which it was found again.
    struct Trust {
        std::vector<int> votes;     // (K)
        std::vector<double> again;  // (K)
    };
    /// `levels` units on each level, in the order of the components.
    void set_units(BallComponents components, std::vector<int> levels, Trust trust);

  private:
    bool has_global_level() const override { return false; }

    const UnitSettings settings_;
    std::vector<int> levels_{0};
    Trust trust_;
};

}  // namespace mscomp
