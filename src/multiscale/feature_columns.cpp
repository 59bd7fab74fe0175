// SPDX-License-Identifier: MIT
#include "multiscale/feature_columns.h"

namespace mscomp {

std::vector<CodeColumn> feature_columns(const BallComponents& components,
                                        const MetricScale& scale) {
    std::vector<CodeColumn> columns;
    for (int k = 0; k < components.count(); ++k) {
        CodeColumn column{components.balls()[at(k)].vertices, components.component(k)};
        for (std::size_t n = 0; n < column.vertices.size(); ++n) {
            scale.unscale_change(column.vertices[n],
                                 std::span(column.values).subspan(n * kFeatureDim, kFeatureDim));
        }
        columns.push_back(std::move(column));
    }
    return columns;
}

}  // namespace mscomp
