// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "mscomp/model/learned_model.h"

namespace mscomp {

/// A text file that grows line by line; what was appended since the last sync() is in memory.
class LineFile {
  public:
    /// Opens for appending. Throws IoError.
    explicit LineFile(std::string path);
    LineFile(const LineFile&) = delete;
    LineFile& operator=(const LineFile&) = delete;
    /// What was appended since the last sync() is written, if that is possible.
    ~LineFile();

    /// `line` as `printable` makes it.
    void append(std::string_view line);
    /// Brings the lines to disk and reads them back. Throws IoError (disk full, ...); the file then
    /// ends where it ended before, and the lines are written by the next call.
    void sync();

  private:
    void write() const;
    bool is_as_written() const;

    std::string path_, lines_;
    int descriptor_;
    std::int64_t size_ = 0;  // without `lines_`
};

/// The text of metrics.csv as a run finds it that goes on at `epoch`: the rows up to there of the
/// one at `path`, and nothing but the header at epoch 0.
std::string kept_metrics(const std::string& path, const std::vector<std::string>& terms,
                         std::int64_t epoch);

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
