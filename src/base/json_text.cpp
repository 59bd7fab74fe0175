// SPDX-License-Identifier: MIT
#include "mscomp/base/json_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "json_check.h"
#include "mscomp/base/error.h"

namespace mscomp {
namespace {

class TextCheck final : public JsonCheck {
  public:
    TextCheck(std::string_view text, const std::string& path)
        : JsonCheck(64), text_(text), path_(path) {}

    bool parse_error(std::size_t byte, const std::string&, const Json::exception&) override {
        throw InputError(position(byte), "is not valid JSON, or holds a number beyond 1.8e308");
    }

  private:
    void fail_repeated(const std::string& name) const override {
        throw InputError({path_}, fmt::format("names '{}' twice in one object", name));
    }
    void fail_deep(std::size_t most_levels) const override {
        throw InputError({path_}, fmt::format("is nested deeper than {} levels", most_levels));
    }
    /// Of a byte that counts from 1.
    FilePosition position(std::size_t byte) const {
        const std::string_view before = text_.substr(0, std::max<std::size_t>(byte, 1) - 1);
        const auto lines = std::ranges::count(before, '\n');
        const std::size_t line_begin = before.rfind('\n') + 1;  // npos + 1 is 0
        return {path_, lines + 1, static_cast<std::int64_t>(before.size() - line_begin) + 1};
    }

    std::string_view text_;
    const std::string& path_;
};

}  // namespace

void require_sound_json(std::string_view text, const std::string& path) {
    // The parser takes a zero byte for the end of its input.
    TextCheck check(text, path);
    if (const std::size_t zero = text.find('\0'); zero != std::string_view::npos) {
        throw InputError({path},
                         fmt::format("has a zero byte at byte {}, is not valid JSON", zero));
    }
    nlohmann::json::sax_parse(text, &check);
}

}  // namespace mscomp
