// SPDX-License-Identifier: MIT
#include "mscomp/base/parallel.h"

#include <omp.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <latch>
#include <limits>
#include <mutex>
#include <thread>
#include <vector>

namespace mscomp {
namespace {

std::atomic<int> requested_threads{0};

/// How many of `wanted` threads can be there at once, this one included.
int threads_that_fit(int wanted) {
    std::latch all_tried(1);
    std::vector<std::thread> others;
    try {
        others.reserve(static_cast<std::size_t>(wanted - 1));
        while (static_cast<int>(others.size()) < wanted - 1) {
            others.emplace_back([&all_tried] { all_tried.wait(); });
        }
    } catch (const std::exception&) {  // no memory, or no thread: as many as there are
    }
    all_tried.count_down();
    for (std::thread& other : others) other.join();
    return static_cast<int>(others.size()) + 1;
}

/// `wanted`, or less where the system does not give as many: the OpenMP library would end the
/// process. Those that it can have it makes at once, and keeps them for the thread that asks.
int threads_to_use(int wanted) {
    thread_local int tried = 1, fit = 1;
    if (wanted <= fit || wanted <= tried) return std::min(wanted, fit);
    tried = wanted;
    fit = threads_that_fit(wanted);
#if !defined(__SANITIZE_THREAD__)
#pragma omp parallel num_threads(fit)
    {}
#endif
    return fit;
}

}  // namespace

void set_thread_count(int count) { requested_threads = std::max(count, 0); }

int thread_count() {
    const int requested = requested_threads;
    return requested > 0 ? requested : omp_get_num_procs();
}

namespace detail {

void parallel_for(std::int64_t count, IndexedCall call, void* context) {
    thread_local bool is_inside = false;
    const int wanted = static_cast<int>(std::min<std::int64_t>(thread_count(), count));
    const int threads = wanted <= 1 || is_inside ? 1 : threads_to_use(wanted);
    if (threads == 1) {
        for (std::int64_t i = 0; i < count; ++i) call(context, i);
        return;
    }
    std::atomic<std::int64_t> next{0};
    // Once an index has failed, larger ones are not worth starting.
    std::atomic<std::int64_t> lowest_failure{std::numeric_limits<std::int64_t>::max()};
    std::mutex failing;
    std::exception_ptr error;  // of the lowest failure
    const auto work = [&] {
        is_inside = true;
        for (std::int64_t i = next++; i < count; i = next++) {
            if (i > lowest_failure) continue;
            try {
                call(context, i);
            } catch (...) {
                const std::lock_guard lock(failing);
                if (i < lowest_failure) {
                    lowest_failure = i;
                    error = std::current_exception();
                }
            }
        }
        is_inside = false;
    };
#if defined(__SANITIZE_THREAD__)
    // The sanitizer does not see how the OpenMP library makes threads wait for each other.
    std::vector<std::thread> workers;
    for (int i = 0; i < threads; ++i) workers.emplace_back(work);
    for (std::thread& worker : workers) worker.join();
#else
#pragma omp parallel num_threads(threads)
    work();
#endif
    if (error) std::rethrow_exception(error);
}

}  // namespace detail
}  // namespace mscomp
