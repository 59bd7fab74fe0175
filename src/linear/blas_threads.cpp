// SPDX-License-Identifier: MIT
#include "mscomp/linear/blas_threads.h"

#include <dlfcn.h>

#include <mutex>

namespace mscomp {

void pin_blas_threads() {
    static std::once_flag once;
    std::call_once(once, [] {
        // Which BLAS there is shows only when the program runs.
        using SetThreads = void (*)(int);
        const auto set_threads =
            reinterpret_cast<SetThreads>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"));
        if (set_threads != nullptr) set_threads(1);
    });
}

}  // namespace mscomp
