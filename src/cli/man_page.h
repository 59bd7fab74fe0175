// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "command_text.h"

namespace mscomp {

/// A page of the manual, section 1, as roff source.
struct ManPage {
    std::string name;  // "mscomp-train"
    std::string roff;
};

/// One page for `program` and one for each of its commands; `version` is "mscomp 0.1.0".
std::vector<ManPage> man_pages(const CommandText& program, const std::string& version);

}  // namespace mscomp
