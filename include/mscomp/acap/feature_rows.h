// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <span>

#include "mscomp/base/feature_set.h"

namespace mscomp {

/// Where the rows of N shapes are kept while they are extracted: in memory or in a file. Rows of
/// different shapes may be written and read at the same time.
class FeatureRows {
  public:
    virtual ~FeatureRows() = default;

    virtual void put_vertices(int shape, std::span<const float> row) = 0;  // (V,3)
    virtual void put_features(int shape, std::span<const float> row) = 0;  // (V,9)
    /// (V,9) as they were put last.
    virtual void get_features(int shape, std::span<float> row) const = 0;
};

/// The rows of a feature set, borrowed, which has room for them.
class MemoryRows final : public FeatureRows {
  public:
    explicit MemoryRows(FeatureSet& set) : set_(set) {}

    void put_vertices(int shape, std::span<const float> row) override {
        std::copy(row.begin(), row.end(), set_.vertices.begin() + offset(shape, row));
    }
    void put_features(int shape, std::span<const float> row) override {
        std::copy(row.begin(), row.end(), set_.features.begin() + offset(shape, row));
    }
    void get_features(int shape, std::span<float> row) const override {
        std::copy_n(set_.features.begin() + offset(shape, row), row.size(), row.begin());
    }

  private:
    template <class T>
    static std::ptrdiff_t offset(int shape, std::span<T> row) {
        return static_cast<std::ptrdiff_t>(shape) * static_cast<std::ptrdiff_t>(row.size());
    }

    FeatureSet& set_;
};

}  // namespace mscomp
