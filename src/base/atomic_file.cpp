// SPDX-License-Identifier: MIT
#include "mscomp/base/atomic_file.h"

#include <sys/stat.h>

#include <cerrno>
#include <cstdio>
#include <system_error>
#include <utility>
#include <vector>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "mscomp/base/error.h"
#include "temporary_file.h"

namespace mscomp {
namespace {

constexpr std::size_t kPieceBytes = std::size_t{1} << 20;

std::string reason(int error_number) { return std::generic_category().message(error_number); }

class Digest {
  public:
    Digest() { XXH3_64bits_reset(&state_); }
    void update(std::span<const std::byte> bytes) {
        XXH3_64bits_update(&state_, bytes.data(), bytes.size());
    }
    std::uint64_t value() const { return XXH3_64bits_digest(&state_); }

  private:
    XXH3_state_t state_;
};

}  // namespace

struct AtomicFile::State {
    explicit State(std::string path) : file(std::move(path)) {}

    void append(std::span<const std::byte> bytes) {
        file.write(written, bytes);
        written += bytes.size();
    }
    void flush() {
        append(waiting);
        waiting.clear();
    }
    void compare_with_written() const {
        Digest found;
        std::vector<std::byte> piece(kPieceBytes);
        std::uint64_t at = 0;
        while (const std::size_t got = file.read(at, piece)) {
            found.update(std::span(piece).first(got));
            at += got;
        }
        if (found.value() != digest.value()) file.fail_comparison();
    }

    TemporaryFile file;
    Digest digest;
    std::vector<std::byte> waiting;  // small pieces, written together
    std::uint64_t written = 0;
};

AtomicFile::AtomicFile(std::string path) : state_(std::make_unique<State>(std::move(path))) {}
AtomicFile::~AtomicFile() = default;

void AtomicFile::write(std::span<const std::byte> bytes) {
    if (bytes.empty()) return;
    state_->digest.update(bytes);
    if (state_->waiting.size() + bytes.size() > kPieceBytes) state_->flush();
    if (bytes.size() > kPieceBytes) {
        state_->append(bytes);
    } else {
        state_->waiting.insert(state_->waiting.end(), bytes.begin(), bytes.end());
    }
}

void AtomicFile::write(std::string_view text) {
    write(std::as_bytes(std::span<const char>(text.data(), text.size())));
}

void AtomicFile::commit(const Check& check) {
    state_->flush();
    state_->file.sync();
    state_->compare_with_written();
    if (check) check(state_->file.path());
    state_->file.take_place();
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
    std::vector<char> piece(kPieceBytes);
    errno = 0;
    while (const std::size_t got = std::fread(piece.data(), 1, piece.size(), file)) {
        text.append(piece.data(), got);
    }
    const int failed = std::ferror(file) != 0 ? errno : 0;
    std::fclose(file);
    if (failed != 0) throw IoError(path, "cannot read: " + reason(failed));
    return text;
}

}  // namespace mscomp
