// SPDX-License-Identifier: MIT
// A small training problem: patches of a sphere that rotate, each by a code of its own per shape.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <vector>

#include "mscomp/base/distance_rows.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/random.h"
#include "mscomp/nn/config.h"
#include "mscomp/nn/spectral_config.h"
#include "nn/stacked_model.h"
#include "nn/trainer.h"
#include "shapes.h"

namespace mscomp::nn {

/// Great-circle distances on the unit sphere, divided by pi.
class SphereDistances final : public DistanceRows {
  public:
    explicit SphereDistances(const std::vector<Point>& points) {
        for (const Point& p : points) {
            std::vector<double>& row = rows_.emplace_back();
            for (const Point& q : points) {
                const double cosine = p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
                row.push_back(std::acos(std::clamp(cosine, -1.0, 1.0)) / 3.14159265358979);
            }
        }
    }
    int vertex_count() const override { return static_cast<int>(rows_.size()); }
    std::span<const double> row(int vertex) override {
        return rows_[static_cast<std::size_t>(vertex)];
    }

  private:
    std::vector<std::vector<double>> rows_;
};

/// What the networks of tests are made of and how they are trained.
struct SmallConfig {
    StackedConfig stacked;
    LossConfig loss;
    SpectralConfig spectral;
    SpectralLossConfig spectral_loss;
    TrainConfig train;
};

/// Options that a stacked model gets for training under `config` on `shapes` shapes.
inline StackedModel<float>::Options training_options(const SmallConfig& config, int shapes) {
    StackedModel<float>::Options options;
    options.batch = std::min(config.train.batch, epoch_size(config.train, shapes, 0));  // small
    options.sparsity_gradient = config.train.sparsity_step == SparsityStep::subgradient;
    options.supports = config.train.supports;
    return options;
}

struct SmallTraining {
    TriangleMesh mesh = shapes::icosphere(2);
    SphereDistances distances{mesh.vertices};
    std::vector<float> features;  // (N,V,9), r within +-0.8, S - I zero
    std::vector<int> shapes;
    SmallConfig config;

    explicit SmallTraining(int shape_count = 12, int patches = 3) {
        const CounterRandom random(11, 0);
        const int vertices = mesh.vertex_count();
        features.assign(static_cast<std::size_t>(shape_count * vertices * 9), 0.0F);
        for (int m = 0; m < shape_count; ++m) {
            for (int p = 0; p < patches; ++p) {
                const double code =
                    random.uniform(static_cast<std::uint64_t>(m * patches + p)) - 0.5;
                const auto distance = distances.row(p);
                for (int v = 0; v < vertices; ++v) {
                    const double bump =
                        std::max(0.0, 1 - distance[static_cast<std::size_t>(v)] / 0.25);
                    features[static_cast<std::size_t>((m * vertices + v) * 9 + p % 3)] +=
                        static_cast<float>(1.4 * code * bump);
                }
            }
        }
        shapes.resize(static_cast<std::size_t>(shape_count));
        std::iota(shapes.begin(), shapes.end(), 0);
        config.stacked.levels = {{patches, 0.3, 1.0, {}}, {2, 0.15, 1.0, {}}};
        config.train.epochs = 20;
        config.train.learning_rate = 1e-3;
        config.train.fill_up_to = 0;
        config.train.plateau_epochs = 0;
    }

    std::unique_ptr<StackedModel<float>> make_model() {
        return std::make_unique<StackedModel<float>>(
            config.stacked, config.loss, one_rings_of_faces(mesh.vertex_count(), mesh.faces),
            distances, training_options(config, static_cast<int>(shapes.size())));
    }
};

inline std::vector<float> all_of(StackedModel<float>& model) {
    ParameterSet<float>& p = model.parameters();
    std::vector<float> values(p.all_values().begin(), p.all_values().end());
    values.insert(values.end(), p.all_moments1().begin(), p.all_moments1().end());
    values.insert(values.end(), p.all_moments2().begin(), p.all_moments2().end());
    return values;
}

}  // namespace mscomp::nn
