// SPDX-License-Identifier: MIT
#include "nn/network.h"

#include <algorithm>
#include <array>
#include <utility>

#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "nn/trainer.h"

namespace mscomp::nn {
namespace {

/// The training of a network, which forgets what was derived from earlier parameters.
class NetworkLearner final : public Learner {
  public:
    NetworkLearner(Network& network, const TrainConfig& train, const ScaledFeatures& features,
                   std::span<const int> shapes)
        : network_(network), trainer_(network.model(), train, features, shapes) {}

    std::vector<std::string> term_names() const override { return network_.model().term_names(); }
    void start() override {
        network_.forget_decoder();
        trainer_.start();
    }
    void resume(const TrainingState& state) override { trainer_.resume(state); }
    const TrainingState& state() const override { return trainer_.state(); }
    EpochReport run_epoch() override {
        network_.forget_decoder();
        return trainer_.run_epoch();
    }
    bool is_over() const override { return trainer_.is_over(); }
    CodeTable codes() override { return trainer_.codes(); }

  private:
    Network& network_;
    Trainer trainer_;
};

/// Where the component weights (V,d) of one component are.
ComponentPlace place_of(int center, std::span<const float> weights, int vertices) {
    ComponentPlace place;
    place.center = center;
    const std::size_t width = weights.size() / at(vertices);
    double largest = 0;
    for (int v = 0; v < vertices; ++v) {
        double square = 0;
        for (const float x : weights.subspan(at(v) * width, width)) {
            square += static_cast<double>(x) * static_cast<double>(x);
        }
        if (square > 0) ++place.support;
        if (square > largest) {
            largest = square;
            place.longest = v;
        }
    }
    return place;
}

}  // namespace

Network::Network(std::unique_ptr<Model<float>> model, const MetricScale& scale,
                 const TrainConfig& train, Prior prior)
    : owned_(std::move(model)), model_(*owned_), scale_(scale), train_(train), prior_(prior) {}

Network::Network(Model<float>& model, const MetricScale& scale, const TrainConfig& train)
    : model_(model), scale_(scale), train_(train) {}

CodeTable Network::encode(const ShapeSet& shapes, std::span<const int> which) {
    CodeTable table{code_count(), {}};
    const auto capacity = at(model_.batch_capacity());
    for (std::size_t first = 0; first < which.size(); first += capacity) {
        const auto batch = which.subspan(first, std::min(capacity, which.size() - first));
        model_.load_batch(ScaledFeatures{shapes, scale_}, batch);
        model_.forward();
        const std::vector<float> codes = model_.all_codes();
        table.values.insert(table.values.end(), codes.begin(), codes.end());
    }
    return table;
}

std::vector<float> Network::reference_codes() {
    std::vector<float> reference;
    for (int v = 0; v < vertex_count(); ++v) {
        reference.insert(reference.end(), kReferenceFeature.begin(), kReferenceFeature.end());
    }
    scale_.scale(reference);
    const std::array<int, 1> first{0};
    model_.load_batch(std::span<const float>(reference), std::span<const int>(first));
    model_.forward();
    return model_.all_codes();
}

std::vector<float> Network::decode(std::span<const float> codes, int levels) const {
    std::vector<float> features = decoder()->decode(codes, levels);
    scale_.unscale(features);
    return features;
}

std::vector<float> Network::change(std::span<const float> codes,
                                   std::span<const float> from) const {
    const std::shared_ptr<const Decoded> base = decoded(from);
    std::vector<float> difference = decoder()->decode(codes);
    for (std::size_t i = 0; i < difference.size(); ++i) {
        const double change =
            static_cast<double>(difference[i]) - static_cast<double>(base->features[i]);
        difference[i] =
            static_cast<float>(change * scale_.unscale_factor(i / kFeatureDim, i % kFeatureDim));
    }
    return difference;
}

std::vector<CodeColumn> Network::derivatives(std::span<const float> codes) const {
    std::vector<CodeColumn> columns = decoder()->derivatives(codes);
    for (CodeColumn& column : columns) {
        for (std::size_t n = 0; n < column.vertices.size(); ++n) {
            scale_.unscale_change(column.vertices[n],
                                  std::span(column.values).subspan(n * kFeatureDim, kFeatureDim));
        }
    }
    return columns;
}

std::vector<ComponentPlace> Network::places() const {
    std::vector<ComponentPlace> places;
    const std::vector<LevelSize> sizes = levels();
    for (int l = 0; l < static_cast<int>(sizes.size()); ++l) {
        const int entry = model_.component_weights(l);
        const std::vector<float> weights =
            model_.to_user_order(entry, std::as_const(model_).parameters().value(entry));
        const auto count = at(sizes[at(l)].codes());
        const std::size_t size = weights.size() / count;
        const std::vector<int> centers = model_.centers(l);
        for (std::size_t k = 0; k < count; ++k) {
            const std::span<const float> own = std::span(weights).subspan(k * size, size);
            places.push_back(place_of(centers[k], own, vertex_count()));
        }
    }
    return places;
}

std::unique_ptr<Learner> Network::learner(const ShapeSet& shapes, std::span<const int> train) {
    return std::make_unique<NetworkLearner>(*this, train_, ScaledFeatures{shapes, scale_}, train);
}

void Network::forget_decoder() {
    const std::lock_guard lock(mutex_);
    decoder_.reset();
    last_decoded_.reset();
}

std::shared_ptr<const CodeDecoder> Network::decoder() const {
    const std::lock_guard lock(mutex_);
    if (!decoder_) decoder_ = model_.decoder();
    return decoder_;
}

/// Kept until other codes are asked for: changes are mostly from the same codes.
std::shared_ptr<const Network::Decoded> Network::decoded(std::span<const float> codes) const {
    {
        const std::lock_guard lock(mutex_);
        if (last_decoded_ && std::ranges::equal(last_decoded_->codes, codes)) return last_decoded_;
    }
    auto made = std::make_shared<const Decoded>(
        Decoded{{codes.begin(), codes.end()}, decoder()->decode(codes)});
    const std::lock_guard lock(mutex_);
    last_decoded_ = made;
    return made;
}

}  // namespace mscomp::nn
