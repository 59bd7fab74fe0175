// SPDX-License-Identifier: MIT
#include "training_log.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <sstream>
#include <utility>

#include "base/failed_call.h"
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
    MetricsRow row;
    for (std::int64_t n = 2; std::getline(lines, line) && fields(line) == fields(head); ++n) {
        row = metrics_row(line, row, {path, n});
        if (row.epoch > epoch) break;
        kept += line + "\n";
    }
    return kept;
}

}  // namespace

std::string kept_metrics(const std::string& path, const std::vector<std::string>& terms,
                         std::int64_t epoch) {
    return kept_rows(path, header(terms), epoch);
}

LineFile::LineFile(std::string path)
    : path_(std::move(path)),
      descriptor_(::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666)) {
    struct stat info {};
    if (descriptor_ < 0 || ::fstat(descriptor_, &info) != 0) fail(path_, "open", errno);
    size_ = info.st_size;
}

LineFile::~LineFile() {
    try {
        write();
    } catch (const IoError&) {
        // A command that failed has said why; what happened is in the log as far as it can be.
    }
    ::close(descriptor_);
}

void LineFile::append(std::string_view line) { lines_ += printable(line) + '\n'; }

void LineFile::write() const {
    for (std::size_t done = 0; done < lines_.size();) {
        const ssize_t now = ::pwrite(descriptor_, lines_.data() + done, lines_.size() - done,
                                     size_ + static_cast<off_t>(done));
        if (now < 0 && errno == EINTR) continue;
        if (now <= 0) {
            const int failed = errno;
            // No half line; if it stays nevertheless, who reads passes over it.
            [[maybe_unused]] const int cut = ::ftruncate(descriptor_, size_);
            fail(path_, "write", failed);
        }
        done += static_cast<std::size_t>(now);
    }
}

bool LineFile::is_as_written() const {
    std::string found(lines_.size(), '\0');
    std::size_t count = 0;
    while (count < found.size()) {
        const ssize_t now = ::pread(descriptor_, found.data() + count, found.size() - count,
                                    size_ + static_cast<off_t>(count));
        if (now < 0 && errno == EINTR) continue;
        if (now <= 0) return false;
        count += static_cast<std::size_t>(now);
    }
    return found == lines_;
}

void LineFile::sync() {
    if (lines_.empty()) return;
    write();
    if (::fsync(descriptor_) != 0) fail(path_, "write to disk", errno);
    if (!is_as_written()) {
        throw IoError(path_,
                      "what was read back differs from what was written; the disk or its "
                      "connection is faulty");
    }
    size_ += static_cast<std::int64_t>(lines_.size());
    lines_.clear();
}

MetricsFile::MetricsFile(const std::string& path, std::vector<std::string> terms,
                         std::int64_t epoch)
    : terms_(std::move(terms)), file_([&] {
          write_file(path, kept_metrics(path, terms_, epoch));
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
