// SPDX-License-Identifier: MIT
#include "mscomp/base/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "mscomp/base/error.h"

namespace mscomp {
namespace {

std::string reason(int error_number) { return std::generic_category().message(error_number); }

std::string folder_of(const std::string& path) {
    const std::string folder = std::filesystem::path(path).parent_path().string();
    return folder.empty() ? "." : folder;
}

void create_folder(const std::string& folder, const std::string& path) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) {
        throw IoError(path, fmt::format("cannot create folder '{}': {}", folder, error.message()));
    }
}

/// A rename would replace a folder's or a device's entry, which nobody asks for with `-o`.
void refuse_special_target(const std::string& path) {
    struct stat info {};
    if (::stat(path.c_str(), &info) != 0) return;
    if (S_ISDIR(info.st_mode)) throw IoError(path, "is a folder, cannot write a file there");
    if (!S_ISREG(info.st_mode)) throw IoError(path, "is not a regular file, will not replace it");
}

int open_new_beside(const std::string& path, std::string& temporary) {
    static std::atomic<unsigned> counter{0};
    for (;;) {
        temporary = fmt::format("{}.tmp{}-{}", path, ::getpid(), counter++);
        const int descriptor =
            ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (descriptor >= 0 || errno != EEXIST) return descriptor;
    }
}

void sync_folder(const std::string& path) {
    const int descriptor = ::open(folder_of(path).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0) throw IoError(path, "cannot open its folder: " + reason(errno));
    const int failed = ::fsync(descriptor) != 0 ? errno : 0;
    ::close(descriptor);
    // Some file systems cannot sync folders and say so; there is nothing more to be done then.
    if (failed != 0 && failed != EINVAL && failed != ENOTSUP) {
        throw IoError(path, "cannot sync its folder: " + reason(failed));
    }
}

/// Calls use(bytes) on consecutive pieces of an open file; false if reading failed.
template <class Use>
bool read_pieces(std::FILE* file, Use&& use) {
    std::vector<char> piece(std::size_t{1} << 20);
    for (;;) {
        const std::size_t got = std::fread(piece.data(), 1, piece.size(), file);
        if (got == 0) return std::ferror(file) == 0;
        use(std::string_view(piece.data(), got));
    }
}

}  // namespace

struct AtomicFile::Digest {
    Digest() { XXH3_64bits_reset(&state); }
    void update(const void* data, std::size_t size) { XXH3_64bits_update(&state, data, size); }
    std::uint64_t value() const { return XXH3_64bits_digest(&state); }

    XXH3_state_t state;
};

AtomicFile::AtomicFile(std::string path)
    : path_(std::move(path)), digest_(std::make_unique<Digest>()) {
    refuse_special_target(path_);
    create_folder(folder_of(path_), path_);
    const int descriptor = open_new_beside(path_, temporary_);
    if (descriptor < 0) throw IoError(path_, "cannot create: " + reason(errno));
    file_ = ::fdopen(descriptor, "wb");
    if (file_ == nullptr) {
        const int failed = errno;
        ::close(descriptor);
        ::unlink(temporary_.c_str());
        throw IoError(path_, "cannot create: " + reason(failed));
    }
}

AtomicFile::~AtomicFile() {
    if (file_ != nullptr) std::fclose(file_);
    if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void AtomicFile::fail(std::string_view doing) const {
    throw IoError(path_,
                  fmt::format("cannot {}: {}; nothing was changed there", doing, reason(errno)));
}

void AtomicFile::write(std::span<const std::byte> bytes) {
    if (bytes.empty()) return;
    digest_->update(bytes.data(), bytes.size());
    errno = 0;
    if (std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size()) fail("write");
}

void AtomicFile::write(std::string_view text) {
    write(std::as_bytes(std::span<const char>(text.data(), text.size())));
}

void AtomicFile::close_checked() {
    errno = 0;
    if (std::fflush(file_) != 0) fail("write");
    if (::fsync(::fileno(file_)) != 0) fail("write to disk");
    if (std::fclose(std::exchange(file_, nullptr)) != 0) fail("close");
}

void AtomicFile::compare_with_written() const {
    std::FILE* file = std::fopen(temporary_.c_str(), "rb");
    if (file == nullptr) fail("read back");
    Digest found;
    const bool complete = read_pieces(
        file, [&](std::string_view piece) { found.update(piece.data(), piece.size()); });
    const int failed = errno;
    std::fclose(file);
    errno = failed;
    if (!complete) fail("read back");
    if (found.value() != digest_->value()) {
        throw IoError(path_,
                      "what was read back differs from what was written; the disk or its "
                      "connection is faulty; nothing was changed there");
    }
}

void AtomicFile::commit(const Check& check) {
    close_checked();
    compare_with_written();
    if (check) check(temporary_);
    if (std::rename(temporary_.c_str(), path_.c_str()) != 0) fail("rename the finished file");
    temporary_.clear();
    sync_folder(path_);
}

void write_file(const std::string& path, std::string_view text) {
    AtomicFile file(path);
    file.write(text);
    file.commit();
}

std::string read_file(const std::string& path) {
    struct stat info {};
    if (::stat(path.c_str(), &info) != 0) throw IoError(path, "cannot open: " + reason(errno));
    if (S_ISDIR(info.st_mode)) throw IoError(path, "is a folder, wanted a file");
    std::FILE* file = std::fopen(path.c_str(), "rb");
    if (file == nullptr) throw IoError(path, "cannot open: " + reason(errno));
    std::string text;
    if (S_ISREG(info.st_mode)) text.reserve(static_cast<std::size_t>(info.st_size));
    errno = 0;
    const bool complete = read_pieces(file, [&](std::string_view piece) { text += piece; });
    const int failed = errno;
    std::fclose(file);
    if (!complete) throw IoError(path, "cannot read: " + reason(failed));
    return text;
}

}  // namespace mscomp
