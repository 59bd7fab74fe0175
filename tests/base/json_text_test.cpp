// SPDX-License-Identifier: MIT
#include "mscomp/base/json_text.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "base/thrown_message.h"
#include "mscomp/base/parsed_number.h"

namespace mscomp {
namespace {

std::string refusal(const std::string& text) {
    return thrown_message<InputError>([&] { require_sound_json(text, "a.json"); });
}

TEST(SoundJson, IsTakenAsItIs) {
    EXPECT_EQ(parsed_json<nlohmann::json>(R"({"a": [1, {"b": null}], "c": "d"})", "a.json"),
              nlohmann::json::parse(R"({"a": [1, {"b": null}], "c": "d"})"));
    EXPECT_TRUE(sound_json<nlohmann::json>(std::string(64, '[') + std::string(64, ']')));
}

TEST(SoundJson, IsNotNestedDeep) {
    EXPECT_EQ(refusal(std::string(65, '[') + std::string(65, ']')),
              "a.json: is nested deeper than 64 levels");
    EXPECT_EQ(refusal(std::string(10'000'000, '[')), "a.json: is nested deeper than 64 levels");
    EXPECT_FALSE(sound_json<nlohmann::json>(std::string(10'000'000, '[')));
}

TEST(SoundJson, SaysWhereItEnds) {
    const std::string message = "is not valid JSON, or holds a number beyond 1.8e308";
    EXPECT_EQ(refusal("{\n  \"a\" 1\n}"), "a.json:2:7: " + message);
    EXPECT_EQ(refusal(""), "a.json:1:1: " + message);
    EXPECT_EQ(refusal("[1e999]"), "a.json:1:6: " + message);
    EXPECT_EQ(refusal("[1] 2"), "a.json:1:5: " + message);
    EXPECT_EQ(refusal(std::string("[\0]", 3)),
              "a.json: has a zero byte at byte 1, is not valid JSON");
}

TEST(SoundJson, NamesNothingTwice) {
    EXPECT_EQ(refusal(R"({"a": 1, "b": {"a": 2}, "a": 3})"),
              "a.json: names 'a' twice in one object");
}

TEST(ParsedNumber, IsAllOfTheText) {
    EXPECT_EQ(parsed_number<int>("-12"), -12);
    EXPECT_EQ(parsed_number<double>("1e3"), 1000);
    for (const char* text : {"", " 1", "1 ", "1x", "x", "+1", "0x1", "99999999999"}) {
        EXPECT_FALSE(parsed_number<int>(text)) << text;
    }
    EXPECT_FALSE(parsed_number<unsigned>("-1"));
}

}  // namespace
}  // namespace mscomp
