// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "mscomp/model/components.h"
#include "mscomp/model/shape_model.h"

namespace mscomp {

/// A model of which only the components that a filter keeps act, each with those that were merged
/// into it; all other codes stay at those of the reference. Codes are those of the kept ones, in
/// their order. Borrows the model.
class KeptModel final : public ShapeModel {
  public:
    /// Of all components of the model, as extract_components gives them. Throws UsageError where
    /// none is kept.
    KeptModel(ShapeModel& model, const std::vector<Component>& components);

    /// The kept components as this model has them: each moves its own code.
    const std::vector<Component>& components() const { return components_; }
    /// Codes (n,kept) of what codes (n,K) of the model are for the kept ones: refitted, so that
    /// what they give is as near as can be, where decoding is linear, to what all give.
    CodeTable refitted(const CodeTable& codes) const;

    ShapeRows rows() const override { return model_.rows(); }
    int vertex_count() const override { return model_.vertex_count(); }
    std::vector<LevelSize> levels() const override;
    bool refines_components() const override { return model_.refines_components(); }
    std::vector<int> parents() const override;
    /// The codes of the model, refitted.
    CodeTable encode(const ShapeSet& shapes, std::span<const int> which) override;
    std::vector<float> reference_codes() override { return reference_; }
    std::vector<float> decode(std::span<const float> codes, int levels = 0) const override;
    std::vector<float> change(std::span<const float> codes,
                              std::span<const float> from) const override;
    std::vector<CodeColumn> derivatives(std::span<const float> codes) const override;
    std::vector<ComponentPlace> places() const override;
    std::vector<ComponentTrust> trust() const override;
    double unit() const override { return model_.unit(); }

  private:
    std::vector<float> all_codes(std::span<const float> codes) const;

    ShapeModel& model_;
    std::vector<Component> acting_;      // the kept ones as the model has them
    std::vector<Component> components_;  // and as this one does
    std::vector<float> reference_;       // codes (kept)
    std::vector<float> all_reference_;   // codes (K) of the model
};

}  // namespace mscomp
