// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <glob.h>

#include <cerrno>
#include <filesystem>
#include <map>

#include "base/folder_entries.h"
#include "mesh_format.h"
#include "mscomp/acap/mesh/mesh_sequence.h"
#include "mscomp/acap/mesh/natural_order.h"
#include "mscomp/base/error.h"

namespace mscomp {
namespace {

namespace fs = std::filesystem;

/// Pipes, sockets and devices in a folder are nobody's meshes. A link to nowhere is: a shape that
/// is missing must be noticed; so is what cannot be looked at, and whoever reads it says why not.
bool may_be_file(const fs::path& path) {
    std::error_code error;
    const fs::file_type type = fs::status(path, error).type();
    return type == fs::file_type::regular || type == fs::file_type::not_found ||
           type == fs::file_type::none;
}

std::vector<std::string> meshes_in_folder(const std::string& folder) {
    const auto names = names_in(folder);
    if (!names) {
        throw IoError(folder, "cannot read the folder: " + std::generic_category().message(errno));
    }
    std::vector<std::string> files;
    for (const std::string& name : *names) {
        const fs::path path = fs::path(folder) / name;
        // As for globs: what programs put beside meshes, such as the side files ._a.obj of a Mac.
        if (name.starts_with('.') || !mesh_format(path.string())) continue;
        if (may_be_file(path)) files.push_back(path.string());
    }
    if (files.empty()) {
        throw UsageError(fmt::format("folder '{}' holds no {} file", folder, kMeshExtensions));
    }
    return files;
}

std::vector<std::string> matches_of(const std::string& pattern) {
    struct Result {
        glob_t found{};
        ~Result() { globfree(&found); }
    } result;
    const int status = ::glob(pattern.c_str(), GLOB_NOSORT, nullptr, &result.found);
    if (status == GLOB_NOMATCH) throw UsageError(fmt::format("nothing matches '{}'", pattern));
    if (status != 0) throw IoError(pattern, "cannot search the folders of this pattern");
    return {result.found.gl_pathv, result.found.gl_pathv + result.found.gl_pathc};
}

bool is_glob(const std::string& input) { return input.find_first_of("*?[") != std::string::npos; }

void append_input(const std::string& input, bool may_be_glob, std::vector<std::string>& files) {
    std::error_code error;
    const fs::file_status status = fs::status(input, error);
    if (fs::is_directory(status)) {
        const std::vector<std::string> found = meshes_in_folder(input);
        files.insert(files.end(), found.begin(), found.end());
    } else if (fs::exists(status)) {
        files.push_back(input);
    } else if (may_be_glob && is_glob(input)) {
        for (const std::string& match : matches_of(input)) append_input(match, false, files);
    } else if (status.type() == fs::file_type::none) {
        throw IoError(input, error.message());
    } else {
        throw UsageError(fmt::format("there is no file or folder '{}'", input));
    }
}

void refuse_repeated_files(const std::vector<std::string>& files) {
    std::map<std::string, std::string> first_name;
    for (const std::string& file : files) {
        std::error_code error;
        const fs::path real = fs::weakly_canonical(file, error);
        const auto [at, fresh] = first_name.try_emplace(error ? file : real.string(), file);
        if (!fresh) {
            throw UsageError(fmt::format("'{}' and '{}' are the same file, wanted every mesh once",
                                         at->second, file));
        }
    }
}

}  // namespace

std::vector<std::string> expand_inputs(const std::vector<std::string>& inputs) {
    if (inputs.empty()) throw UsageError("no input given, wanted mesh files, folders or patterns");
    std::vector<std::string> files;
    for (const std::string& input : inputs) append_input(input, true, files);
    refuse_repeated_files(files);
    NaturalOrder(files).sort(files);
    return files;
}

}  // namespace mscomp
