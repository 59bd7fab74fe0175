// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mscomp/base/distance_rows.h"
#include "mscomp/multiscale/multiscale.h"
#include "multiscale/ball_model.h"
#include "multiscale/space_descent.h"

namespace mscomp {

/// Components on balls of the sizes that the settings say, and before them some global ones.
class MultiscaleModel final : public BallModel {
  public:
    /// Borrows place and what it borrows as long as training goes on; without components yet.
    MultiscaleModel(const Config& config, const ModelPlace& place);

    std::vector<LevelSize> levels() const override;

    std::unique_ptr<Learner> learner(const ShapeSet& shapes, std::span<const int> train) override;
    void save(StoredArrays& arrays) const override;
    void load(const SafetensorsFile& file) override;

    /// Those of the levels, and before them any number of global ones. Codes that were made for the
    /// components before are forgotten.
    void set_components(BallComponents components);
    /// Of a training that has come to descent in space; saved with the components.
    std::optional<SpaceState> space_state;
    /// How far training fills up the shapes; saved likewise.
    int fill_up_to = 0;

  private:
    bool has_global_level() const override { return global_count_ > 0; }
    std::optional<SpaceState> load_space_state(const SafetensorsFile& file) const;
    int local_count() const;

    const std::string weights_;
    const TrainConfig train_;
    const MultiscaleSettings settings_;
    DistanceRows& distances_;
    int global_count_;
};

}  // namespace mscomp
