// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mscomp/base/distance_rows.h"
#include "mscomp/base/mesh_data.h"
#include "mscomp/base/metric_scale.h"
#include "mscomp/model/learned_model.h"
#include "mscomp/multiscale/multiscale.h"
#include "multiscale/ball_components.h"
#include "multiscale/joint_codes.h"
#include "multiscale/metric_rows.h"
#include "multiscale/space_descent.h"

namespace mscomp {

/// x = x_ref + Σ_k z_k C_k over the components of all levels, in scaled and weighted features
/// (method §9): exactly the reference where all codes are 0.
class MultiscaleModel final : public LearnedModel {
  public:
    /// Borrows place and what it borrows as long as training goes on; without components yet.
    MultiscaleModel(const Config& config, const ModelPlace& place);

    ShapeRows rows() const override { return ShapeRows::features; }
    int vertex_count() const override { return reference_.vertex_count(); }
    std::vector<LevelSize> levels() const override;
    std::vector<int> parents() const override;

    CodeTable encode(const ShapeSet& shapes, std::span<const int> which) override;
    std::vector<float> reference_codes() override;
    std::vector<float> decode(std::span<const float> codes, int levels = 0) const override;
    std::vector<float> change(std::span<const float> codes,
                              std::span<const float> from) const override;
    std::vector<CodeColumn> derivatives(std::span<const float> codes) const override;
    std::vector<ComponentPlace> places() const override;

    std::unique_ptr<Learner> learner(const ShapeSet& shapes, std::span<const int> train) override;
    void save(StoredArrays& arrays) const override;
    void load(const SafetensorsFile& file) override;

    const MetricScale& scale() const { return scale_; }
    const BallComponents& components() const { return components_; }
    /// Those of the levels, and before them any number of global ones. Codes that were made for the
    /// components before are forgotten.
    void set_components(BallComponents components);
    /// Parents (K) that stay; empty: as overlaps say.
    void set_parents(std::vector<int> parents) { parents_ = std::move(parents); }
    /// Of a training that has come to descent in space; saved with the components.
    std::optional<SpaceState> space_state;
    /// How far training fills up the shapes; saved likewise.
    int fill_up_to = 0;

  private:
    std::optional<SpaceState> load_space_state(const SafetensorsFile& file) const;
    std::vector<int> load_parents(const SafetensorsFile& file) const;
    int local_count() const;
    std::vector<float> sum(std::span<const float> codes, int levels) const;

    const TriangleMesh& reference_;
    const std::string weights_;
    const TrainConfig train_;
    const MultiscaleSettings settings_;
    DistanceRows& distances_;
    MetricScale scale_;
    int global_count_;
    BallComponents components_;
    std::vector<int> parents_;         // of components that were begun with
    std::optional<JointCodes> codes_;  // made when first needed
};

}  // namespace mscomp
