// SPDX-License-Identifier: MIT
#pragma once

#include "mscomp/model/config.h"
#include "mscomp/model/keys.h"

namespace mscomp {

/// Every key that a configuration of config.kind has, bound to the fields of `config`, which must
/// outlive the table and keep its kind.
Table config_table(Config& config);

}  // namespace mscomp
