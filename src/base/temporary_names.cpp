// SPDX-License-Identifier: MIT
#include "temporary_names.h"

#include <unistd.h>

#include <array>
#include <atomic>
#include <cstring>

#include "mscomp/base/index.h"
#include "mscomp/base/interruption.h"

namespace mscomp {
namespace {

// A signal handler reads the table, so nothing in it is allocated or locked.
enum State : int { unused, claimed, filled };
static_assert(std::atomic<int>::is_always_lock_free);

struct NotedName {
    std::atomic<int> state{unused};
    std::array<char, 4096> path;
};

std::array<NotedName, 16> noted_names;

}  // namespace

TemporaryName::TemporaryName(const std::string& path) {
    for (std::size_t k = 0; k < noted_names.size(); ++k) {
        NotedName& name = noted_names[k];
        int expected = unused;
        if (path.size() >= name.path.size()) return;
        if (!name.state.compare_exchange_strong(expected, claimed)) continue;
        std::memcpy(name.path.data(), path.c_str(), path.size() + 1);
        name.state = filled;
        place_ = static_cast<int>(k);
        return;
    }
}

void TemporaryName::forget() {
    if (place_ >= 0) noted_names[at(place_)].state = unused;
    place_ = -1;
}

void remove_temporary_files() noexcept {
    for (const NotedName& name : noted_names) {
        if (name.state == filled) ::unlink(name.path.data());
    }
}

}  // namespace mscomp
