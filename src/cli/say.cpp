// SPDX-License-Identifier: MIT
#include "cli/say.h"

#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

constexpr std::size_t kMostWaiting = std::size_t{1} << 16;

/// Results that wait, and the first reason why some could not be written.
struct Results {
    std::string waiting;
    int failure = 0;
};

Results& results() {
    static Results all;
    return all;
}

void write_waiting_results() noexcept {
    Results& all = results();
    const int failure = write_all(STDOUT_FILENO, all.waiting);
    if (all.failure == 0) all.failure = failure;
    all.waiting.clear();
}

}  // namespace

int write_all(int descriptor, std::string_view text) noexcept {
    while (!text.empty()) {
        const ssize_t done = ::write(descriptor, text.data(), text.size());
        if (done > 0) {
            text.remove_prefix(at(done));
        } else if (done < 0 && errno == EAGAIN) {
            pollfd reader{descriptor, POLLOUT, 0};
            ::poll(&reader, 1, -1);
        } else if (done == 0 || errno != EINTR) {
            return done == 0 ? EIO : errno;
        }
    }
    return 0;
}

void say_lines(std::string_view text) noexcept {
    try {
        write_waiting_results();
        write_all(STDERR_FILENO, printable_lines(text));
    } catch (const std::exception&) {  // no memory for it
    }
}

void print_lines(std::string_view text) {
    results().waiting += printable_lines(text);
    if (results().waiting.size() >= kMostWaiting) flush_results();
}

void flush_results() {
    write_waiting_results();
    if (const int failure = std::exchange(results().failure, 0); failure != 0) {
        throw IoError("standard output", std::generic_category().message(failure));
    }
}

}  // namespace mscomp
