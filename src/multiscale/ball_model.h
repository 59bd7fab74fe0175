// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mscomp/base/mesh_data.h"
#include "mscomp/model/learned_model.h"
#include "multiscale/ball_components.h"
#include "multiscale/joint_codes.h"
#include "multiscale/row_map.h"

namespace mscomp {

/// Components as arrays of a model file whose names begin with `prefix`, and back.
void keep_components(const std::string& prefix, const BallComponents& components,
                     StoredArrays& arrays);
/// Throws CheckpointError.
BallComponents stored_components(const SafetensorsFile& file, const std::string& prefix,
                                 int vertex_count, int width);

/// x = x_ref + Σ_k z_k C_k over the components of all levels, in mapped rows (row_map.h; method
/// §9), with joint codes: exactly the reference where all codes are 0. How components are found,
/// and which levels they are on, is for others to say.
class BallModel : public LearnedModel {
  public:
    ShapeRows rows() const override { return map_.rows(); }
    int vertex_count() const override { return reference_.vertex_count(); }
    /// Those set, or the one of the level above that a component overlaps most.
    std::vector<int> parents() const override;

    CodeTable encode(const ShapeSet& shapes, std::span<const int> which) override;
    std::vector<float> reference_codes() override;
    std::vector<float> decode(std::span<const float> codes, int levels = 0) const override;
    std::vector<float> change(std::span<const float> codes,
                              std::span<const float> from) const override;
    std::vector<CodeColumn> derivatives(std::span<const float> codes) const override;
    std::vector<ComponentPlace> places() const override;

    double unit() const override { return map_.unit(); }

    const RowMap& map() const { return map_; }
    const MetricScale& scale() const { return map_.scale(); }
    const BallComponents& components() const { return components_; }
    /// Parents (K) that stay; empty: as overlaps say.
    void set_parents(std::vector<int> parents) { parents_ = std::move(parents); }

  protected:
    /// Borrows the reference; without components yet.
    BallModel(const TriangleMesh& reference, RowMap map)
        : reference_(reference), map_(std::move(map)) {}

    /// Whether the first level is of components without a limit, which are no parents.
    virtual bool has_global_level() const = 0;
    const TriangleMesh& reference() const { return reference_; }
    /// How many codes the first `levels` levels have, 0 meaning all.
    int codes_of_levels(int levels) const;
    void set_balls(BallComponents components);
    /// Components and parents as arrays of a model file, and back.
    void save_balls(StoredArrays& arrays) const;
    /// Throws CheckpointError; parents are checked against the levels by load_parents().
    BallComponents load_balls(const SafetensorsFile& file) const;
    std::vector<int> load_parents(const SafetensorsFile& file) const;

  private:
    std::vector<float> sum(std::span<const float> codes, int levels) const;

    const TriangleMesh& reference_;
    RowMap map_;
    BallComponents components_;
    std::vector<int> parents_;         // of components that were begun with
    std::optional<JointCodes> codes_;  // made when first needed
};

}  // namespace mscomp
