// SPDX-License-Identifier: MIT
#include "base/aligned.h"

#include <cstdint>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace mscomp {
namespace {

constexpr std::size_t kLargePage = std::size_t{1} << 21;

std::size_t whole_pages(std::size_t bytes) {
    return (bytes + kLargePage - 1) / kLargePage * kLargePage;
}

}  // namespace

#if defined(__linux__)

void* allocate_pages(std::size_t bytes) {
    // One page more than needed, so that there is a boundary to begin at; the rest goes back.
    const std::size_t size = whole_pages(bytes);
    void* taken = mmap(nullptr, size + kLargePage, PROT_READ | PROT_WRITE,
                       MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (taken == MAP_FAILED) throw std::bad_alloc();
    char* const first = static_cast<char*>(taken);
    const std::size_t before =
        (kLargePage - reinterpret_cast<std::uintptr_t>(first) % kLargePage) % kLargePage;
    char* const begin = first + before;
    if (before > 0) munmap(first, before);
    if (before < kLargePage) munmap(begin + size, kLargePage - before);
    // The last page is partly unused: it may stay small.
    madvise(begin, bytes / kLargePage * kLargePage, MADV_HUGEPAGE);
    return begin;
}

void free_pages(void* memory, std::size_t bytes) { munmap(memory, whole_pages(bytes)); }

#else

void* allocate_pages(std::size_t bytes) {
    return ::operator new (whole_pages(bytes), std::align_val_t{kLargePage});
}

void free_pages(void* memory, std::size_t) {
    ::operator delete (memory, std::align_val_t{kLargePage});
}

#endif

}  // namespace mscomp
