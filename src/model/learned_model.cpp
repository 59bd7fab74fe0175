// SPDX-License-Identifier: MIT
#include "mscomp/model/learned_model.h"

#include "mscomp/base/error.h"

namespace mscomp {

void Learner::start_from(const GivenComponents& /*given*/) {
    throw UsageError("components of another model are nothing that this kind begins with");
}

}  // namespace mscomp
