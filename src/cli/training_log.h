// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>

#include "mscomp/nn/trainer.h"

namespace mscomp {

/// A text file that grows line by line and is on disk after sync().
class LineFile {
  public:
    /// Opens for appending. Throws IoError.
    explicit LineFile(std::string path);
    LineFile(const LineFile&) = delete;
    LineFile& operator=(const LineFile&) = delete;
    ~LineFile();

    void append(std::string_view line);
    /// Throws IoError if anything since the last call could not be written (disk full, ...).
    void sync();

  private:
    std::string path_;
    std::FILE* file_;
};

/// metrics.csv of a run: one row per epoch with the means over its steps.
/// epoch,step,total,level0_reconstruction,level0_sparsity,level0_range,...,learning_rate,touched,step_ms;
/// the terms are unweighted sums over the autoencoders of a level.
class MetricsFile {
  public:
    /// Keeps the rows of an earlier part of the run up to `epoch` and drops what came after; epoch
    /// 0 starts anew.
    MetricsFile(const std::string& path, int levels, std::int64_t epoch);
    void append(const nn::EpochReport& report);
    void sync() { file_.sync(); }

  private:
    LineFile file_;
};

/// "total 12.3  level 0: 4.5 + 0.01 + 0" for the progress line.
std::string describe_loss(const nn::EpochReport& report);

}  // namespace mscomp
