// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "command_text.h"

namespace mscomp {

/// What a shell reads to complete the command lines of `program`: its commands, their options, the
/// values of an option where they are few, files where any text is taken.
std::string bash_completion(const CommandText& program);
std::string zsh_completion(const CommandText& program);
std::string fish_completion(const CommandText& program);

}  // namespace mscomp
