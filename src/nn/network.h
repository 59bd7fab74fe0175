// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "mscomp/base/metric_scale.h"
#include "mscomp/model/config.h"
#include "mscomp/model/learned_model.h"
#include "nn/code_decoder.h"
#include "nn/model.h"

namespace mscomp::nn {

/// A network as a model with components: what it scales, batches and renumbers stays inside. The
/// reference is r = 0, S = I at every vertex.
class Network : public LearnedModel {
  public:
    enum class Prior { none, normal };
    Network(std::unique_ptr<Model<float>> model, const MetricScale& scale, const TrainConfig& train,
            Prior prior = Prior::none);
    /// Borrows the model.
    Network(Model<float>& model, const MetricScale& scale, const TrainConfig& train = {});

    ShapeRows rows() const override { return ShapeRows::features; }
    int vertex_count() const override { return model_.vertex_count(); }
    std::vector<LevelSize> levels() const override { return model_.level_sizes(); }
    bool refines_components() const override { return model_.refines_components(); }
    bool has_prior() const override { return prior_ == Prior::normal; }

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

    Model<float>& model() { return model_; }
    /// Parameters have changed: what was derived from them is forgotten.
    void forget_decoder();

  private:
    /// Scaled features that some codes decode to.
    struct Decoded {
        std::vector<float> codes, features;
    };
    std::shared_ptr<const CodeDecoder> decoder() const;
    std::shared_ptr<const Decoded> decoded(std::span<const float> codes) const;

    std::unique_ptr<Model<float>> owned_;
    Model<float>& model_;
    MetricScale scale_;
    TrainConfig train_;
    Prior prior_ = Prior::none;
    mutable std::mutex mutex_;  // of these, which are made when first needed
    mutable std::shared_ptr<const CodeDecoder> decoder_;
    mutable std::shared_ptr<const Decoded> last_decoded_;
};

}  // namespace mscomp::nn
