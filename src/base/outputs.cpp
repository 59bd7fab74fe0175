// SPDX-License-Identifier: MIT
#include "mscomp/base/outputs.h"

#include <fmt/format.h>

#include <cerrno>
#include <filesystem>
#include <system_error>

#include "folder_entries.h"
#include "mscomp/base/error.h"
#include "mscomp/base/output_folder.h"
#include "temporary_place.h"

namespace fs = std::filesystem;

namespace mscomp {

void require_free_file(const std::string& path, bool force) {
    std::error_code error;
    const fs::file_status status = fs::symlink_status(path, error);
    if (fs::is_directory(status)) throw UsageError(path + " is a folder; wanted a file name");
    if (!fs::exists(status) || force) return;
    // It may be one of several files whose writer was killed before the others were there.
    recover_folder(folder_of(path));
    if (fs::exists(fs::symlink_status(path, error))) {
        throw UsageError(path + " exists; --force replaces it");
    }
}

void require_free_folder(const std::string& path, bool force) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (!fs::exists(status)) return;
    if (!fs::is_directory(status)) throw UsageError(path + " is a file; wanted a folder name");
    const auto names = names_in(path);
    if (!names) throw IoError(path, std::generic_category().message(errno));
    if (!names->empty() && !force) {
        throw UsageError(path + " is not empty; --force replaces files of the same name in it");
    }
}

void create_folder(const std::string& folder, const std::string& output) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (!error) return;
    if (output.empty()) throw IoError(folder, "cannot create the folder: " + error.message());
    throw IoError(output, fmt::format("cannot create folder '{}': {}", folder, error.message()));
}

}  // namespace mscomp
