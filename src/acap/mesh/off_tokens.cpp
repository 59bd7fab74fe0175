// SPDX-License-Identifier: MIT
#include "off_tokens.h"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "mscomp/base/index.h"

namespace mscomp {
namespace {

struct Token {
    double value = 0;
    std::int64_t line = 0;
    bool is_whole = false;
};

/// All numbers up to the end; none if something else is among them.
std::optional<std::vector<Token>> tokens_from(TextCursor& cursor) {
    std::vector<Token> tokens;
    for (skip_to_off_content(cursor); !cursor.at_end(); skip_to_off_content(cursor)) {
        const std::string_view text = cursor.token();
        const NumberText number = read_number(text.data(), text.data() + text.size());
        const bool is_finite = number.kind == NumberText::Kind::finite;
        if (!is_finite || number.end != text.data() + text.size()) return std::nullopt;
        tokens.push_back({number.value, cursor.line(),
                          text.find_first_not_of("+-0123456789") == std::string_view::npos});
        cursor.skip_token();
    }
    return tokens;
}

class TokenReader {
  public:
    TokenReader(std::vector<Token> tokens, const OffHeader& header)
        : tokens_(std::move(tokens)), header_(header), vertex_count_(at(header.vertex_count)) {}

    std::optional<PolygonMesh> read() {
        for (const std::size_t length : vertex_lengths()) {
            for (const int face_numbers : {0, kToLineEnd, 3, 4, 1}) {
                if (reads(length, face_numbers)) return std::move(mesh_);
            }
        }
        return std::nullopt;
    }

  private:
    static constexpr int kToLineEnd = -1;

    /// How many numbers a vertex may have.
    std::vector<std::size_t> vertex_lengths() const {
        const std::size_t others =
            3 + (header_.has_normals ? 3u : 0u) + (header_.has_texture ? 2u : 0u);
        std::vector<std::size_t> lengths;
        if (const std::size_t length = length_of_lines(); length >= others) {
            lengths.push_back(length);
        }
        if (!header_.has_colors) lengths.push_back(others);
        if (header_.has_colors) lengths.insert(lengths.end(), {others + 4, others + 3});
        return lengths;
    }

    /// Numbers in each of the first V lines if they all have as many, or 0.
    std::size_t length_of_lines() const {
        std::size_t length = 0, begin = 0;
        for (std::size_t vertex = 0; vertex < vertex_count_; ++vertex) {
            std::size_t end = begin;
            while (end < tokens_.size() && tokens_[end].line == tokens_[begin].line) ++end;
            if (end == begin || (vertex > 0 && end - begin != length)) return 0;
            length = end - begin;
            begin = end;
        }
        return length;
    }

    bool reads(std::size_t vertex_length, int face_numbers) {
        mesh_ = {};
        next_ = vertex_count_ * vertex_length;
        if (next_ > tokens_.size()) return false;
        for (std::size_t i = 0; i < vertex_count_; ++i) {
            const Token* const row = tokens_.data() + i * vertex_length;
            mesh_.vertices.push_back({row[0].value, row[1].value, row[2].value});
        }
        for (std::int64_t i = 0; i < header_.face_count; ++i) {
            if (!reads_face(face_numbers)) return false;
        }
        return next_ == tokens_.size() && !mesh_.ends.empty();
    }

    bool reads_face(int numbers_behind) {
        if (next_ == tokens_.size()) return false;
        const Token& count = tokens_[next_++];
        const auto left = static_cast<double>(tokens_.size() - next_);
        if (!count.is_whole || count.value < 1 || count.value > left) return false;
        for (auto corners = static_cast<std::int64_t>(count.value); corners > 0; --corners) {
            const Token& corner = tokens_[next_++];
            const bool is_vertex = corner.is_whole && corner.value >= 0 &&
                                   corner.value < static_cast<double>(vertex_count_);
            if (!is_vertex) return false;
            mesh_.corners.push_back(static_cast<int>(corner.value));
        }
        const std::int64_t line = tokens_[next_ - 1].line;
        mesh_.finish_face([&] { return fmt::format("line {}", line); });
        const std::size_t begin = next_;
        if (numbers_behind == kToLineEnd) {
            while (next_ < tokens_.size() && tokens_[next_].line == line) ++next_;
        } else {
            next_ += static_cast<std::size_t>(numbers_behind);
        }
        if (next_ != begin) mesh_.leave_unused("face colours");
        return next_ <= tokens_.size();
    }

    std::vector<Token> tokens_;
    const OffHeader& header_;
    std::size_t vertex_count_;
    std::size_t next_ = 0;
    PolygonMesh mesh_;
};

}  // namespace

std::optional<PolygonMesh> read_off_tokens(TextCursor cursor, const OffHeader& header) {
    auto tokens = tokens_from(cursor);
    if (!tokens) return std::nullopt;
    return TokenReader(std::move(*tokens), header).read();
}

}  // namespace mscomp
