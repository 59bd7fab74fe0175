// SPDX-License-Identifier: MIT
#include "mscomp/base/json_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <set>
#include <vector>

#include "mscomp/base/error.h"

namespace mscomp {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMostLevels = 64;

/// Sees the text before a tree is made of it: what walks a tree calls itself for every level.
class JsonCheck final : public nlohmann::json_sax<Json> {
  public:
    JsonCheck(std::string_view text, const std::string& path) : text_(text), path_(path) {}

    bool null() override { return true; }
    bool boolean(bool) override { return true; }
    bool number_integer(std::int64_t) override { return true; }
    bool number_unsigned(std::uint64_t) override { return true; }
    bool number_float(double, const std::string&) override { return true; }
    bool string(std::string&) override { return true; }
    bool binary(Json::binary_t&) override { return true; }
    bool start_object(std::size_t) override { return open(); }
    bool start_array(std::size_t) override { return open(); }
    bool end_object() override { return close(); }
    bool end_array() override { return close(); }
    bool key(std::string& name) override {
        if (keys_.back().insert(name).second) return true;
        throw InputError({path_}, fmt::format("names '{}' twice in one object", name));
    }
    bool parse_error(std::size_t byte, const std::string&, const Json::exception&) override {
        throw InputError(position(byte), "is not valid JSON, or holds a number beyond 1.8e308");
    }

  private:
    bool open() {
        if (keys_.size() == kMostLevels) {
            throw InputError({path_}, fmt::format("is nested deeper than {} levels", kMostLevels));
        }
        keys_.emplace_back();
        return true;
    }
    bool close() {
        keys_.pop_back();
        return true;
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
    std::vector<std::set<std::string>> keys_;  // of every object that is open; arrays have none
};

}  // namespace

void require_sound_json(std::string_view text, const std::string& path) {
    // The parser takes a zero byte for the end of its input.
    JsonCheck check(text, path);
    if (const std::size_t zero = text.find('\0'); zero != std::string_view::npos) {
        throw InputError({path},
                         fmt::format("has a zero byte at byte {}, is not valid JSON", zero));
    }
    Json::sax_parse(text, &check);
}

}  // namespace mscomp
