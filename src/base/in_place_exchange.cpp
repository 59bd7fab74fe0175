// SPDX-License-Identifier: MIT
#include "in_place_exchange.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <optional>

#include "failed_call.h"
#include "folder_entries.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "temporary_file.h"
#include "temporary_place.h"

namespace fs = std::filesystem;

namespace mscomp {
namespace {

std::string list_path(const std::string& staging) { return staging + "/files"; }

bool is_there(const std::string& path) {
    struct stat info {};
    return ::lstat(path.c_str(), &info) == 0;
}

void move(const std::string& from, const std::string& to, const std::string& path,
          const char* doing = "move the finished file to its place") {
    if (std::rename(from.c_str(), to.c_str()) != 0) fail(path, doing, errno);
}

/// How the folder is found from within the staging folder, wherever both are mounted.
std::string seen_from(const std::string& staging, const std::string& folder) {
    if (folder == folder_of(staging)) return "..";
    return "../" + fs::path(folder).filename().string();
}

/// What is moved where, as it is kept: texts that end with 0, the folder first.
struct Moves {
    std::string folder;
    std::vector<std::string> names;
};

void write_moves(const std::string& staging, const Moves& moves) {
    std::string text = seen_from(staging, moves.folder) + '\0';
    for (const std::string& name : moves.names) text += name + '\0';
    try {
        write_file(list_path(staging), text);
    } catch (const IoError& error) {
        // Nobody knows the list: it is those files that cannot be written.
        const std::string message = error.what();
        const std::size_t begin = std::min(message.size(), list_path(staging).size() + 2);
        throw IoError(moves.folder + "/" + moves.names.front(), message.substr(begin));
    }
}

/// Only what write_moves can have written: nobody else shall have us rename files elsewhere.
void require_own(const std::string& entry, bool is_folder, const std::string& staging) {
    const std::string name = is_folder && entry.starts_with("../") ? entry.substr(3) : entry;
    const bool is_name = !name.empty() && name != "." && name.find('/') == std::string::npos;
    if (is_name && (name != ".." || is_folder)) return;
    throw IoError(list_path(staging), "is no list of names");
}

Moves read_moves(const std::string& staging) {
    Moves moves;
    const std::string text = read_file(list_path(staging));
    for (std::size_t begin = 0; begin < text.size();) {
        const std::string entry = text.c_str() + begin;
        require_own(entry, begin == 0, staging);
        if (begin == 0) {
            moves.folder = path_in(staging, entry);
        } else {
            moves.names.push_back(entry);
        }
        begin += entry.size() + 1;
    }
    return moves;
}

/// Can be stopped at any point and done again.
void undo(const std::string& staging) {
    if (!is_there(list_path(staging))) return;
    constexpr const char* kDoing =
        "put back what was here, which the next command here tries again";
    const Moves moves = read_moves(staging);
    for (const std::string& name : moves.names) {
        const std::string place = moves.folder + "/" + name;
        const std::string fresh = new_files(staging) + "/" + name;
        if (!is_there(fresh) && is_there(place)) move(place, fresh, place, kDoing);
    }
    const std::optional<std::vector<std::string>> old = names_in(old_files(staging));
    if (!old) fail(moves.folder, kDoing, errno);
    for (const std::string& name : *old) {
        const std::string place = moves.folder + "/" + name;
        move(old_files(staging) + "/" + name, place, place, kDoing);
    }
    sync_folder(moves.folder, moves.folder);
    if (::unlink(list_path(staging).c_str()) != 0) fail(moves.folder, kDoing, errno);
}

}  // namespace

std::string new_files(const std::string& staging) { return staging + "/new"; }
std::string old_files(const std::string& staging) { return staging + "/old"; }

bool take_mode_and_owner(const std::string& from, const std::string& to) {
    struct stat wanted {
    }, found{};
    if (::stat(from.c_str(), &wanted) != 0 || ::stat(to.c_str(), &found) != 0) return false;
    const bool is_same_owner = wanted.st_uid == found.st_uid && wanted.st_gid == found.st_gid;
    if (!is_same_owner && ::chown(to.c_str(), wanted.st_uid, wanted.st_gid) != 0) return false;
    return ::chmod(to.c_str(), wanted.st_mode & 07777) == 0;
}

void keep_modes_and_owners(const std::string& folder, const std::string& staging,
                           const std::vector<std::string>& names) {
    for (const std::string& name : names) {
        take_mode_and_owner(path_in(folder, name), path_in(new_files(staging), name));
    }
}

void move_into(const std::string& folder, const std::string& staging,
               const std::vector<std::string>& names, const std::vector<std::string>& dropped) {
    const auto place = [&](const std::string& name) { return folder + "/" + name; };
    const auto fresh = [&](const std::string& name) { return new_files(staging) + "/" + name; };
    const auto old = [&](const std::string& name) { return old_files(staging) + "/" + name; };
    if (names.empty()) return;
    for (const std::string& name : names) refuse_special_target(place(name));
    keep_modes_and_owners(folder, staging, names);
    if (names.size() == 1 && dropped.empty()) {
        move(fresh(names[0]), place(names[0]), place(names[0]));
        return sync_folder(folder, place(names[0]));
    }
    write_moves(staging, {folder, names});
    try {
        for (const std::string& name : names) {
            if (!is_there(place(name))) continue;
            // A second name, where there can be one: the first is then never missing.
            if (::link(place(name).c_str(), old(name).c_str()) == 0) continue;
            move(place(name), old(name), place(name));
        }
        for (const std::string& name : names) move(fresh(name), place(name), place(name));
        for (const std::string& name : dropped) {
            if (is_there(place(name))) move(place(name), old(name), place(name));
        }
        sync_folder(folder, place(names[0]));
        // From here on it is done: there is nothing to be undone by.
        if (::unlink(list_path(staging).c_str()) != 0)
            fail(place(names[0]), "remove the list of what was moved", errno);
    } catch (...) {
        undo(staging);
        throw;
    }
}

void remove_staging(const std::string& staging) noexcept {
    try {
        undo(staging);
        // The last one: a list that was being written.
        for (const std::string& part : {new_files(staging), old_files(staging), staging}) {
            for (const std::string& name : names_in(part).value_or(std::vector<std::string>())) {
                ::unlink(path_in(part, name).c_str());
            }
            ::rmdir(part.c_str());
        }
    } catch (const std::exception&) {
        // It stays, with the list, for the next who writes here.
        return;
    }
}

}  // namespace mscomp
