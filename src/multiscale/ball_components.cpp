// SPDX-License-Identifier: MIT
#include "multiscale/ball_components.h"

#include <algorithm>
#include <cmath>

namespace mscomp {

BallComponents::BallComponents(int vertex_count, std::vector<Ball> balls, int width)
    : width_(at(width)),
      balls_(std::move(balls)),
      first_(at(vertex_count) + 1, 0),
      places_(balls_.size()) {
    for (const Ball& ball : balls_) {
        for (const int v : ball.vertices) ++first_[at(v) + 1];
    }
    for (std::size_t v = 0; v + 1 < first_.size(); ++v) first_[v + 1] += first_[v];
    components_.resize(first_.back());
    values_.assign(width_ * first_.back(), 0.0F);
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (std::size_t k = 0; k < balls_.size(); ++k) {
        for (const int v : balls_[k].vertices) {
            components_[next[at(v)]] = static_cast<int>(k);
            places_[k].push_back(next[at(v)]++);
        }
    }
}

std::vector<float> BallComponents::component(int k) const {
    std::vector<float> values;
    values.reserve(width_ * places_[at(k)].size());
    for (const std::size_t place : places_[at(k)]) {
        const auto here = std::span(values_).subspan(width_ * place, width_);
        values.insert(values.end(), here.begin(), here.end());
    }
    return values;
}

void BallComponents::set_component(int k, std::span<const float> values) {
    for (std::size_t n = 0; n < places_[at(k)].size(); ++n) {
        std::ranges::copy(
            values.subspan(width_ * n, width_),
            values_.begin() + static_cast<std::ptrdiff_t>(width_ * places_[at(k)][n]));
    }
}

std::vector<double> BallComponents::normalize() {
    std::vector<double> lengths(balls_.size(), 0.0);
    for (std::size_t k = 0; k < balls_.size(); ++k) {
        double sum = 0;
        for (const std::size_t place : places_[k]) {
            for (std::size_t c = 0; c < width_; ++c) {
                const auto x = static_cast<double>(values_[width_ * place + c]);
                sum += x * x;
            }
        }
        lengths[k] = std::sqrt(sum);
        if (!(lengths[k] > 0)) continue;
        for (const std::size_t place : places_[k]) {
            for (std::size_t c = 0; c < width_; ++c) {
                float& x = values_[width_ * place + c];
                x = static_cast<float>(static_cast<double>(x) / lengths[k]);
            }
        }
    }
    return lengths;
}

}  // namespace mscomp
