// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "mscomp/model/model_file.h"

namespace mscomp {

/// The checkpoint that a run goes back to when it diverged: that of its last milestone, an epoch
/// that is a multiple of `interval`, 0 included. Checkpoints are also saved when a clock or
/// somebody says so; what a run goes back to must not depend on that, or runs that were stopped and
/// gone on with would end in other bits than those that were not. So a milestone that such a
/// checkpoint replaces is kept beside it (milestone_path) until the next one.
class Milestone {
  public:
    /// `epoch` is that of the checkpoint that is gone on from, 0 for a new run.
    Milestone(std::string run, int interval, std::int64_t epoch)
        : run_(std::move(run)), interval_(interval), saved_(epoch) {}

    bool is_at(std::int64_t epoch) const { return epoch % interval_ == 0; }
    /// Before the checkpoint is replaced by one of `epoch`. A run that is over needs no milestone.
    /// Throws IoError.
    void before_saving(std::int64_t epoch, bool is_over) const;
    void after_saving(std::int64_t epoch, bool is_over);
    /// Throws CheckpointError.
    ModelFile open() const;

  private:
    std::string run_;
    int interval_;
    std::int64_t saved_;  // epoch of the checkpoint
};

}  // namespace mscomp
