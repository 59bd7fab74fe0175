// SPDX-License-Identifier: MIT
#include "cli/process.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <string>

#include "mscomp/base/paths.h"

namespace mscomp {
namespace {

void open_closed_descriptors() {
    for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
        if (::fcntl(descriptor, F_GETFD) >= 0 || errno != EBADF) continue;
        // The lowest number that is free, so this one.
        ::open("/dev/null", descriptor == STDIN_FILENO ? O_WRONLY : O_RDONLY);
    }
}

/// Whether a line of /proc/self/maps, "55d0c000-55d0f000 r-xp ...", is about this address.
bool is_about(const std::string& line, std::uintptr_t address) {
    std::uintptr_t begin = 0, end = 0;
    const char* const last = line.data() + line.size();
    const auto [dash, error] = std::from_chars(line.data(), last, begin, 16);
    if (error != std::errc{} || dash == last) return false;
    if (std::from_chars(dash + 1, last, end, 16).ec != std::errc{}) return false;
    return begin <= address && address < end;
}

/// The file that the code of this function was loaded from; empty where the system does not say.
std::string own_file() {
    const auto here = reinterpret_cast<std::uintptr_t>(&own_file);
    std::ifstream maps("/proc/self/maps");
    for (std::string line; std::getline(maps, line);) {
        if (is_about(line, here)) return line.substr(std::min(line.find('/'), line.size()));
    }
    return "";
}

bool is_started_directly() {
    const auto running = identity_of("/proc/self/exe");
    return running && running == identity_of(own_file());
}

bool is_set(const char* variable) { return std::getenv(variable) != nullptr; }

/// True if it is set now and was not before.
bool sets(const char* variable, const char* value) {
    return !is_set(variable) && ::setenv(variable, value, 1) == 0;
}

/// Whether there is a setting that libraries of this process have not seen.
bool adds_settings() {
    const bool is_new_wait = !is_set("OMP_WAIT_POLICY") && sets("GOMP_SPINCOUNT", "20000");
    const bool has_openblas = ::dlsym(RTLD_DEFAULT, "openblas_set_num_threads") != nullptr;
    const bool is_new_blas = has_openblas && sets("OPENBLAS_NUM_THREADS", "1");
    return is_new_wait || is_new_blas;
}

}  // namespace

void prepare_process(char** argv) {
    open_closed_descriptors();
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);
    try {
        // Where a new start is not possible the program runs as it is.
        if (is_started_directly() && adds_settings()) ::execv("/proc/self/exe", argv);
    } catch (const std::exception&) {  // no memory: nor would there be after a new start
    }
}

}  // namespace mscomp
