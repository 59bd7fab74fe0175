// SPDX-License-Identifier: MIT
#include "mscomp/base/paths.h"

#include <sys/stat.h>

#include <cctype>
#include <cerrno>
#include <filesystem>
#include <system_error>

#include "folder_entries.h"
#include "mscomp/base/error.h"

namespace mscomp {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& path, const std::error_code& error) {
    throw IoError(path, error.message());
}

fs::file_status status_of(const std::string& path) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (status.type() == fs::file_type::none) fail(path, error);
    return status;
}

}  // namespace

bool path_exists(const std::string& path) { return fs::exists(status_of(path)); }

bool is_folder(const std::string& path) { return fs::is_directory(status_of(path)); }

bool is_regular_file(const std::string& path) { return fs::is_regular_file(status_of(path)); }

std::string absolute_path(const std::string& path) {
    std::error_code error;
    const fs::path absolute = fs::absolute(path, error);
    if (error) fail(path, error);
    return absolute.lexically_normal().string();
}

std::uint64_t file_size(const std::string& path) {
    std::error_code error;
    const std::uint64_t size = fs::file_size(path, error);
    if (error) fail(path, error);
    return size;
}

std::vector<std::string> files_in(const std::string& folder) {
    const auto names = names_in(folder);
    if (!names) fail(folder, std::error_code(errno, std::generic_category()));
    std::vector<std::string> files;
    for (const std::string& name : *names) {
        const fs::path path = fs::path(folder) / name;
        std::error_code unknown;  // then it is no folder
        if (!fs::is_directory(path, unknown)) files.push_back(path.string());
    }
    return files;
}

std::string extension_of(const std::string& path) {
    std::string extension = fs::path(path).extension().string();
    if (!extension.empty()) extension.erase(0, 1);
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return extension;
}

std::optional<FileIdentity> identity_of(const std::string& path) noexcept {
    struct stat info {};
    if (::stat(path.c_str(), &info) != 0) return std::nullopt;
    return FileIdentity{info.st_dev, info.st_ino};
}

}  // namespace mscomp
