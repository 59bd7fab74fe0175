// SPDX-License-Identifier: MIT
#include "multiscale/ball_model.h"

#include <algorithm>
#include <array>
#include <utility>

#include "multiscale/code_columns.h"
#include "multiscale/vertex_loops.h"

namespace mscomp {

std::vector<int> BallModel::parents() const {
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
        has_parents = l > 0 || !has_global_level();
        above = first;
        first += count;
    }
    return parents;
}

CodeTable BallModel::encode(const ShapeSet& shapes, std::span<const int> which) {
    if (!codes_) codes_.emplace(components_);
    CodeTable table{components_.count(), {}};
    for (const int shape : which) {
        const std::vector<float> row = map_.mapped(shapes, shape);
        const Eigen::VectorXf codes = codes_->solve(products(components_, row)).cast<float>();
        table.values.insert(table.values.end(), codes.begin(), codes.end());
    }
    return table;
}

std::vector<float> BallModel::reference_codes() {
    return std::vector<float>(at(components_.count()), 0.0F);
}

/// Σ_k z_k C_k of the first `levels` levels, (V,width).
std::vector<float> BallModel::sum(std::span<const float> codes, int levels) const {
    return weighted_sum(components_, codes.first(at(codes_of_levels(levels))));
}

int BallModel::codes_of_levels(int count) const {
    const std::vector<LevelSize> sizes = levels();
    int codes = 0;
    for (std::size_t l = 0; l < sizes.size(); ++l) {
        if (count == 0 || static_cast<int>(l) < count) codes += sizes[l].components;
    }
    return codes;
}

std::vector<float> BallModel::decode(std::span<const float> codes, int levels) const {
    std::vector<float> row = sum(codes, levels);
    map_.unmap(row);
    return row;
}

std::vector<float> BallModel::change(std::span<const float> codes,
                                     std::span<const float> from) const {
    std::vector<float> difference(codes.begin(), codes.end());
    for (std::size_t k = 0; k < difference.size(); ++k) difference[k] -= from[k];
    std::vector<float> row = sum(difference, 0);
    const auto width = at(map_.width());
    for (int v = 0; v < vertex_count(); ++v) {
        map_.unmap_change(v, std::span(row).subspan(at(v) * width, width));
    }
    return row;
}

std::vector<CodeColumn> BallModel::derivatives(std::span<const float> /*codes*/) const {
    return code_columns(components_, map_);
}

std::vector<ComponentPlace> BallModel::places() const {
    const auto width = at(map_.width());
    std::vector<ComponentPlace> places;
    for (int k = 0; k < components_.count(); ++k) {
        const Ball& ball = components_.balls()[at(k)];
        const std::vector<float> values = components_.component(k);
        ComponentPlace place{ball.center, ball.center, 0};
        float longest = 0;
        for (std::size_t n = 0; n < ball.vertices.size(); ++n) {
            float square = 0;
            for (std::size_t c = 0; c < width; ++c) {
                square += values[n * width + c] * values[n * width + c];
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

void BallModel::set_balls(BallComponents components) {
    components_ = std::move(components);
    codes_.reset();
}

}  // namespace mscomp
