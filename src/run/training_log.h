// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

#include "mscomp/model/learned_model.h"

namespace mscomp {

/// A text file that grows line by line and is on disk after sync().
class LineFile {
  public:
    /// Opens for appending. Throws IoError.
    explicit LineFile(std::string path);
    LineFile(const LineFile&) = delete;
    LineFile& operator=(const LineFile&) = delete;
    ~LineFile();

    /// `line` as `printable` makes it.
    void append(std::string_view line);
    /// Throws IoError if anything since the last call could not be written (disk full, ...).
    void sync();

  private:
    std::string path_;
    std::FILE* file_;
};

/// metrics.csv of a run: one row per epoch with the means over its steps.
/// epoch,step,total,<terms>,learning_rate,touched,step_ms; the terms (level0_reconstruction, ...)
/// are unweighted, those of a level summed over its autoencoders.
class MetricsFile {
  public:
    /// Keeps the rows of an earlier part of the run up to `epoch` and drops what came after; epoch
    /// 0 starts anew.
    MetricsFile(const std::string& path, std::vector<std::string> terms, std::int64_t epoch);
    const std::vector<std::string>& term_names() const { return terms_; }
    void append(const EpochReport& report);
    void sync() { file_.sync(); }

  private:
    std::vector<std::string> terms_;
    LineFile file_;
};

}  // namespace mscomp
