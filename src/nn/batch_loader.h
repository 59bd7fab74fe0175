// SPDX-License-Identifier: MIT
#pragma once

#include <condition_variable>
#include <exception>
#include <mutex>
#include <span>
#include <thread>

#include "nn/lane_batch.h"

namespace mscomp::nn {

/// Gathers the next batch in a thread of its own while the one before is trained on. That thread
/// and the memory for the batch come with the first one asked for.
class BatchLoader {
  public:
    /// Borrows `order` and what `features` borrow.
    BatchLoader(const ScaledFeatures& features, const VertexOrder& order, int lanes)
        : features_(features), order_(order), lanes_(lanes) {}
    BatchLoader(const BatchLoader&) = delete;
    BatchLoader& operator=(const BatchLoader&) = delete;
    ~BatchLoader();

    /// Begins to gather shapes `which`; what was prepared before is given up.
    void prepare(std::span<const int> which);
    /// The shapes `which` if they are what is prepared, waiting for them, until the next call of
    /// prepare; otherwise null. Throws what was thrown while they were gathered.
    const LaneBatch* take(std::span<const int> which);

  private:
    void work();
    void wait(std::unique_lock<std::mutex>& lock);

    const ScaledFeatures features_;
    const VertexOrder& order_;
    const int lanes_;
    LaneBatch batch_;  // the worker's while is_asked_
    std::mutex mutex_;
    std::condition_variable changed_;
    bool is_asked_ = false, is_over_ = false;
    std::exception_ptr failure_;
    std::thread worker_;
};

}  // namespace mscomp::nn
