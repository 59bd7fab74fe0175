// SPDX-License-Identifier: MIT
#include "mscomp/model/given_components.h"

#include <algorithm>
#include <cmath>

#include "mscomp/base/index.h"

namespace mscomp {
namespace {

/// Mean and deviation of each code over the shapes.
struct UsualCodes {
    std::vector<float> mean, deviation;  // (K)

    UsualCodes(const CodeTable& codes, int count)
        : mean(at(count), 0.0F), deviation(at(count), 1.0F) {
        const double shapes = codes.shape_count();
        if (codes.shape_count() == 0) return;
        for (std::size_t k = 0; k < mean.size(); ++k) {
            double sum = 0, squares = 0;
            for (int m = 0; m < codes.shape_count(); ++m) {
                sum += static_cast<double>(codes.shape(m)[k]);
            }
            for (int m = 0; m < codes.shape_count(); ++m) {
                const double off = static_cast<double>(codes.shape(m)[k]) - sum / shapes;
                squares += off * off;
            }
            mean[k] = static_cast<float>(sum / shapes);
            const auto root = static_cast<float>(std::sqrt(squares / shapes));
            if (root > 0) deviation[k] = root;
        }
    }
};

/// The vertices of a row (V,width) that are not zero, divided by `by`.
CodeColumn column_of(const std::vector<float>& row, int width, float by) {
    CodeColumn column;
    const auto size = at(width);
    for (std::size_t first = 0; first < row.size(); first += size) {
        const auto values = std::span(row).subspan(first, size);
        if (std::ranges::all_of(values, [](float x) { return x == 0; })) continue;
        column.vertices.push_back(static_cast<int>(first / size));
        for (const float x : values) column.values.push_back(x / by);
    }
    return column;
}

}  // namespace

GivenComponents given_components(const ShapeModel& model, const CodeTable& codes) {
    GivenComponents given{model.vertex_count(), model.levels(), model.parents(), {}, {}};
    for (const ComponentPlace& place : model.places()) given.centers.push_back(place.center);
    const UsualCodes usual(codes, model.code_count());
    for (std::size_t k = 0; k < usual.mean.size(); ++k) {
        std::vector<float> low = usual.mean, high = usual.mean;
        low[k] -= usual.deviation[k];
        high[k] += usual.deviation[k];
        given.changes.push_back(
            column_of(model.change(high, low), row_width(model.rows()), high[k] - low[k]));
    }
    return given;
}

}  // namespace mscomp
