// SPDX-License-Identifier: MIT
#include "written_pieces.h"

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <vector>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "temporary_file.h"

namespace mscomp {
namespace {

constexpr std::uint64_t kBlockBytes = std::uint64_t{1} << 20;

}  // namespace

void WrittenPieces::note(std::uint64_t begin, std::span<const std::byte> bytes) {
    if (bytes.empty()) return;
    const Piece piece{begin + bytes.size(), XXH3_64bits(bytes.data(), bytes.size())};
    const std::lock_guard<std::mutex> lock(mutex_);
    auto first = pieces_.lower_bound(begin);
    const bool cuts_into_earlier = first != pieces_.begin() && std::prev(first)->second.end > begin;
    auto last = first;
    while (last != pieces_.end() && last->second.end <= piece.end) ++last;
    const bool cuts_into_later = last != pieces_.end() && last->first < piece.end;
    if (cuts_into_earlier || cuts_into_later) {
        throw std::logic_error("a piece was written again in part only");
    }
    pieces_.erase(first, last);
    pieces_.emplace(begin, piece);
}

bool WrittenPieces::agrees(std::uint64_t begin, std::span<const std::byte> bytes) const {
    const std::uint64_t end = begin + bytes.size();
    const std::lock_guard<std::mutex> lock(mutex_);
    for (std::uint64_t at = begin; at < end;) {
        const auto piece = pieces_.find(at);
        if (piece == pieces_.end() || piece->second.end > end) {
            throw std::logic_error("what was read is no piece that was written");
        }
        const std::uint64_t next = piece->second.end;
        if (XXH3_64bits(bytes.data() + (at - begin), next - at) != piece->second.hash) return false;
        at = next;
    }
    return true;
}

std::optional<std::uint64_t> WrittenPieces::first_hole(std::uint64_t size) const {
    std::uint64_t at = 0;
    for (const auto& [begin, piece] : pieces_) {
        if (begin != at) return at;
        at = piece.end;
    }
    if (at < size) return at;
    return std::nullopt;
}

std::uint64_t WrittenPieces::checked_hash(const TemporaryFile& file, std::uint64_t data_begin,
                                          std::uint64_t size) const {
    XXH3_state_t whole, part;
    XXH3_64bits_reset(&whole);
    XXH3_64bits_reset(&part);
    std::vector<std::byte> buffer(std::min(kBlockBytes, size));
    auto piece = pieces_.begin();
    for (std::uint64_t at = 0; at < size;) {
        const std::span<std::byte> block(buffer.data(), std::min(kBlockBytes, size - at));
        if (file.read(data_begin + at, block) != block.size()) file.fail_comparison();
        XXH3_64bits_update(&whole, block.data(), block.size());
        const std::uint64_t end = at + block.size();
        for (std::uint64_t from = at; from < end;) {
            const std::uint64_t to = std::min(end, piece->second.end);
            XXH3_64bits_update(&part, block.data() + (from - at), to - from);
            if (to == piece->second.end) {
                if (XXH3_64bits_digest(&part) != piece->second.hash) file.fail_comparison();
                XXH3_64bits_reset(&part);
                ++piece;
            }
            from = to;
        }
        at = end;
    }
    return XXH3_64bits_digest(&whole);
}

}  // namespace mscomp
