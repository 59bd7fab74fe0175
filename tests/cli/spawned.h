// SPDX-License-Identifier: MIT
#pragma once

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace mscomp {

/// A file descriptor of a test, closed when it goes.
class Stream {
  public:
    explicit Stream(int descriptor) : descriptor_(descriptor) {}
    Stream(Stream&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
    Stream& operator=(Stream&&) = delete;
    ~Stream() {
        if (descriptor_ >= 0) ::close(descriptor_);
    }
    int number() const { return descriptor_; }

    static Stream closed() { return Stream(-1); }
    static Stream of_file(const std::string& path) {
        return Stream(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666));
    }
    /// A pipe that nobody reads any more.
    static Stream without_reader() {
        int ends[2];
        if (::pipe2(ends, O_CLOEXEC) != 0) std::abort();
        ::close(ends[0]);
        return Stream(ends[1]);
    }
    /// A terminal that hung up: its other side is gone.
    static Stream hung_up_terminal() {
        const int master = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
        if (::grantpt(master) != 0 || ::unlockpt(master) != 0) std::abort();
        const int slave = ::open(::ptsname(master), O_RDWR | O_NOCTTY | O_CLOEXEC);
        ::close(master);
        return Stream(slave);
    }

  private:
    int descriptor_;
};

/// How a program of ours is started.
struct Start {
    std::vector<std::string> words;  // the file to run, then its arguments
    std::string folder = ".";
    int in = 0, out = 1, err = 2;      // -1: closed
    rlim_t memory = RLIM_INFINITY;     // bytes of addresses
    rlim_t file_size = RLIM_INFINITY;  // bytes a file may have
    double most_seconds = 60;
};

/// Runs it to its end. Returns what it exited with, 128 + the signal that ended it, or -1 where it
/// had to be killed for it took too long. Signals are as at a login, whatever the test ignores.
inline int exit_code_of(const Start& start) {
    const pid_t child = ::fork();
    if (child == 0) {
        const int wanted[3] = {start.in, start.out, start.err};
        int kept[3];
        // Away from 0 to 2 first, so that none overwrites another.
        for (int k = 0; k < 3; ++k) kept[k] = wanted[k] < 0 ? -1 : ::fcntl(wanted[k], F_DUPFD, 10);
        for (int k = 0; k < 3; ++k) {
            if (kept[k] < 0) {
                ::close(k);
            } else {
                ::dup2(kept[k], k);
                ::close(kept[k]);
            }
        }
        std::signal(SIGPIPE, SIG_DFL);
        std::signal(SIGXFSZ, SIG_DFL);
        const rlimit memory{start.memory, start.memory}, size{start.file_size, start.file_size};
        ::setrlimit(RLIMIT_AS, &memory);
        ::setrlimit(RLIMIT_FSIZE, &size);
        const rlimit no_core{0, 0};
        ::setrlimit(RLIMIT_CORE, &no_core);
        if (::chdir(start.folder.c_str()) != 0) _exit(126);
        std::vector<char*> words;
        for (const std::string& word : start.words)
            words.push_back(const_cast<char*>(word.c_str()));
        words.push_back(nullptr);
        ::execv(words[0], words.data());
        _exit(127);
    }
    const auto end =
        std::chrono::steady_clock::now() + std::chrono::duration<double>(start.most_seconds);
    int status = 0;
    while (::waitpid(child, &status, WNOHANG) == 0) {
        if (std::chrono::steady_clock::now() > end) {
            ::kill(child, SIGKILL);
            ::waitpid(child, &status, 0);
            return -1;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace mscomp
