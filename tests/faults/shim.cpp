// SPDX-License-Identifier: MIT
// Preloaded into a program it makes one call of the system fail, for files below one folder:
//   MSCOMP_FAULT=CALL:KIND:N    the N-th call of that class; KIND is an errno by name, short or
//   lost
//                               (of a write), full or gone (ENOSPC or EPIPE from there on), or kill
//                               (SIGKILL before). Allocations count from where the program watches
//                               signals; writes to standard output and error are the class print
//   MSCOMP_FAULT_SCOPE=FOLDER   absolute; relative paths count as below it
//   MSCOMP_FAULT_REPORT=FILE    gets "CALL PATH" when it happens, and without MSCOMP_FAULT the
//                               number of calls of each class when the program ends
#include <dirent.h>
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* data, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
}

namespace {

enum Call {
    open_,
    mkdir_,
    read_,
    write_,
    sync_,
    rename_,
    link_,
    unlink_,
    truncate_,
    map_,
    close_,
    stat_,
    lock_,
    memory_,
    print_,
    call_count
};
constexpr std::array<const char*, call_count> kNames{
    "open",     "mkdir", "read",  "write", "sync", "rename", "link", "unlink",
    "truncate", "map",   "close", "stat",  "lock", "memory", "print"};

enum class Kind { none, error, shortened, lost, full, kill };

struct Plan {
    Call call = call_count;
    Kind kind = Kind::none;
    int error_number = 0;
    long at = 0;
};

// Nothing here may allocate: malloc itself is one of the calls.
Plan plan;
std::array<std::atomic<long>, call_count> counts;
std::array<std::atomic<bool>, 4096> is_in_scope;  // by descriptor
char scope[4096];
std::size_t scope_length = 0;
char report_path[4096];
std::atomic<bool> is_armed{false}, is_memory_armed{false};

void report(const char* text) {
    if (report_path[0] == 0) return;
    const long file =
        syscall(SYS_openat, AT_FDCWD, report_path, O_WRONLY | O_CREAT | O_APPEND, 0666);
    if (file < 0) return;
    syscall(SYS_write, file, text, std::strlen(text));
    syscall(SYS_close, file);
}

void set_kind(const char* kind) {
    struct Named {
        const char* name;
        Kind kind;
        int error_number;
    };
    constexpr std::array<Named, 9> kKinds{{{"ENOSPC", Kind::error, ENOSPC},
                                           {"EIO", Kind::error, EIO},
                                           {"EDQUOT", Kind::error, EDQUOT},
                                           {"ENOMEM", Kind::error, ENOMEM},
                                           {"short", Kind::shortened, 0},
                                           {"lost", Kind::lost, 0},
                                           {"full", Kind::full, ENOSPC},
                                           {"gone", Kind::full, EPIPE},
                                           {"kill", Kind::kill, 0}}};
    for (const Named& each : kKinds) {
        if (std::strcmp(kind, each.name) != 0) continue;
        plan.kind = each.kind;
        plan.error_number = each.error_number;
    }
}

__attribute__((constructor)) void arm() {
    if (const char* folder = std::getenv("MSCOMP_FAULT_SCOPE")) {
        std::snprintf(scope, sizeof scope, "%s", folder);
        scope_length = std::strlen(scope);
    }
    if (const char* file = std::getenv("MSCOMP_FAULT_REPORT")) {
        std::snprintf(report_path, sizeof report_path, "%s", file);
    }
    if (const char* text = std::getenv("MSCOMP_FAULT")) {
        char call[32] = "", kind[32] = "";
        if (std::sscanf(text, "%31[^:]:%31[^:]:%ld", call, kind, &plan.at) == 3) {
            set_kind(kind);
            for (int c = 0; c < call_count; ++c) {
                if (std::strcmp(call, kNames[c]) == 0) plan.call = static_cast<Call>(c);
            }
        }
    }
    is_armed = true;
}

__attribute__((destructor)) void tell_counts() {
    if (plan.kind != Kind::none) return;
    for (int c = 0; c < call_count; ++c) {
        char line[64];
        std::snprintf(line, sizeof line, "%s %ld\n", kNames[c], counts[c].load());
        report(line);
    }
}

bool is_below_scope(const char* path) {
    if (path == nullptr || path[0] == 0) return false;
    return path[0] != '/' || std::strncmp(path, scope, scope_length) == 0;
}

bool is_tracked(int descriptor) {
    return descriptor >= 0 && descriptor < static_cast<int>(is_in_scope.size()) &&
           is_in_scope[descriptor];
}

int tracked(int descriptor) {
    if (descriptor >= 0 && descriptor < static_cast<int>(is_in_scope.size())) {
        is_in_scope[descriptor] = true;
    }
    return descriptor;
}

/// The kind of fault that this call meets. Sets errno for an error.
Kind meet(Call call, const char* path) {
    if (!is_armed || (call == memory_ && !is_memory_armed)) return Kind::none;
    const long number = ++counts[call];
    const bool is_full = plan.kind == Kind::full && number > plan.at;
    if (plan.call != call || (number != plan.at && !is_full)) return Kind::none;
    if (!is_full) {
        char line[4200];
        std::snprintf(line, sizeof line, "%s %s\n", kNames[call], path);
        report(line);
    }
    if (plan.kind == Kind::kill) {
        syscall(SYS_kill, syscall(SYS_getpid), SIGKILL);
        for (;;) pause();
    }
    if (plan.error_number != 0) errno = plan.error_number;
    return plan.kind;
}

bool fails(Call call, const char* path) {
    const Kind kind = meet(call, path);
    return kind == Kind::error || kind == Kind::full;
}

template <class Function>
Function* next(Function*, const char* name) {
    return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}
#define NEXT(function) \
    static const auto real = next(static_cast<decltype(&::function)>(nullptr), #function)

/// How much of `size` bytes is written, -1 for failed, and -2 for "say that all of it is".
ssize_t allowed(int descriptor, std::size_t size) {
    const bool is_print = descriptor == STDOUT_FILENO || descriptor == STDERR_FILENO;
    if (!is_print && !is_tracked(descriptor)) return static_cast<ssize_t>(size);
    switch (meet(is_print ? print_ : write_, "a descriptor")) {
        case Kind::error:
        case Kind::full:
            return -1;
        case Kind::shortened:
            return static_cast<ssize_t>(size / 2);
        case Kind::lost:
            return -2;
        default:
            return static_cast<ssize_t>(size);
    }
}

}  // namespace

extern "C" {

#define OPEN(function)                                                     \
    int function(const char* path, int flags, ...) {                       \
        NEXT(function);                                                    \
        va_list more;                                                      \
        va_start(more, flags);                                             \
        const mode_t mode = va_arg(more, mode_t);                          \
        va_end(more);                                                      \
        if (!is_below_scope(path)) return real(path, flags, mode);         \
        return fails(open_, path) ? -1 : tracked(real(path, flags, mode)); \
    }
OPEN(open)
OPEN(open64)

#define OPENAT(function)                                                           \
    int function(int folder, const char* path, int flags, ...) {                   \
        NEXT(function);                                                            \
        va_list more;                                                              \
        va_start(more, flags);                                                     \
        const mode_t mode = va_arg(more, mode_t);                                  \
        va_end(more);                                                              \
        if (!is_below_scope(path)) return real(folder, path, flags, mode);         \
        return fails(open_, path) ? -1 : tracked(real(folder, path, flags, mode)); \
    }
OPENAT(openat)
OPENAT(openat64)

#define FOPEN(function)                                                 \
    FILE* function(const char* path, const char* mode) {                \
        NEXT(function);                                                 \
        if (is_below_scope(path) && fails(open_, path)) return nullptr; \
        return real(path, mode);                                        \
    }
FOPEN(fopen)
FOPEN(fopen64)

DIR* opendir(const char* path) {
    NEXT(opendir);
    return is_below_scope(path) && fails(open_, path) ? nullptr : real(path);
}

ssize_t write(int descriptor, const void* data, size_t size) {
    NEXT(write);
    const ssize_t part = allowed(descriptor, size);
    if (part == -1) return -1;
    return part == -2 ? static_cast<ssize_t>(size)
                      : real(descriptor, data, static_cast<size_t>(part));
}

#define PWRITE(function, Offset)                                                       \
    ssize_t function(int descriptor, const void* data, size_t size, Offset offset) {   \
        NEXT(function);                                                                \
        const ssize_t part = allowed(descriptor, size);                                \
        if (part == -1) return -1;                                                     \
        return part == -2 ? static_cast<ssize_t>(size)                                 \
                          : real(descriptor, data, static_cast<size_t>(part), offset); \
    }
PWRITE(pwrite, off_t)
PWRITE(pwrite64, off64_t)

ssize_t writev(int descriptor, const iovec* parts, int count) {
    NEXT(writev);
    return is_tracked(descriptor) && fails(write_, "a descriptor") ? -1
                                                                   : real(descriptor, parts, count);
}

ssize_t read(int descriptor, void* data, size_t size) {
    NEXT(read);
    return is_tracked(descriptor) && fails(read_, "a descriptor") ? -1
                                                                  : real(descriptor, data, size);
}

#define PREAD(function, Offset)                                                \
    ssize_t function(int descriptor, void* data, size_t size, Offset offset) { \
        NEXT(function);                                                        \
        return is_tracked(descriptor) && fails(read_, "a descriptor")          \
                   ? -1                                                        \
                   : real(descriptor, data, size, offset);                     \
    }
PREAD(pread, off_t)
PREAD(pread64, off64_t)

#define ON_DESCRIPTOR(function, call)                                                         \
    int function(int descriptor) {                                                            \
        NEXT(function);                                                                       \
        return is_tracked(descriptor) && fails(call, "a descriptor") ? -1 : real(descriptor); \
    }
ON_DESCRIPTOR(fsync, sync_)
ON_DESCRIPTOR(fdatasync, sync_)

// It closes, and says that what was written before did not arrive.
int close(int descriptor) {
    NEXT(close);
    if (!is_tracked(descriptor)) return real(descriptor);
    is_in_scope[descriptor] = false;
    const bool has_failed = fails(close_, "a descriptor");
    const int failed = errno;
    const int result = real(descriptor);
    if (!has_failed) return result;
    errno = failed;
    return -1;
}

#define TRUNCATE(function, Offset)                                        \
    int function(int descriptor, Offset size) {                           \
        NEXT(function);                                                   \
        return is_tracked(descriptor) && fails(truncate_, "a descriptor") \
                   ? -1                                                   \
                   : real(descriptor, size);                              \
    }
TRUNCATE(ftruncate, off_t)
TRUNCATE(ftruncate64, off64_t)

#define FALLOCATE(function, Offset)                                       \
    int function(int descriptor, int mode, Offset offset, Offset size) {  \
        NEXT(function);                                                   \
        return is_tracked(descriptor) && fails(truncate_, "a descriptor") \
                   ? -1                                                   \
                   : real(descriptor, mode, offset, size);                \
    }
FALLOCATE(fallocate, off_t)
FALLOCATE(fallocate64, off64_t)

#define MAP(function, Offset)                                                           \
    void* function(void* place, size_t size, int protection, int flags, int descriptor, \
                   Offset offset) {                                                     \
        NEXT(function);                                                                 \
        return is_tracked(descriptor) && fails(map_, "a descriptor")                    \
                   ? MAP_FAILED                                                         \
                   : real(place, size, protection, flags, descriptor, offset);          \
    }
MAP(mmap, off_t)
MAP(mmap64, off64_t)

int flock(int descriptor, int operation) {
    NEXT(flock);
    return is_tracked(descriptor) && fails(lock_, "a descriptor") ? -1
                                                                  : real(descriptor, operation);
}

int mkdir(const char* path, mode_t mode) {
    NEXT(mkdir);
    return is_below_scope(path) && fails(mkdir_, path) ? -1 : real(path, mode);
}

#define ON_PATH(function, call)                                             \
    int function(const char* path) {                                        \
        NEXT(function);                                                     \
        return is_below_scope(path) && fails(call, path) ? -1 : real(path); \
    }
ON_PATH(unlink, unlink_)
ON_PATH(rmdir, unlink_)
ON_PATH(remove, unlink_)

int unlinkat(int folder, const char* path, int flags) {
    NEXT(unlinkat);
    return is_below_scope(path) && fails(unlink_, path) ? -1 : real(folder, path, flags);
}

#define ON_TWO_PATHS(function, call)                                        \
    int function(const char* from, const char* to) {                        \
        NEXT(function);                                                     \
        return is_below_scope(to) && fails(call, to) ? -1 : real(from, to); \
    }
ON_TWO_PATHS(rename, rename_)
ON_TWO_PATHS(link, link_)

int renameat2(int a, const char* from, int b, const char* to, unsigned flags) noexcept {
    NEXT(renameat2);
    return is_below_scope(to) && fails(rename_, to) ? -1 : real(a, from, b, to, flags);
}

int linkat(int a, const char* from, int b, const char* to, int flags) {
    NEXT(linkat);
    return is_below_scope(to) && fails(link_, to) ? -1 : real(a, from, b, to, flags);
}

#define STAT(function, Info)                                                       \
    int function(const char* path, Info* info) {                                   \
        NEXT(function);                                                            \
        return is_below_scope(path) && fails(stat_, path) ? -1 : real(path, info); \
    }
STAT(stat, struct stat)
STAT(stat64, struct stat64)
STAT(lstat, struct stat)
STAT(lstat64, struct stat64)

#define FSTAT(function, Info)                                                                   \
    int function(int descriptor, Info* info) {                                                  \
        NEXT(function);                                                                         \
        return is_tracked(descriptor) && fails(stat_, "a descriptor") ? -1                      \
                                                                      : real(descriptor, info); \
    }
FSTAT(fstat, struct stat)
FSTAT(fstat64, struct stat64)

// The programs watch signals first of all. Before that, not even main has begun.
int sigaction(int signal, const struct sigaction* action, struct sigaction* earlier) noexcept {
    NEXT(sigaction);
    is_memory_armed = true;
    return real(signal, action, earlier);
}

void* malloc(size_t size) { return fails(memory_, "") ? nullptr : __libc_malloc(size); }
void* calloc(size_t count, size_t size) {
    return fails(memory_, "") ? nullptr : __libc_calloc(count, size);
}
void* realloc(void* data, size_t size) {
    return fails(memory_, "") ? nullptr : __libc_realloc(data, size);
}
void* memalign(size_t alignment, size_t size) {
    return fails(memory_, "") ? nullptr : __libc_memalign(alignment, size);
}
void* aligned_alloc(size_t alignment, size_t size) { return memalign(alignment, size); }
int posix_memalign(void** result, size_t alignment, size_t size) {
    void* data = memalign(alignment, size);
    if (data == nullptr) return ENOMEM;
    *result = data;
    return 0;
}

}  // extern "C"
