// SPDX-License-Identifier: MIT
#include "nn/batch_loader.h"

#include <algorithm>
#include <utility>

#include "mscomp/base/index.h"

namespace mscomp::nn {

BatchLoader::~BatchLoader() {
    {
        const std::lock_guard lock(mutex_);
        is_over_ = true;
    }
    changed_.notify_all();
    if (worker_.joinable()) worker_.join();
}

void BatchLoader::prepare(std::span<const int> which) {
    if (!worker_.joinable()) worker_ = std::thread([this] { work(); });
    {
        std::unique_lock lock(mutex_);
        wait(lock);
        failure_ = nullptr;
        batch_.shapes.assign(which.begin(), which.end());
        is_asked_ = true;
    }
    changed_.notify_all();
}

const LaneBatch* BatchLoader::take(std::span<const int> which) {
    std::unique_lock lock(mutex_);
    if (!std::ranges::equal(batch_.shapes, which)) return nullptr;
    wait(lock);
    if (failure_) {
        // Asked for again, they are gathered again.
        batch_.shapes.clear();
        std::rethrow_exception(std::exchange(failure_, nullptr));
    }
    return &batch_;
}

void BatchLoader::wait(std::unique_lock<std::mutex>& lock) {
    changed_.wait(lock, [this] { return !is_asked_; });
}

void BatchLoader::work() {
    std::unique_lock lock(mutex_);
    while (true) {
        changed_.wait(lock, [this] { return is_asked_ || is_over_; });
        if (is_over_) return;
        lock.unlock();
        std::exception_ptr failure;
        try {
            batch_.rows.resize(at(lanes_) * kFeatureDim * order_.to_user.size());
            gather_lanes(features_, batch_.shapes, order_, std::span<float>(batch_.rows),
                         GatherThreads::one);
        } catch (...) {
            failure = std::current_exception();
        }
        lock.lock();
        failure_ = std::move(failure);
        is_asked_ = false;
        changed_.notify_all();
    }
}

}  // namespace mscomp::nn
