// SPDX-License-Identifier: MIT
// What a pass left, in the order and numbering of the user.
#include <algorithm>
#include <utility>

#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"
#include "nn/dim.h"
#include "nn/stacked_model.h"
#include "ops/autoencoder.h"

namespace mscomp::nn {
template <class T>
std::vector<T> StackedModel<T>::codes(int level) {
    return this->batch_codes(tape_.value(levels_[at(level)].code));
}

template <class T>
void StackedModel<T>::input_rows(int level, int autoencoder, std::span<T> rows) {
    const Level& l = levels_[at(level)];
    const std::int64_t size = static_cast<std::int64_t>(rows.size());
    if (!l.source.valid()) {
        std::copy_n(tape_.value(l.x).begin() + autoencoder * size, size, rows.begin());
        return;
    }
    const std::int64_t parent = autoencoder / (l.autoencoders / tape_.extents(l.source)[0]);
    const T* source = tape_.value(l.source).data() + parent * size;
    const T* mask = l.source_mask.valid()
                        ? tape_.value(l.source_mask).data() + autoencoder * this->vertex_count()
                        : nullptr;
    const std::int64_t row = size / this->vertex_count();
    parallel_for(this->vertex_count(), [&](std::int64_t v) {
        for (std::int64_t i = v * row; i < (v + 1) * row; ++i) {
            rows[at(i)] = mask ? mask[v] * source[i] : source[i];
        }
    });
}

template <class T>
std::vector<T> StackedModel<T>::reconstruction(int levels) {
    const auto lanes = static_cast<std::int64_t>(lane_mask_.weight.size());
    const std::int64_t rows = this->vertex_count() * kDim * lanes;
    AlignedVector<T> sum(at(rows), T{0});
    for (int l = 0; l < levels; ++l) {
        for (int a = 0; a < levels_[at(l)].autoencoders; ++a) {
            if (!fused_.empty()) {
                fused_[at(l)]->add_output(tape_, a, sum);
                continue;
            }
            const std::span<T> output = tape_.value(levels_[at(l)].output);
            for (std::int64_t i = 0; i < rows; ++i) sum[at(i)] += output[at(a * rows + i)];
        }
    }
    return this->batch_rows(sum);
}

template std::vector<float> StackedModel<float>::codes(int);
template void StackedModel<float>::input_rows(int, int, std::span<float>);
template std::vector<float> StackedModel<float>::reconstruction(int);
template std::vector<double> StackedModel<double>::codes(int);
template void StackedModel<double>::input_rows(int, int, std::span<double>);
template std::vector<double> StackedModel<double>::reconstruction(int);

}  // namespace mscomp::nn
