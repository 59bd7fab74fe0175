// SPDX-License-Identifier: MIT
#include "file_bytes.h"

#include <cstring>
#include <span>

#include "mscomp/base/readable_file.h"

namespace mscomp {

FileBytes::FileBytes(const std::string& path) {
    const ReadableFile file(path);
    // One byte more than a file has: the read that finds its end then needs no more room. Pipes say
    // 0 and grow.
    std::size_t capacity = file.size() + 1;
    grow(capacity);
    for (;;) {
        if (size_ == capacity) grow(capacity = 2 * capacity + 65536);
        const std::size_t got = file.read(std::span(bytes_.get() + size_, capacity - size_));
        if (got == 0) return;
        size_ += got;
    }
}

void FileBytes::grow(std::size_t capacity) {
    auto larger = std::make_unique_for_overwrite<char[]>(capacity);
    if (size_ > 0) std::memcpy(larger.get(), bytes_.get(), size_);
    bytes_ = std::move(larger);
}

}  // namespace mscomp
