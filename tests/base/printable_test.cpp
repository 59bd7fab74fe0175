// SPDX-License-Identifier: MIT
#include "mscomp/base/printable.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "mscomp/base/json_text.h"

namespace mscomp {
namespace {

TEST(Printable, LeavesTextOfEveryLanguage) {
    for (const std::string text : {"", "frame 1.obj",
                                   "Gr\xc3\xb6\xc3\x9f"
                                   "e",
                                   "\xe6\x97\xa5\xe6\x9c\xac", "\xf0\x9f\x98\x80",
                                   "\xd8\xb4\xe2\x80\x8c\xd9\x87", "\xc2\xa0"}) {
        EXPECT_EQ(printable(text), text);
    }
}

TEST(Printable, ReplacesWhatSteersATerminal) {
    EXPECT_EQ(printable("\x1b[2J\a\b\t\r\n\x7f"), "?[2J??????");
    EXPECT_EQ(printable(std::string("a\0b", 3)), "a?b");
    EXPECT_EQ(printable("\xc2\x80\xc2\x9b\xc2\x9f"), "???");
    EXPECT_EQ(printable("\xe2\x80\xa8\xe2\x80\xa9"), "??");
}

TEST(Printable, ReplacesWhatReordersTheLine) {
    EXPECT_EQ(printable("\xe2\x80\xaa\xe2\x80\xae\xe2\x81\xa6\xe2\x81\xa9\xe2\x80\x8e\xd8\x9c"),
              "??????");
}

// Every form of a byte sequence that is no UTF-8: alone, cut off, too long, a surrogate, too large.
TEST(Printable, ReplacesWhatIsNoUtf8) {
    EXPECT_EQ(printable("\x9b"), "?");
    EXPECT_EQ(printable("a\xc3"), "a?");
    EXPECT_EQ(printable("\xc0\x9b"), "??");
    EXPECT_EQ(printable("\xe0\x82\x9b"), "???");
    EXPECT_EQ(printable("\xed\xa0\x80"), "???");
    EXPECT_EQ(printable("\xf4\x90\x80\x80"), "????");
    EXPECT_EQ(printable("\xff\xfe"), "??");
    EXPECT_EQ(printable("\xe2\x28\xa1"), "?(?");
}

TEST(Printable, OfEveryPairOfBytesIsPrintable) {
    for (int a = 0; a < 256; ++a) {
        for (int b = 0; b < 256; ++b) {
            const std::string text{static_cast<char>(a), static_cast<char>(b)};
            EXPECT_EQ(printable(printable(text)), printable(text));
            EXPECT_EQ(printable(text).find_first_of("\x1b\n\r\x7f"), std::string::npos);
        }
    }
}

TEST(Printable, LinesStayLines) { EXPECT_EQ(printable_lines("a\n\x1b\r\nb\n"), "a\n??\nb\n"); }

TEST(WholeCharacters, EndWhereACharacterEnds) {
    EXPECT_EQ(whole_characters("a\xc3\xb6", 2), "a");
    EXPECT_EQ(whole_characters("a\xc3\xb6", 3), "a\xc3\xb6");
    EXPECT_EQ(whole_characters("\xf0\x9f\x98\x80", 3), "");
    EXPECT_EQ(whole_characters("abc", 9), "abc");
}

TEST(JsonText, IsHarmlessAndReadsBackAsItWas) {
    const nlohmann::json value{{"\x1b[1m", "\xc2\x9b\xe2\x80\xae\x7f\n"},
                               {"b", {1, 2.5, "\xc3\xb6"}}};
    for (const int indent : {-1, 2}) {
        const std::string text = json_text(value, indent);
        EXPECT_EQ(printable_lines(text), text);
        EXPECT_EQ(nlohmann::json::parse(text), value);
    }
    EXPECT_EQ(json_text(nlohmann::json("\xc3\xb6")), "\"\xc3\xb6\"");
}

TEST(JsonText, TakesTextThatIsNoUtf8) {
    EXPECT_EQ(json_text(nlohmann::json("a\xff")), "\"a\xef\xbf\xbd\"");
}

}  // namespace
}  // namespace mscomp
