// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>

#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"

namespace mscomp {

/// The ACAP features of N shapes of one connectivity, wherever they lie: in memory, or in a file
/// that is larger than it. May be asked from several threads at a time.
class ShapeFeatures {
  public:
    virtual ~ShapeFeatures() = default;
    virtual int shape_count() const = 0;
    virtual int vertex_count() const = 0;
    /// (V,9); valid as long as the object.
    virtual std::span<const float> shape(int index) const = 0;
    /// This shape need not stay in memory; it comes back when it is used.
    virtual void forget(int index) const = 0;
};

/// Shapes with their features and their vertices.
class ShapeSet : public ShapeFeatures {
  public:
    /// (V,3), aligned; valid as long as the object.
    virtual std::span<const float> vertices(int index) const = 0;
};

/// Features (N,V,9) in memory, borrowed.
class MemoryFeatures final : public ShapeFeatures {
  public:
    MemoryFeatures(std::span<const float> features, int vertex_count)
        : features_(features), vertex_count_(vertex_count) {}

    int shape_count() const override {
        return width() == 0 ? 0 : static_cast<int>(features_.size() / width());
    }
    int vertex_count() const override { return vertex_count_; }
    std::span<const float> shape(int index) const override {
        return features_.subspan(at(index) * width(), width());
    }
    void forget(int) const override {}

  private:
    std::size_t width() const { return at(vertex_count_) * kFeatureDim; }

    std::span<const float> features_;
    int vertex_count_;
};

}  // namespace mscomp
