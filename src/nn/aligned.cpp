// SPDX-License-Identifier: MIT
#include "mscomp/nn/aligned.h"

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace mscomp::nn {

void advise_large_pages([[maybe_unused]] void* memory, [[maybe_unused]] std::size_t bytes) {
#if defined(__linux__)
    constexpr std::size_t kPage = AlignedAllocator<char>::kLargePage;
    madvise(memory, bytes / kPage * kPage, MADV_HUGEPAGE);
#endif
}

}  // namespace mscomp::nn
