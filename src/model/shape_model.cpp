// SPDX-License-Identifier: MIT
#include "mscomp/model/shape_model.h"

namespace mscomp {

int ShapeModel::code_count() const {
    int count = 0;
    for (const LevelSize& level : levels()) count += level.codes();
    return count;
}

}  // namespace mscomp
