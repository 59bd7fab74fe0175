// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "mscomp/units/units.h"
#include "multiscale/ball_model.h"
#include "units/turning_components.h"

namespace mscomp {

/// Units on one level or two.
struct UnitParts {
    BallComponents components;  // of mapped rows; without anything where they turn
    std::vector<int> levels;    // units on each, in the order of the components
    std::vector<ComponentTrust> trust;
    std::optional<TurningComponents> turning;  // where they are of relative rotations
    std::vector<int> parents;                  // empty: as overlaps of components say
};

/// Units as components of features or of positions, or of relative rotations and of stretch, which
/// decode through integrated rotations.
class UnitModel final : public BallModel {
  public:
    UnitModel(const Config& config, const ModelPlace& place);

    std::vector<LevelSize> levels() const override;
    std::unique_ptr<Learner> learner(const ShapeSet& shapes, std::span<const int> train) override;
    void save(StoredArrays& arrays) const override;
    void load(const SafetensorsFile& file) override;

    /// Votes are read-outs.
    std::vector<ComponentTrust> trust() const override { return trust_; }

    CodeTable encode(const ShapeSet& shapes, std::span<const int> which) override;
    std::vector<float> decode(std::span<const float> codes, int levels = 0) const override;
    std::vector<float> change(std::span<const float> codes,
                              std::span<const float> from) const override;
    std::vector<CodeColumn> derivatives(std::span<const float> codes) const override;
    std::vector<ComponentPlace> places() const override;

    void set_units(UnitParts parts);
    bool is_turning() const { return turning_.has_value(); }
    const TriangleMesh& mesh() const { return reference(); }

  private:
    bool has_global_level() const override { return false; }
    std::optional<TurningComponents> load_turning(const SafetensorsFile& file, int count) const;

    const UnitSettings settings_;
    std::vector<int> levels_{0};
    std::vector<ComponentTrust> trust_;
    std::optional<TurningComponents> turning_;
};

}  // namespace mscomp
