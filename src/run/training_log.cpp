// SPDX-License-Identifier: MIT
#include "training_log.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <sstream>
#include <utility>

#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/base/paths.h"
#include "mscomp/base/printable.h"
#include "mscomp/run/metrics_row.h"

namespace mscomp {
namespace {

std::string header(const std::vector<std::string>& terms) {
    return fmt::format("epoch,step,total,{},learning_rate,touched,step_ms", fmt::join(terms, ","));
}

/// Whole rows up to `epoch`; a row cut off by a kill has fewer fields and ends the text. Throws
/// InputError for a row that is none.
std::string kept_rows(const std::string& path, const std::string& head, std::int64_t epoch) {
    std::string kept = head + "\n";
    if (epoch == 0 || !path_exists(path)) return kept;
    const auto fields = [](std::string_view line) {
        return std::count(line.begin(), line.end(), ',');
    };
    std::istringstream lines(read_file(path));
    std::string line;
    std::getline(lines, line);
    for (std::int64_t n = 2; std::getline(lines, line) && fields(line) == fields(head); ++n) {
        if (metrics_number<std::int64_t>(line, 0, {path, n}) > epoch) break;
        kept += line + "\n";
    }
    return kept;
}

}  // namespace

LineFile::LineFile(std::string path)
    : path_(std::move(path)), file_(std::fopen(path_.c_str(), "a")) {
    if (file_ == nullptr) throw IoError(path_, std::strerror(errno));
}

LineFile::~LineFile() { std::fclose(file_); }

void LineFile::append(std::string_view line) {
    const std::string text = printable(line) + '\n';
    std::fwrite(text.data(), 1, text.size(), file_);
}

void LineFile::sync() {
    const bool was_written = std::fflush(file_) == 0 && std::ferror(file_) == 0;
    if (!was_written || fsync(fileno(file_)) != 0) throw IoError(path_, std::strerror(errno));
}

MetricsFile::MetricsFile(const std::string& path, std::vector<std::string> terms,
                         std::int64_t epoch)
    : terms_(std::move(terms)), file_([&] {
          write_file(path, kept_rows(path, header(terms_), epoch));
          return path;
      }()) {}

void MetricsFile::append(const EpochReport& report) {
    std::string row =
        fmt::format("{},{},{:.9g}", report.state.epoch, report.state.step, report.total);
    for (const double term : report.terms) row += fmt::format(",{:.9g}", term);
    file_.append(row + fmt::format(",{:.9g},{:.4g},{:.4g}", report.learning_rate, report.touched,
                                   report.step_ms));
}

}  // namespace mscomp
