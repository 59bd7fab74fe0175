// SPDX-License-Identifier: MIT
#include "mscomp/base/output_folder.h"

#include <sys/stat.h>

#include <cerrno>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <system_error>
#include <utility>

#include "failed_call.h"
#include "folder_entries.h"
#include "folder_exchange.h"
#include "in_place_exchange.h"
#include "mscomp/base/error.h"
#include "mscomp/base/outputs.h"
#include "staged_names.h"
#include "staging_folder.h"
#include "temporary_file.h"
#include "temporary_place.h"

namespace fs = std::filesystem;

namespace mscomp {
namespace {

/// Where the folder is, through symbolic links: one that leads to a folder is not to be replaced.
std::string real_path(const std::string& folder) {
    std::error_code error;
    const fs::path real = fs::canonical(folder, error);
    if (!error) return real.string();
    std::error_code ignored;
    if (error != std::errc::no_such_file_or_directory || fs::is_symlink(folder, ignored)) {
        throw IoError(folder, "cannot open the folder: " + error.message());
    }
    // "x/." and "x/" are x.
    fs::path path = fs::path(folder).lexically_normal();
    if (path.filename().empty() || path.filename() == ".") path = path.parent_path();
    return path.string();
}

/// What is ready in a staging folder; `shown` is what an error names.
std::vector<std::string> ready_in(const std::string& staging, const std::string& shown) {
    const std::string folder = new_files(staging);
    // Writing may have failed, and then cleaning up.
    remove_dead_temporaries(folder);
    const std::optional<std::vector<std::string>> names = names_in(folder);
    if (!names) fail(shown, "read the folder of what was written", errno);
    return *names;
}

}  // namespace

struct OutputFolder::State {
    explicit State(const std::string& folder)
        : target(real_path(folder)),
          staging(target, StagingFolder::Place::beside),
          name(new_files(staging.path()), folder) {}

    std::string target;
    StagingFolder staging;
    StagedName name;
    std::set<std::string> dropped;
};

OutputFolder::OutputFolder(const std::string& folder) : state_(std::make_unique<State>(folder)) {}
OutputFolder::~OutputFolder() = default;

std::string OutputFolder::path(const std::string& name) const {
    refuse_special_target(state_->target + "/" + name);
    return new_files(state_->staging.path()) + "/" + name;
}

void OutputFolder::drop(const std::string& name) { state_->dropped.insert(name); }

void OutputFolder::commit() {
    const std::string& staged = state_->staging.path();
    const std::vector<std::string> names = ready_in(staged, final_name(new_files(staged) + "/"));
    for (const std::string& name : names) state_->dropped.erase(name);
    const FolderLock lock(state_->target);
    const bool is_exchanged = !state_->staging.is_inside() &&
                              exchange_folder(state_->target, staged, names, state_->dropped);
    if (is_exchanged) return;
    create_folder(state_->target);
    move_into(state_->target, staged, names, {state_->dropped.begin(), state_->dropped.end()});
}

struct OutputFiles::State {
    /// The files of one folder.
    struct Group {
        Group(const std::string& folder, const std::string& first_path)
            : target(real_path(folder)),
              staging(target, StagingFolder::Place::inside),
              name(new_files(staging.path()), folder),
              first(first_path) {}

        std::string target;
        StagingFolder staging;
        StagedName name;
        std::string first;  // of its files, as it was given
    };
    std::map<std::string, Group> groups;        // by folder
    std::map<std::string, std::string> places;  // what is replaced, by the path that was given
};

OutputFiles::OutputFiles(const std::vector<std::string>& paths)
    : state_(std::make_unique<State>()) {
    for (const std::string& path : paths) {
        refuse_special_target(path);
        const std::string place = behind_links(path);
        state_->groups.try_emplace(folder_of(place), folder_of(place), path);
        state_->places[path] = place;
    }
}
OutputFiles::~OutputFiles() = default;

std::string OutputFiles::path(const std::string& path) const {
    const std::string& place = state_->places.at(path);
    const State::Group& group = state_->groups.at(folder_of(place));
    return new_files(group.staging.path()) + "/" + fs::path(place).filename().string();
}

void OutputFiles::commit() {
    for (const auto& [folder, group] : state_->groups) {
        const FolderLock lock(group.target);
        const std::string& staged = group.staging.path();
        move_into(group.target, staged, ready_in(staged, group.first), {});
    }
}

void recover_folder(const std::string& folder) { remove_dead_temporaries(folder); }

}  // namespace mscomp
