// SPDX-License-Identifier: MIT
#include "multiscale/code_columns.h"

namespace mscomp {

std::vector<CodeColumn> code_columns(const BallComponents& components, const RowMap& map) {
    const auto width = at(components.width());
    std::vector<CodeColumn> columns;
    for (int k = 0; k < components.count(); ++k) {
        CodeColumn column{components.balls()[at(k)].vertices, components.component(k)};
        for (std::size_t n = 0; n < column.vertices.size(); ++n) {
            map.unmap_change(column.vertices[n],
                             std::span(column.values).subspan(n * width, width));
        }
        columns.push_back(std::move(column));
    }
    return columns;
}

}  // namespace mscomp
