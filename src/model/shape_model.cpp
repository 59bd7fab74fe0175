// SPDX-License-Identifier: MIT
#include "mscomp/model/shape_model.h"

namespace mscomp {

int ShapeModel::code_count() const {
    int count = 0;
    for (const LevelSize& level : levels()) count += level.codes();
    return count;
}

std::vector<int> ShapeModel::parents() const {
    std::vector<int> parents;
    int above = 0;  // first code of the level above
    const std::vector<LevelSize> sizes = levels();
    for (std::size_t l = 0; l < sizes.size(); ++l) {
        const bool has_parents = l > 0 && refines_components();
        for (int row = 0; row < sizes[l].codes(); ++row) {
            parents.push_back(has_parents ? above + row / sizes[l].components : -1);
        }
        if (l > 0) above += sizes[l - 1].codes();
    }
    return parents;
}

}  // namespace mscomp
