// SPDX-License-Identifier: MIT
#include "multiscale/training_pool.h"

#include <algorithm>
#include <numeric>

namespace mscomp {
namespace {

std::vector<int> as_they_are(int vertices) {
    std::vector<int> same(at(vertices));
    std::iota(same.begin(), same.end(), 0);
    return same;
}

}  // namespace

TrainingPool::TrainingPool(const ShapeFeatures& shapes, std::span<const int> train,
                           const Mirror* mirror, DistanceRows& distances, const MetricScale& scale,
                           const Options& options)
    : scale_(scale), real_(train.begin(), train.end()) {
    const ShapeFeatures* from = &shapes;
    if (mirror != nullptr) {
        mirrored_.emplace(shapes, *mirror);
        from = &*mirrored_;
        for (const int shape : train) real_.push_back(shapes.shape_count() + shape);
    }
    mixed_count_ = std::max(0, options.fill_up_to - static_cast<int>(real_.size()));
    source_ = from;
    if (mixed_count_ == 0) return;
    mixed_ = std::make_unique<MixedFeatures>(
        *from, real_, distances, as_they_are(shapes.vertex_count()), options.seed, options.between);
    source_ = mixed_.get();
}

/// Mix m is replaced by mix m + mixed_count_.
int TrainingPool::mixed_shape(std::int64_t place, std::int64_t round) const {
    constexpr std::int64_t kReplaced = 4;
    const std::int64_t replaced = kReplaced * round;
    const std::int64_t times =
        replaced > place ? (replaced - place + mixed_count_ - 1) / mixed_count_ : 0;
    return mixed_->shape_count() + static_cast<int>(place + times * mixed_count_);
}

const MetricRows& TrainingPool::rows(std::int64_t round) {
    if (!rows_) {
        rows_.emplace(source_->vertex_count(), shape_count());
        gathered_.assign(at(shape_count()), -1);
    }
    std::vector<float> row(at(source_->vertex_count()) * kFeatureDim);
    for (int m = 0; m < shape_count(); ++m) {
        const int place = m - static_cast<int>(real_.size());
        const int wanted = place < 0 ? real_[at(m)] : mixed_shape(place, round);
        if (gathered_[at(m)] == wanted) continue;
        std::ranges::copy(source_->shape(wanted), row.begin());
        scale_.scale(row);
        source_->forget(wanted);
        rows_->set(m, row);
        gathered_[at(m)] = wanted;
    }
    return *rows_;
}

}  // namespace mscomp
