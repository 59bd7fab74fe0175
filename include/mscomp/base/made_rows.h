// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <span>
#include <vector>

namespace mscomp {

/// Rows that are made when they are asked for and kept until they are forgotten. Safe to use from
/// several threads; two that ask for the same row at a time may both make it.
class MadeRows {
  public:
    /// Valid until forgotten.
    std::span<const float> row(int index, const std::function<std::vector<float>()>& make);
    void forget(int index);

  private:
    std::mutex mutex_;
    std::map<int, std::vector<float>> rows_;
};

}  // namespace mscomp
