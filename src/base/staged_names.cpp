// SPDX-License-Identifier: MIT
#include "staged_names.h"

#include <map>
#include <mutex>
#include <utility>

#include "mscomp/base/output_folder.h"

namespace mscomp {
namespace {

struct Staged {
    std::mutex mutex;
    std::map<std::string, std::string> folders;  // by the one in which they are made ready
};

Staged& staged() {
    static Staged all;
    return all;
}

}  // namespace

StagedName::StagedName(std::string staged_folder, const std::string& folder)
    : staged_(std::move(staged_folder)) {
    const std::lock_guard<std::mutex> lock(staged().mutex);
    staged().folders[staged_] = folder;
}

StagedName::~StagedName() {
    const std::lock_guard<std::mutex> lock(staged().mutex);
    staged().folders.erase(staged_);
}

std::string final_name(const std::string& path) {
    const std::lock_guard<std::mutex> lock(staged().mutex);
    const std::size_t slash = path.rfind('/');
    if (slash == std::string::npos) return path;
    const auto found = staged().folders.find(path.substr(0, slash));
    return found == staged().folders.end() ? path : found->second + path.substr(slash);
}

}  // namespace mscomp
