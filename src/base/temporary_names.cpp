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

struct Place {
    std::atomic<int> state{unused};
    std::array<char, 4096> path;
};

std::array<Place, 16> places;

}  // namespace

TemporaryName::TemporaryName(const std::string& path) {
    for (std::size_t k = 0; k < places.size(); ++k) {
        Place& place = places[k];
        int expected = unused;
        if (path.size() >= place.path.size()) return;
        if (!place.state.compare_exchange_strong(expected, claimed)) continue;
        std::memcpy(place.path.data(), path.c_str(), path.size() + 1);
        place.state = filled;
        place_ = static_cast<int>(k);
        return;
    }
}

void TemporaryName::forget() {
    if (place_ >= 0) places[at(place_)].state = unused;
    place_ = -1;
}

void remove_temporary_files() noexcept {
    for (const Place& place : places) {
        if (place.state == filled) ::unlink(place.path.data());
    }
}

}  // namespace mscomp
