// SPDX-License-Identifier: MIT
#include "mscomp/eval/shape_measures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "mscomp/base/index.h"

namespace mscomp {
namespace {

/// As std::max, but NaN wins and stays.
double larger(double a, double b) { return a >= b || std::isnan(a) ? a : b; }

}  // namespace

ShapeMeasures::ShapeMeasures(const TriangleMesh& reference, ShapeOrder order,
                             const StedOptions& options)
    : rms_error_(reference.vertices), sted_(reference, order, options) {}

const ShapeErrors& ShapeMeasures::add(std::string name, const std::vector<Point>& truth,
                                      const std::vector<Point>& result,
                                      std::optional<double> relative_squared_error,
                                      const std::vector<Point>& truth_in_place) {
    sted_.add(truth_in_place.empty() ? truth : truth_in_place, result);
    ShapeErrors errors;
    errors.name = std::move(name);
    errors.rms_error = rms_error_.add(truth, result);
    const std::vector<double> distances = vertex_distances(truth, result);
    for (std::size_t i = 0; i < distances.size(); ++i) {
        errors.mean_vertex_distance += distances[i] / static_cast<double>(distances.size());
        const double largest = larger(errors.max_vertex_distance, distances[i]);
        if (largest != errors.max_vertex_distance && !std::isnan(errors.max_vertex_distance)) {
            errors.worst_vertex = static_cast<int>(i);
        }
        errors.max_vertex_distance = largest;
    }
    errors.relative_squared_error = relative_squared_error;
    return shapes_.emplace_back(std::move(errors));
}

SetErrors ShapeMeasures::total() const {
    SetErrors total;
    total.shape_count = static_cast<int>(shapes_.size());
    total.rms_error = rms_error_.value();
    total.sted = sted_.value();
    if (shapes_.empty()) {
        total.mean_vertex_distance = std::numeric_limits<double>::quiet_NaN();
        total.max_vertex_distance = std::numeric_limits<double>::quiet_NaN();
        return total;
    }
    double sum = 0, largest = 0;
    int known = 0;
    for (const ShapeErrors& shape : shapes_) {
        // All shapes have as many vertices: the mean of means is that over all vertices.
        total.mean_vertex_distance += shape.mean_vertex_distance / total.shape_count;
        total.max_vertex_distance = larger(total.max_vertex_distance, shape.max_vertex_distance);
        if (!shape.relative_squared_error) continue;
        sum += *shape.relative_squared_error;
        largest = larger(largest, *shape.relative_squared_error);
        ++known;
    }
    if (known > 0) {
        total.relative_squared_error_mean = sum / known;
        total.relative_squared_error_max = largest;
    }
    return total;
}

std::vector<int> worst_shapes(std::span<const ShapeErrors> shapes, int count) {
    std::vector<int> order(shapes.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, [&](int a, int b) {
        const double first = shapes[at(a)].rms_error;
        const double second = shapes[at(b)].rms_error;
        if (std::isnan(first) || std::isnan(second))
            return std::isnan(first) && !std::isnan(second);
        return first > second;
    });
    order.resize(std::min(order.size(), at(std::max(count, 0))));
    return order;
}

}  // namespace mscomp
