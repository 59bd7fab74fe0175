// SPDX-License-Identifier: MIT
#include "npy_header.h"

#include <fmt/format.h>

#include <charconv>
#include <set>
#include <system_error>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

constexpr std::size_t kLargestRank = 32;  // numpy's own limit

/// The few pieces of Python's syntax that numpy writes.
class DictionaryParser {
  public:
    DictionaryParser(std::string_view text, const std::string& path) : text_(text), path_(path) {}

    NpyHeader parse() {
        NpyHeader header;
        std::set<std::string> seen;
        expect('{');
        while (!take('}')) {
            const std::string key = string();
            if (!seen.insert(key).second) fail(fmt::format("has '{}' twice", key));
            expect(':');
            if (key == "descr") {
                header.descr = string();
            } else if (key == "fortran_order") {
                header.fortran_order = boolean();
            } else if (key == "shape") {
                header.shape = shape();
            } else {
                fail(fmt::format("has the unknown key '{}'", key));
            }
            if (!take(',')) {
                expect('}');
                break;
            }
        }
        skip_blanks();
        if (at_ != text_.size()) fail("goes on after its dictionary");
        for (const char* key : {"descr", "fortran_order", "shape"}) {
            if (!seen.contains(key)) fail(fmt::format("has no '{}'", key));
        }
        return header;
    }

  private:
    std::string string() {
        skip_blanks();
        const char quote = at_ < text_.size() ? text_[at_] : '\0';
        if (quote == '[') fail("describes a structured array, wanted plain numbers");
        if (quote != '\'' && quote != '"') fail("has no string here");
        const std::size_t end = text_.find(quote, at_ + 1);
        if (end == std::string_view::npos) fail("has a string without end");
        const std::string_view found = text_.substr(at_ + 1, end - at_ - 1);
        for (const char c : found) {
            if (c < 0x20 || c > 0x7e || c == '\\') fail("has an odd character in a string");
        }
        at_ = end + 1;
        return std::string(found);
    }

    bool boolean() {
        skip_blanks();
        for (const bool value : {false, true}) {
            const std::string_view word = value ? "True" : "False";
            if (text_.substr(at_).starts_with(word)) {
                at_ += word.size();
                return value;
            }
        }
        fail("has neither True nor False here");
    }

    Shape shape() {
        Shape lengths;
        bool comma = true;
        expect('(');
        while (!take(')')) {
            if (!comma) fail("has no ',' here");
            if (lengths.size() == kLargestRank) fail("has more than 32 axes");
            lengths.push_back(length());
            comma = take(',');
        }
        // In Python (7) is a number and (7,) a shape.
        if (lengths.size() == 1 && !comma) fail("has a shape without its comma, wanted '(7,)'");
        return lengths;
    }

    std::int64_t length() {
        skip_blanks();
        std::int64_t value = 0;
        const char* const begin = text_.data() + at_;
        const auto [end, error] = std::from_chars(begin, text_.data() + text_.size(), value);
        if (error != std::errc{} || value < 0) fail("has no whole number from 0 to 2^63 - 1 here");
        at_ += at(end - begin);
        return value;
    }

    void skip_blanks() {
        while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\n')) ++at_;
    }
    bool take(char c) {
        skip_blanks();
        if (at_ == text_.size() || text_[at_] != c) return false;
        ++at_;
        return true;
    }
    void expect(char c) {
        if (!take(c)) fail(fmt::format("has no '{}' here", c));
    }
    [[noreturn]] void fail(std::string_view what) const {
        throw InputError({path_},
                         fmt::format("the numpy header, at its byte {}, {}", at_ + 1, what));
    }

    std::string_view text_;
    const std::string& path_;
    std::size_t at_ = 0;
};

}  // namespace

NpyHeader parse_npy_header(std::string_view text, const std::string& path) {
    return DictionaryParser(text, path).parse();
}

Shape strides_of(const Shape& shape, bool fortran_order) {
    Shape strides(shape.size(), 1);
    if (std::find(shape.begin(), shape.end(), 0) != shape.end()) return strides;
    if (fortran_order) {
        for (std::size_t i = 1; i < shape.size(); ++i) strides[i] = strides[i - 1] * shape[i - 1];
    } else {
        for (std::size_t i = shape.size(); i-- > 1;) strides[i - 1] = strides[i] * shape[i];
    }
    return strides;
}

}  // namespace mscomp
