// SPDX-License-Identifier: MIT
#include "multiscale/multiscale_model.h"

#include <algorithm>
#include <utility>

#include "mscomp/base/feature_set.h"
#include "multiscale/feature_columns.h"
#include "multiscale/multiscale_learner.h"
#include "multiscale/vertex_loops.h"

namespace mscomp {
MultiscaleModel::MultiscaleModel(const Config& config, const ModelPlace& place)
    : reference_(place.reference),
      weights_(place.weights),
      train_(config.train),
      settings_(config.own<MultiscaleSettings>()),
      distances_(place.distances),
      scale_(place.scale),
      global_count_(settings_.global_components) {
    set_components(
        BallComponents(vertex_count(), std::vector<Ball>(at(global_count_ + local_count()))));
}

int MultiscaleModel::local_count() const {
    int count = 0;
    for (const BallLevel& level : settings_.levels) count += level.components;
    return count;
}

std::vector<LevelSize> MultiscaleModel::levels() const {
    std::vector<LevelSize> sizes;
    if (global_count_ > 0) sizes.push_back({1, global_count_});
    for (const BallLevel& level : settings_.levels) sizes.push_back({1, level.components});
    return sizes;
}

/// Those it began with, or the one of the level above that it overlaps most.
std::vector<int> MultiscaleModel::parents() const {
    if (!parents_.empty()) return parents_;
    const Eigen::MatrixXd shared = overlaps(components_);
    std::vector<int> parents;
    int above = 0, first = 0;  // level above: [above, first)
    bool has_parents = false;
    for (std::size_t l = 0; l < levels().size(); ++l) {
        const int count = levels()[l].components;
        for (int k = first; k < first + count; ++k) {
            int best = -1;
            for (int p = above; has_parents && p < first; ++p) {
                if (shared(k, p) > (best < 0 ? 0 : shared(k, best))) best = p;
            }
            parents.push_back(best);
        }
        // The global ones overlap everything.
        has_parents = l > 0 || global_count_ == 0;
        above = first;
        first += count;
    }
    return parents;
}

CodeTable MultiscaleModel::encode(const ShapeSet& shapes, std::span<const int> which) {
    if (!codes_) codes_.emplace(components_);
    CodeTable table{components_.count(), {}};
    std::vector<float> row(at(vertex_count()) * kFeatureDim);
    for (const int shape : which) {
        std::ranges::copy(shapes.shape(shape), row.begin());
        scale_.scale(row);
        const Eigen::VectorXf codes = codes_->solve(products(components_, row)).cast<float>();
        table.values.insert(table.values.end(), codes.begin(), codes.end());
        shapes.forget(shape);
    }
    return table;
}

std::vector<float> MultiscaleModel::reference_codes() {
    return std::vector<float>(at(components_.count()), 0.0F);
}

/// Σ_k z_k C_k of the first `levels` levels, (V,9).
std::vector<float> MultiscaleModel::sum(std::span<const float> codes, int levels) const {
    int count = 0;
    const std::vector<LevelSize> sizes = this->levels();
    for (std::size_t l = 0; l < sizes.size(); ++l) {
        if (levels == 0 || static_cast<int>(l) < levels) count += sizes[l].components;
    }
    std::vector<float> row(at(vertex_count()) * kFeatureDim);
    for_vertices(vertex_count(), [&](int v) {
        const auto acting = components_.at_vertex(v);
        const auto values = components_.values(v);
        std::array<double, kFeatureDim> total{};
        for (std::size_t a = 0; a < acting.size() && acting[a] < count; ++a) {
            const auto code = static_cast<double>(codes[at(acting[a])]);
            for (std::size_t c = 0; c < kFeatureDim; ++c) {
                total[c] += code * static_cast<double>(values[kFeatureDim * a + c]);
            }
        }
        for (std::size_t c = 0; c < kFeatureDim; ++c) {
            row[at(v) * kFeatureDim + c] = static_cast<float>(total[c]);
        }
    });
    return row;
}

std::vector<float> MultiscaleModel::decode(std::span<const float> codes, int levels) const {
    std::vector<float> row = sum(codes, levels);
    scale_.unscale(row);
    return row;
}

std::vector<float> MultiscaleModel::change(std::span<const float> codes,
                                           std::span<const float> from) const {
    std::vector<float> difference(codes.begin(), codes.end());
    for (std::size_t k = 0; k < difference.size(); ++k) difference[k] -= from[k];
    std::vector<float> row = sum(difference, 0);
    for (int v = 0; v < vertex_count(); ++v) {
        scale_.unscale_change(v, std::span(row).subspan(at(v) * kFeatureDim, kFeatureDim));
    }
    return row;
}

std::vector<CodeColumn> MultiscaleModel::derivatives(std::span<const float> /*codes*/) const {
    return feature_columns(components_, scale_);
}

std::vector<ComponentPlace> MultiscaleModel::places() const {
    std::vector<ComponentPlace> places;
    for (int k = 0; k < components_.count(); ++k) {
        const Ball& ball = components_.balls()[at(k)];
        const std::vector<float> values = components_.component(k);
        ComponentPlace place{ball.center, ball.center, 0};
        float longest = 0;
        for (std::size_t n = 0; n < ball.vertices.size(); ++n) {
            float square = 0;
            for (std::size_t c = 0; c < kFeatureDim; ++c) {
                square += values[n * kFeatureDim + c] * values[n * kFeatureDim + c];
            }
            if (square > 0) ++place.support;
            if (square > longest) {
                longest = square;
                place.longest = ball.vertices[n];
            }
        }
        places.push_back(place);
    }
    return places;
}

void MultiscaleModel::set_components(BallComponents components) {
    components_ = std::move(components);
    global_count_ = components_.count() - local_count();
    codes_.reset();
}

std::unique_ptr<Learner> MultiscaleModel::learner(const ShapeSet& shapes,
                                                  std::span<const int> train) {
    return std::make_unique<MultiscaleLearner>(
        *this, settings_, train_, LearnerPlace{reference_, weights_, distances_}, shapes, train);
}

}  // namespace mscomp
