// SPDX-License-Identifier: MIT
#include "nn/zeroed_array.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cstring>
#include <limits>
#include <new>

#include "mscomp/base/index.h"

namespace mscomp::nn {
namespace {

std::size_t page_bytes() {
    static const auto bytes = at(::sysconf(_SC_PAGESIZE));
    return bytes;
}

std::size_t whole_pages(std::size_t bytes) {
    const std::size_t page = page_bytes();
    if (bytes > std::numeric_limits<std::size_t>::max() - page) throw std::bad_alloc();
    return (bytes + page - 1) / page * page;
}

}  // namespace

ZeroPages::~ZeroPages() {
    if (start_ != nullptr) ::munmap(start_, bytes_);
}

void ZeroPages::grow(std::size_t bytes) {
    const std::size_t wanted = whole_pages(bytes);
    if (wanted <= bytes_) return;
    // Moved, not copied: to copy a page would be to use it.
    void* made = start_ == nullptr ? ::mmap(nullptr, wanted, PROT_READ | PROT_WRITE,
                                            MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0)
                                   : ::mremap(start_, bytes_, wanted, MREMAP_MAYMOVE);
    if (made == MAP_FAILED) throw std::bad_alloc();
    start_ = made;
    bytes_ = wanted;
}

void ZeroPages::reset() {
    if (start_ != nullptr && ::madvise(start_, bytes_, MADV_DONTNEED) != 0) throw std::bad_alloc();
}

void ZeroPages::reset(std::size_t first, std::size_t last) {
    // To give back a few pages costs more than to write to them.
    constexpr std::size_t kWorthwhile = 16;
    char* const bytes = static_cast<char*>(start_);
    const std::size_t begin = whole_pages(first), end = last / page_bytes() * page_bytes();
    if (end < begin + kWorthwhile * page_bytes()) {
        if (first < last) std::memset(bytes + first, 0, last - first);
        return;
    }
    std::memset(bytes + first, 0, begin - first);
    if (::madvise(bytes + begin, end - begin, MADV_DONTNEED) != 0) throw std::bad_alloc();
    std::memset(bytes + end, 0, last - end);
}

}  // namespace mscomp::nn
