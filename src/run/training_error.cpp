// SPDX-License-Identifier: MIT
#include "training_error.h"

#include <numeric>
#include <vector>

#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"

namespace mscomp {

double squared_error(const ShapeModel& model, const ShapeSet& shapes, std::span<const int> which,
                     const CodeTable& codes, const MetricScale& scale) {
    const bool has_features = model.rows() == ShapeRows::features;
    const std::size_t width = at(row_width(model.rows()));
    std::vector<double> squares(which.size(), 0.0);
    parallel_for(static_cast<std::int64_t>(which.size()), [&](std::int64_t m) {
        const std::vector<float> rows = model.decode(codes.shape(static_cast<int>(m)));
        const int shape = which[at(m)];
        const std::span<const float> truth =
            has_features ? shapes.shape(shape) : shapes.vertices(shape);
        for (std::size_t i = 0; i < rows.size(); ++i) {
            double away = static_cast<double>(rows[i]) - static_cast<double>(truth[i]);
            if (has_features) away *= scale.scale_factor(i / width, i % width);
            squares[at(m)] += away * away;
        }
        shapes.forget(shape);
    });
    return std::accumulate(squares.begin(), squares.end(), 0.0);
}

}  // namespace mscomp
