// SPDX-License-Identifier: MIT
#include "milestone.h"

#include <filesystem>
#include <system_error>

#include "mscomp/base/error.h"
#include "mscomp/base/paths.h"
#include "mscomp/run/run_folder.h"

namespace mscomp {
namespace {

void remove(const std::string& path) {
    std::error_code error;
    std::filesystem::remove(path, error);
    if (error) throw IoError(path, error.message());
}

/// The same file under another name, or a copy where the file system has no such thing.
void put_beside(const std::string& path, const std::string& other) {
    remove(other);
    std::error_code error;
    std::filesystem::create_hard_link(path, other, error);
    if (error) std::filesystem::copy_file(path, other, error);
    if (error) throw IoError(other, error.message());
}

}  // namespace

void Milestone::before_saving(std::int64_t epoch, bool is_over) const {
    if (is_over || is_at(epoch) || !is_at(saved_)) return;
    put_beside(checkpoint_path(run_), milestone_path(run_));
}

void Milestone::after_saving(std::int64_t epoch, bool is_over) {
    saved_ = epoch;
    if (is_over || is_at(epoch)) remove(milestone_path(run_));
}

ModelFile Milestone::open() const {
    ModelFile last(checkpoint_path(run_));
    if (is_at(last.state().epoch) || !path_exists(milestone_path(run_))) return last;
    return ModelFile(milestone_path(run_));
}

}  // namespace mscomp
