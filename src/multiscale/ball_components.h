// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"

namespace mscomp {

/// Where a component may act.
struct Ball {
    int center = 0;
    std::vector<int> vertices;  // rising
};

/// K components C_k, each `width` values at the vertices of its ball and zero elsewhere, stored
/// vertex by vertex: nine of features, three of positions.
class BallComponents {
  public:
    BallComponents() = default;
    /// All values zero.
    BallComponents(int vertex_count, std::vector<Ball> balls, int width = kFeatureDim);

    int count() const { return static_cast<int>(balls_.size()); }
    int vertex_count() const { return static_cast<int>(first_.size()) - 1; }
    int width() const { return static_cast<int>(width_); }
    const std::vector<Ball>& balls() const { return balls_; }

    /// The components that act at a vertex, rising, and their values there, (n,width).
    std::span<const int> at_vertex(int v) const {
        return std::span(components_).subspan(first_[at(v)], first_[at(v) + 1] - first_[at(v)]);
    }
    std::span<const float> values(int v) const {
        return std::span(values_).subspan(width_ * first_[at(v)], width_ * at_vertex(v).size());
    }
    std::span<float> values(int v) {
        return std::span(values_).subspan(width_ * first_[at(v)], width_ * at_vertex(v).size());
    }
    /// All of them, vertex by vertex, and where those of a vertex begin.
    std::span<float> all_values() { return values_; }
    std::span<const float> all_values() const { return values_; }
    std::size_t first_value(int v) const { return width_ * first_[at(v)]; }
    /// Values of component k at the vertices of its ball, (n,width), and back.
    std::vector<float> component(int k) const;
    void set_component(int k, std::span<const float> values);
    /// Every component to unit length; those without one stay zero. Returns the lengths.
    std::vector<double> normalize();

  private:
    std::size_t width_ = kFeatureDim;
    std::vector<Ball> balls_;
    std::vector<std::size_t> first_{0};             // (V+1) into the components at each vertex
    std::vector<int> components_;                   // of all vertices, one after the other
    std::vector<std::vector<std::size_t>> places_;  // (K) of each vertex of each ball
    std::vector<float> values_;                     // beside components_, `width` each
};

}  // namespace mscomp
