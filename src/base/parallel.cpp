// SPDX-License-Identifier: MIT
#include "mscomp/base/parallel.h"

#include <omp.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <limits>
#include <vector>

namespace mscomp {
namespace {

std::atomic<int> requested_threads{0};

}  // namespace

void set_thread_count(int count) { requested_threads = std::max(count, 0); }

int thread_count() {
    const int requested = requested_threads;
    return requested > 0 ? requested : omp_get_num_procs();
}

namespace detail {

void parallel_for(std::int64_t count, IndexedCall call, void* context) {
    const int threads = static_cast<int>(std::min<std::int64_t>(thread_count(), count));
    if (threads <= 1 || omp_in_parallel() != 0) {
        for (std::int64_t i = 0; i < count; ++i) call(context, i);
        return;
    }
    struct Failure {
        std::int64_t index = std::numeric_limits<std::int64_t>::max();
        std::exception_ptr error;
    };
    std::vector<Failure> failures(static_cast<std::size_t>(threads));
    // Once an index has failed, larger ones are not worth starting.
    std::atomic<std::int64_t> lowest_failure{std::numeric_limits<std::int64_t>::max()};
#pragma omp parallel num_threads(threads)
    {
        Failure& mine = failures[static_cast<std::size_t>(omp_get_thread_num())];
#pragma omp for schedule(dynamic, 1)
        for (std::int64_t i = 0; i < count; ++i) {
            if (i > lowest_failure.load(std::memory_order_relaxed)) continue;
            try {
                call(context, i);
            } catch (...) {
                if (i < mine.index) mine = {i, std::current_exception()};
                std::int64_t lowest = lowest_failure.load();
                while (i < lowest && !lowest_failure.compare_exchange_weak(lowest, i)) {
                }
            }
        }
    }
    const auto first =
        std::min_element(failures.begin(), failures.end(),
                         [](const Failure& a, const Failure& b) { return a.index < b.index; });
    if (first->error) std::rethrow_exception(first->error);
}

}  // namespace detail
}  // namespace mscomp
