// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "mscomp/base/error.h"
#include "mscomp/base/printable.h"

// JSON in and out. Texts that are written need not be UTF-8 (file names), texts that are read need
// not be harmless.

namespace mscomp {

/// `value` as text; `indent` as of nlohmann::json::dump. A byte that is no UTF-8 becomes U+FFFD,
/// what could steer a terminal is escaped. Throws nothing but std::bad_alloc.
template <class Json>
std::string json_text(const Json& value, int indent = -1) {
    return escaped_json(value.dump(indent, ' ', false, Json::error_handler_t::replace));
}

/// Throws InputError with line and column unless `text` is one JSON value, nested at most 64 levels
/// deep, whose objects name nothing twice.
void require_sound_json(std::string_view text, const std::string& path);

/// The value that `text`, read from `path`, holds. Throws InputError as require_sound_json does.
template <class Json>
Json parsed_json(std::string_view text, const std::string& path) {
    require_sound_json(text, path);
    return Json::parse(text);
}

/// The same; nothing where that throws.
template <class Json>
std::optional<Json> sound_json(std::string_view text) {
    try {
        return parsed_json<Json>(text, "");
    } catch (const InputError&) {
        return std::nullopt;
    }
}

}  // namespace mscomp
