// SPDX-License-Identifier: MIT
#include "nn/model.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>
#include <utility>

#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"
#include "nn/dim.h"
#include "nn/resolution.h"

namespace mscomp::nn {
template <class T>
Model<T>::Model(const OneRings& rings, DistanceRows& distances, int batch)
    : order_(reverse_cuthill_mckee(rings)), inner_distances_(distances, order_), batch_(batch) {
    lane_mask_.weight.assign(at(lane_count(batch)), T{0});
}

template <class T>
Var Model<T>::record_input(bool with_gradient) {
    x_ = tape_.input("x", {1, vertex_count(), kDim, lanes()}, with_gradient);
    return x_;
}

template <class T>
int Model<T>::add_component_weights(std::string name, Extents extents, double exponent) {
    const int index = parameters_.add(std::move(name), std::move(extents));
    parameters_.set_rate_scale(index, std::pow(1 / code_growth(vertex_count()), exponent));
    return index;
}

template <class T>
void Model<T>::set_shapes(std::span<const int> shapes) {
    assert(!shapes.empty() && static_cast<int>(shapes.size()) <= batch_);
    lane_mask_.active = static_cast<int>(shapes.size());
    for (std::size_t l = 0; l < lane_mask_.weight.size(); ++l) {
        lane_mask_.weight[l] = l < shapes.size() ? T{1} : T{0};
    }
}

template <class T>
template <class Source>
void Model<T>::load_batch(std::span<const Source> features, std::span<const int> which) {
    set_shapes(which);
    const std::int64_t lanes = this->lanes(), rows = vertex_count() * kDim;
    const std::span<T> x = tape_.value(x_);
    parallel_for(vertex_count(), [&](std::int64_t v) {
        const std::int64_t user = order_.to_user[at(v)];
        for (std::int64_t c = 0; c < kDim; ++c) {
            T* row = x.data() + (v * kDim + c) * lanes;
            for (std::int64_t l = 0; l < lanes; ++l) {
                row[l] = l < lane_mask_.active
                             ? static_cast<T>(features[at(which[at(l)] * rows + user * kDim + c)])
                             : T{0};
            }
        }
    });
    batch_loaded(which);
}

template <class T>
void Model<T>::load_batch(const ScaledFeatures& features, std::span<const int> which) {
    set_shapes(which);
    gather_lanes(features, which, order_, tape_.value(x_), GatherThreads::all);
    batch_loaded(which);
}

template <class T>
void Model<T>::load_batch(const LaneBatch& batch) {
    set_shapes(batch.shapes);
    const std::span<T> x = tape_.value(x_);
    assert(x.size() == batch.rows.size());
    const Chunks chunks{static_cast<std::int64_t>(x.size()), std::int64_t{1} << 18};
    parallel_for(chunks.count(), [&](std::int64_t i) {
        std::copy(batch.rows.begin() + chunks.begin(i), batch.rows.begin() + chunks.end(i),
                  x.begin() + chunks.begin(i));
    });
    batch_loaded(batch.shapes);
}

template <class T>
double Model<T>::input_energy() {
    const std::span<const T> x = tape_.value(x_);
    const Chunks chunks{static_cast<std::int64_t>(x.size()), std::int64_t{1} << 18};
    std::vector<double> sums(at(chunks.count()));
    parallel_for(chunks.count(), [&](std::int64_t i) {
        double sum = 0;
        for (std::int64_t k = chunks.begin(i); k < chunks.end(i); ++k) {
            sum += static_cast<double>(x[at(k)]) * static_cast<double>(x[at(k)]);
        }
        sums[at(i)] = sum;
    });
    return std::accumulate(sums.begin(), sums.end(), 0.0) / lane_mask_.active;
}

template <class T>
T Model<T>::forward() {
    tape_.forward();
    return tape_.value(total_)[0];
}

template <class T>
void Model<T>::backward() {
    tape_.backward(total_);
}

template <class T>
T Model<T>::forward_and_backward() {
    const T total = forward();
    backward();
    return total;
}

template <class T>
std::vector<T> Model<T>::all_codes() {
    std::vector<std::vector<T>> of_levels;
    const int count = static_cast<int>(level_sizes().size());
    for (int l = 0; l < count; ++l) of_levels.push_back(codes(l));
    std::vector<T> all;
    const auto shapes = at(lane_mask_.active);
    for (std::size_t m = 0; m < shapes; ++m) {
        for (const std::vector<T>& level : of_levels) {
            const std::size_t width = level.size() / shapes;
            const std::span<const T> row = std::span(level).subspan(m * width, width);
            all.insert(all.end(), row.begin(), row.end());
        }
    }
    return all;
}

template <class T>
std::vector<T> Model<T>::batch_codes(std::span<const T> codes) const {
    const std::int64_t lanes = this->lanes();
    const std::int64_t rows = static_cast<std::int64_t>(codes.size()) / lanes;
    std::vector<T> result;
    for (int m = 0; m < lane_mask_.active; ++m) {
        for (std::int64_t k = 0; k < rows; ++k) result.push_back(codes[at(k * lanes + m)]);
    }
    return result;
}

template <class T>
std::vector<T> Model<T>::batch_rows(std::span<const T> rows) const {
    const std::int64_t size = vertex_count() * kDim, lanes = this->lanes();
    std::vector<T> result(at(size * lane_mask_.active));
    for (std::int64_t v = 0; v < vertex_count(); ++v) {
        for (std::int64_t c = 0; c < kDim; ++c) {
            for (std::int64_t m = 0; m < lane_mask_.active; ++m) {
                result[at(m * size + order_.to_user[at(v)] * kDim + c)] =
                    rows[at((v * kDim + c) * lanes + m)];
            }
        }
    }
    return result;
}

template <class T>
std::vector<T> Model<T>::to_user_order(int index, std::span<const T> inner) const {
    std::vector<T> user(inner.begin(), inner.end());
    const Extents& extents = parameters_.entry(index).extents;
    if (extents.size() != 4) return user;
    const std::int64_t vertices = extents[2], width = extents[3];
    for (std::int64_t row = 0; row < extents[0] * extents[1]; ++row) {
        for (std::int64_t v = 0; v < vertices; ++v) {
            std::copy_n(inner.begin() + (row * vertices + v) * width, width,
                        user.begin() + (row * vertices + order_.to_user[at(v)]) * width);
        }
    }
    return user;
}

template <class T>
void Model<T>::from_user_order(int index, std::span<const T> user, std::span<T> inner) const {
    const Extents& extents = parameters_.entry(index).extents;
    if (extents.size() != 4) {
        std::copy(user.begin(), user.end(), inner.begin());
        return;
    }
    const std::int64_t vertices = extents[2], width = extents[3];
    for (std::int64_t row = 0; row < extents[0] * extents[1]; ++row) {
        for (std::int64_t v = 0; v < vertices; ++v) {
            std::copy_n(user.begin() + (row * vertices + order_.to_user[at(v)]) * width, width,
                        inner.begin() + (row * vertices + v) * width);
        }
    }
}

template class Model<float>;
template class Model<double>;
template void Model<float>::load_batch(std::span<const float>, std::span<const int>);
template void Model<double>::load_batch(std::span<const float>, std::span<const int>);
template void Model<double>::load_batch(std::span<const double>, std::span<const int>);

}  // namespace mscomp::nn
