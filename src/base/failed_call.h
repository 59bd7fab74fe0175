// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <system_error>

#include "mscomp/base/error.h"

namespace mscomp {

/// Throws IoError: what the system call that failed was `doing` to the file, and why it could not.
[[noreturn]] inline void fail(const std::string& path, const char* doing, int error_number) {
    throw IoError(path, std::string("cannot ") + doing + ": " +
                            std::generic_category().message(error_number));
}

}  // namespace mscomp
