// SPDX-License-Identifier: MIT
#include "mscomp/base/atomic_file.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "mscomp/base/readable_file.h"
#include "temporary_file.h"

namespace mscomp {
namespace {

constexpr std::size_t kPieceBytes = std::size_t{1} << 20;

/// For what may have `bytes` bytes: small files are many, and large memory has to be cleared.
std::size_t piece_bytes(std::uint64_t bytes) {
    constexpr std::uint64_t kLeast = std::uint64_t{1} << 16;
    return std::clamp<std::uint64_t>(bytes, kLeast, kPieceBytes);
}

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
        std::vector<std::byte> piece(piece_bytes(written));
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
    const ReadableFile file(path);
    std::string text;
    text.reserve(file.size());
    std::vector<char> piece(piece_bytes(file.size()));
    while (const std::size_t got = file.read(piece)) text.append(piece.data(), got);
    return text;
}

}  // namespace mscomp
