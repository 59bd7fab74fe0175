// SPDX-License-Identifier: MIT
#include "cli/progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "cli/say.h"
#include "mscomp/base/index.h"
#include "mscomp/base/printable.h"

namespace mscomp {
namespace {

constexpr double kSecondsBetweenBars = 0.1;
constexpr double kSecondsBetweenLines = 2.0;
constexpr int kBarWidth = 24;
constexpr int kDefaultColumns = 80;

double steady_seconds() {
    const auto now = std::chrono::steady_clock::now().time_since_epoch();
    return std::chrono::duration<double>(now).count();
}

std::size_t terminal_columns(std::FILE* stream) {
    winsize size{};
    const bool is_known = ioctl(fileno(stream), TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
    return at(is_known ? size.ws_col : kDefaultColumns);
}

/// Nobody may be listening: that is no reason to stop.
void write_to(std::FILE* stream, const std::string& text) { write_all(fileno(stream), text); }

}  // namespace

Progress::Progress(std::string_view title, std::int64_t total, ProgressOptions options)
    : title_(printable(title)), total_(total), options_(std::move(options)) {
    if (!options_.clock) options_.clock = steady_seconds;
    if (options_.style == ProgressStyle::automatic) {
        const bool is_terminal = isatty(fileno(options_.stream)) != 0;
        options_.style = is_terminal ? ProgressStyle::bar : ProgressStyle::lines;
    }
    start_ = options_.clock();
    last_drawn_ = start_;
    last_tenth_ = total_ > 0 ? options_.first * 10 / total_ : 0;
}

Progress::~Progress() {
    if (is_line_open_) write_to(options_.stream, "\n");
}

bool Progress::is_due(std::int64_t done, double now) const {
    if (done >= total_) return true;
    if (options_.style == ProgressStyle::bar) {
        return !was_drawn_ || now - last_drawn_ >= kSecondsBetweenBars;
    }
    return done * 10 / total_ > last_tenth_ && now - last_drawn_ >= kSecondsBetweenLines;
}

void Progress::update(std::int64_t done, std::string_view text) {
    if (options_.style == ProgressStyle::silent) return;
    const double now = options_.clock();
    if (!is_due(done, now)) return;
    was_drawn_ = true;
    last_drawn_ = now;
    last_tenth_ = total_ > 0 ? done * 10 / total_ : 0;
    const std::string description = describe(done, now, text);
    if (options_.style == ProgressStyle::bar) {
        draw_bar(done, description);
    } else {
        write_to(options_.stream, fmt::format("{}  {}\n", title_, description));
    }
}

std::string Progress::describe(std::int64_t done, double now, std::string_view text) const {
    const double share = total_ > 0 ? static_cast<double>(done) / static_cast<double>(total_) : 1;
    std::string line = fmt::format("{:3.0f} %  {}/{}", std::floor(100 * share), done, total_);
    const std::int64_t steps = done - options_.first;
    const double elapsed = now - start_;
    if (done >= total_) {
        line += fmt::format("  {} in all", duration_text(elapsed));
    } else if (steps > 0) {
        const double left =
            elapsed / static_cast<double>(steps) * static_cast<double>(total_ - done);
        line += fmt::format("  {} left", duration_text(left));
    }
    if (!text.empty()) line += fmt::format("  {}", printable(text));
    return line;
}

void Progress::draw_bar(std::int64_t done, const std::string& description) {
    const double share = total_ > 0 ? static_cast<double>(done) / static_cast<double>(total_) : 1;
    const int filled = std::clamp(static_cast<int>(share * kBarWidth), 0, kBarWidth);
    std::string line = fmt::format("{} [{:#<{}}{:-<{}}] {}", title_, "", filled, "",
                                   kBarWidth - filled, description);
    // A line that wraps cannot be redrawn in place.
    const std::size_t columns = terminal_columns(options_.stream) - 1;
    is_line_open_ = done < total_;
    write_to(options_.stream, fmt::format("\r{}\x1b[K{}", whole_characters(line, columns),
                                          is_line_open_ ? "" : "\n"));
}

ProgressOptions progress_options(bool quiet, std::int64_t first) {
    ProgressOptions options;
    if (quiet) options.style = ProgressStyle::silent;
    options.first = first;
    return options;
}

std::string duration_text(double seconds) {
    const auto whole = static_cast<std::int64_t>(std::lround(std::max(seconds, 0.0)));
    const std::int64_t hours = whole / 3600;
    if (hours > 0) return fmt::format("{}:{:02}:{:02}", hours, whole / 60 % 60, whole % 60);
    return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

}  // namespace mscomp
