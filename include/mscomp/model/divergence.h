// SPDX-License-Identifier: MIT
#pragma once

#include "mscomp/base/error.h"

namespace mscomp {

/// Training that went astray: numbers that are not finite, or a model far worse than none. An
/// earlier state at a lower rate may end well.
class DivergenceError : public NumericalError {
  public:
    using NumericalError::NumericalError;
};

}  // namespace mscomp
