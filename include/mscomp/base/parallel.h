// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <type_traits>

namespace mscomp {

/// Number of threads used by parallel_for; 0 asks for one per processor.
void set_thread_count(int count);
int thread_count();

namespace detail {
using IndexedCall = void (*)(void* context, std::int64_t index);
void parallel_for(std::int64_t count, IndexedCall call, void* context);
}  // namespace detail

/// Calls body(i) once for every i in [0, count), on up to thread_count() threads, in any order.
///
/// Results stay independent of the number of threads as long as body(i) writes only what belongs to
/// i. The exception thrown by the smallest failing index reaches the caller; larger indices may
/// then be left out. Nested calls run serially.
template <class Body>
void parallel_for(std::int64_t count, Body&& body) {
    using Plain = std::remove_reference_t<Body>;
    detail::parallel_for(
        count, [](void* context, std::int64_t i) { (*static_cast<Plain*>(context))(i); },
        const_cast<void*>(static_cast<const void*>(&body)));
}

/// Pieces of fixed size that a range is cut into, whatever the number of threads.
struct Chunks {
    std::int64_t total = 0;
    std::int64_t size = 1;

    std::int64_t count() const { return (total + size - 1) / size; }
    std::int64_t begin(std::int64_t chunk) const { return chunk * size; }
    std::int64_t end(std::int64_t chunk) const {
        return (chunk + 1) * size < total ? (chunk + 1) * size : total;
    }
};

}  // namespace mscomp
