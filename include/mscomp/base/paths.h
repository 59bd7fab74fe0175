// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

// What the file system says about a path, links followed. Where it cannot say (no permission, a
// name too long, links in a circle), IoError with its reason is thrown.

namespace mscomp {

/// Whether there is something at `path`; false also where a folder on the way to it is missing or a
/// file.
bool path_exists(const std::string& path);
bool is_folder(const std::string& path);
/// Neither folder nor pipe, device or socket, which may have no end or let a reader wait.
bool is_regular_file(const std::string& path);

/// `path` from the root, without "." and "..".
std::string absolute_path(const std::string& path);

/// Bytes of a regular file.
std::uint64_t file_size(const std::string& path);

/// Everything in a folder but folders, as paths, without order.
std::vector<std::string> files_in(const std::string& folder);

/// The extension in lower case without its dot: "dir/A.OBJ" -> "obj"; empty if there is none.
std::string extension_of(const std::string& path);

/// A file or folder, whatever it is called: links to it and its other names have the same.
struct FileIdentity {
    std::uint64_t device = 0, number = 0;
    bool operator==(const FileIdentity&) const = default;
    bool operator<(const FileIdentity& other) const {
        return std::tie(device, number) < std::tie(other.device, other.number);
    }
};
/// Nothing where `path` leads nowhere, or where the system does not say.
std::optional<FileIdentity> identity_of(const std::string& path) noexcept;

}  // namespace mscomp
