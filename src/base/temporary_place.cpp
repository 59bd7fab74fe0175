// SPDX-License-Identifier: MIT
#include "temporary_place.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <filesystem>
#include <mutex>
#include <optional>
#include <set>
#include <system_error>

#include "failed_call.h"
#include "folder_entries.h"
#include "in_place_exchange.h"
#include "mscomp/base/error.h"

namespace fs = std::filesystem;

namespace mscomp {
namespace {

constexpr std::string_view kMark = ".mscomp";

/// "12" or "12-3": what stands behind the mark.
bool is_number_pair(std::string_view text) {
    const std::size_t dash = text.find('-');
    const auto is_number = [](std::string_view digits) {
        return !digits.empty() &&
               std::ranges::all_of(digits, [](char c) { return c >= '0' && c <= '9'; });
    };
    return dash != std::string_view::npos && is_number(text.substr(0, dash)) &&
           is_number(text.substr(dash + 1));
}

void remove_if_dead(const std::string& path) {
    // O_NONBLOCK: whoever put a pipe of that name there must not make us wait.
    const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOFOLLOW);
    if (descriptor < 0) return;
    struct stat info {};
    if (::fstat(descriptor, &info) == 0 && try_lock(descriptor) == Lock::taken &&
        is_named(descriptor, path)) {
        if (S_ISDIR(info.st_mode)) {
            remove_staging(path);
        } else {
            ::unlink(path.c_str());
        }
    }
    ::close(descriptor);
}

}  // namespace

std::string temporary_name(const std::string& name) {
    constexpr std::size_t kLongest = 200;  // of the 255 bytes that a name may have
    static std::atomic<unsigned> counter{0};
    return fmt::format(".{}{}{}-{}", name.substr(0, kLongest), kMark, ::getpid(), counter++);
}

bool is_temporary_name(std::string_view name) {
    const std::size_t mark = name.rfind(kMark);
    return name.starts_with('.') && mark != std::string_view::npos &&
           is_number_pair(name.substr(mark + kMark.size()));
}

std::string path_in(const std::string& folder, const std::string& name) {
    return fmt::format("{}/{}", folder, name);
}

std::string behind_links(const std::string& path) {
    std::error_code error;
    const fs::file_status status = fs::symlink_status(path, error);
    if (status.type() == fs::file_type::none) throw IoError(path, error.message());
    if (!fs::is_symlink(status)) return path;
    const fs::path file = fs::canonical(path, error);
    if (error) throw IoError(path, "is a link to nowhere: " + error.message());
    return file.string();
}

std::string folder_of(const std::string& path) {
    const std::string folder = fs::path(path).parent_path().string();
    return folder.empty() ? "." : folder;
}

Lock try_lock(int descriptor) {
    while (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
        if (errno == EINTR) continue;
        return errno == EWOULDBLOCK ? Lock::refused : Lock::unsupported;
    }
    return Lock::taken;
}

namespace {

/// None where the system does not say.
std::optional<bool> stands_for(int descriptor, const std::string& path) {
    struct stat open {
    }, named{};
    if (::fstat(descriptor, &open) != 0) return {};
    if (::lstat(path.c_str(), &named) != 0) {
        return errno == ENOENT ? std::optional<bool>(false) : std::nullopt;
    }
    return open.st_dev == named.st_dev && open.st_ino == named.st_ino;
}

}  // namespace

bool is_named(int descriptor, const std::string& path) {
    return stands_for(descriptor, path).value_or(false);
}

bool is_gone(int descriptor, const std::string& path) {
    return !stands_for(descriptor, path).value_or(true);
}

void remove_dead_temporaries(const std::string& folder) {
    const std::optional<std::vector<std::string>> names = names_in(folder);
    if (!names) return;
    for (const std::string& name : *names) {
        if (is_temporary_name(name)) remove_if_dead(path_in(folder, name));
    }
}

void remove_dead_temporaries_once(const std::string& folder) {
    static std::mutex mutex;
    static std::set<std::string> done;
    {
        const std::lock_guard<std::mutex> lock(mutex);
        if (!done.insert(folder).second) return;
    }
    remove_dead_temporaries(folder);
}

void sync_folder(const std::string& folder, const std::string& path) {
    const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0) fail(path, "open its folder", errno);
    const int failed = ::fsync(descriptor) != 0 ? errno : 0;
    ::close(descriptor);
    // Some file systems cannot sync folders and say so; there is nothing more to be done then.
    if (failed != 0 && failed != EINVAL && failed != ENOTSUP) fail(path, "sync its folder", failed);
}

}  // namespace mscomp
