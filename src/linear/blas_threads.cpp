// SPDX-License-Identifier: MIT
#include "mscomp/linear/blas_threads.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <sys/mman.h>

#include <cerrno>
#include <cstddef>
#include <mutex>
#include <system_error>
#include <vector>

#include "mscomp/base/error.h"
#include "mscomp/base/parallel.h"

namespace mscomp {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{128} << 20;  // the largest that OpenBLAS has

/// Which BLAS there is shows only when the program runs.
template <class Function>
Function* blas_function(const char* name) {
    return reinterpret_cast<Function*>(::dlsym(RTLD_DEFAULT, name));
}

/// Throws IoError unless there is room for so many buffers at once.
void require_room(int buffers) {
    std::vector<void*> taken;
    int failed = 0;
    for (int k = 0; k < buffers && failed == 0; ++k) {
        void* room = ::mmap(nullptr, kBufferBytes, PROT_READ | PROT_WRITE,
                            MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        if (room == MAP_FAILED) {
            failed = errno;
        } else {
            taken.push_back(room);
        }
    }
    for (void* room : taken) ::munmap(room, kBufferBytes);
    if (failed == 0) return;
    throw IoError("OpenBLAS", fmt::format("no room for {} MiB in each of {} threads: {}; wanted a "
                                          "larger ulimit -v, or fewer --threads",
                                          kBufferBytes >> 20U, buffers,
                                          std::generic_category().message(failed)));
}

/// OpenBLAS asks again without end for a buffer that it cannot have, so it shall have all that it
/// may need, one for each thread that calls it, from now on.
void take_buffers(int buffers) {
    const auto take = blas_function<void*(int)>("blas_memory_alloc");
    const auto give_back = blas_function<void(void*)>("blas_memory_free");
    if (take == nullptr || give_back == nullptr) return;
    require_room(buffers);
    std::vector<void*> taken;
    for (int k = 0; k < buffers; ++k) taken.push_back(take(0));
    for (void* buffer : taken) give_back(buffer);
}

}  // namespace

void pin_blas_threads() {
    static std::once_flag once;
    std::call_once(once, [] {
        if (const auto set_threads = blas_function<void(int)>("openblas_set_num_threads")) {
            set_threads(1);
            take_buffers(thread_count());
        }
    });
}

}  // namespace mscomp
