// SPDX-License-Identifier: MIT
#include <cmath>

#include "base/temporary_folder.h"
#include "fuzz/promises.h"
#include "fuzz/targets.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/convert/authors_text.h"

namespace mscomp::fuzz {
namespace {

constexpr std::size_t channel_count(AuthorsMatrix kind) {
    return kind == AuthorsMatrix::log_rotation ? 3 : 6;
}

void check_sound(const AuthorsText& text, AuthorsMatrix kind) {
    require(text.shape_count > 0 && text.vertex_count > 0, "there are shapes and vertices");
    require(text.channels.size() == static_cast<std::size_t>(text.shape_count) *
                                        static_cast<std::size_t>(text.vertex_count) *
                                        channel_count(kind),
            "counts agree");
    for (const float x : text.channels) require(std::isfinite(x), "numbers are finite");
}

void check_round_trip(const AuthorsText& text, AuthorsMatrix kind) {
    static const TemporaryFolder folder;
    AuthorsText zero = text;
    const bool is_rotation = kind == AuthorsMatrix::log_rotation;
    zero.channels.assign(text.channels.size() / channel_count(kind) * (is_rotation ? 6 : 3), 0);
    FeatureSet set;
    set.names.resize(static_cast<std::size_t>(text.shape_count));
    set.reference.vertices.resize(static_cast<std::size_t>(text.vertex_count));
    set.features =
        is_rotation ? join_authors_text(text, zero, "") : join_authors_text(zero, text, "");
    const std::string path = folder / "matrices.txt";
    write_authors_text(path, set, kind);
    const AuthorsText again = parse_authors_text(read_file(path), kind, path);
    require(again.shape_count == text.shape_count && again.vertex_count == text.vertex_count &&
                same_bits(again.channels, text.channels),
            "matrices survive writing and reading, bit for bit");
}

}  // namespace

void check_authors_text(std::span<const std::byte> input) {
    for (const AuthorsMatrix kind : {AuthorsMatrix::log_rotation, AuthorsMatrix::stretch}) {
        const auto text = unless_refused(
            "input", [&] { return parse_authors_text(text_of(input), kind, "input"); });
        if (!text) continue;
        check_sound(*text, kind);
        check_round_trip(*text, kind);
    }
}

}  // namespace mscomp::fuzz
