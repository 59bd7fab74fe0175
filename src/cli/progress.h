// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <cstdio>
#include <functional>
#include <string>
#include <string_view>

namespace mscomp {

enum class ProgressStyle {
    automatic,  // bar if the stream is a terminal, lines otherwise
    bar,        // one line that is redrawn, at most ten times a second
    lines,      // one line when another tenth is done, at most every two seconds, and the last one
    silent
};

struct ProgressOptions {
    ProgressStyle style = ProgressStyle::automatic;
    std::int64_t first = 0;         // already done at the start, e.g. by a resumed run
    std::FILE* stream = stderr;     // borrowed
    std::function<double()> clock;  // seconds; empty: the steady clock
};

/// How far a long task is, with the time it will still take:
/// `extract  45 %  32/71  0:12 left  <text>`. What cannot be written is lost. Not for use from
/// several threads at once.
class Progress {
  public:
    Progress(std::string_view title, std::int64_t total, ProgressOptions options = {});
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;
    ~Progress();  // leaves the terminal at the beginning of a line

    /// `done` of `total`; `text` is shown behind, e.g. the loss terms.
    void update(std::int64_t done, std::string_view text = {});

  private:
    bool is_due(std::int64_t done, double now) const;
    std::string describe(std::int64_t done, double now, std::string_view text) const;
    void draw_bar(std::int64_t done, const std::string& description);

    std::string title_;
    std::int64_t total_;
    ProgressOptions options_;
    double start_;
    double last_drawn_;
    std::int64_t last_tenth_ = 0;
    bool was_drawn_ = false;
    bool is_line_open_ = false;
};

/// Silent when `quiet`, otherwise automatic.
ProgressOptions progress_options(bool quiet, std::int64_t first = 0);

/// 75 -> "1:15", 3725 -> "1:02:05".
std::string duration_text(double seconds);

}  // namespace mscomp
