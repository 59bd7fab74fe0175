// SPDX-License-Identifier: MIT
#include "cli/progress.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <string>

namespace mscomp {
namespace {

using testing::HasSubstr;

class ProgressTest : public testing::Test {
  protected:
    ~ProgressTest() override { std::fclose(stream_); }

    ProgressOptions options(ProgressStyle style) {
        ProgressOptions result;
        result.style = style;
        result.stream = stream_;
        result.clock = [this] { return now_; };
        return result;
    }
    std::string written() {
        std::fseek(stream_, 0, SEEK_END);
        std::string text(static_cast<std::size_t>(std::ftell(stream_)), '\0');
        std::rewind(stream_);
        text.resize(std::fread(text.data(), 1, text.size(), stream_));
        return text;
    }

    std::FILE* stream_ = std::tmpfile();
    double now_ = 0;
};

TEST_F(ProgressTest, QuietSaysNothing) {
    EXPECT_EQ(progress_options(true).style, ProgressStyle::silent);
    Progress progress("train", 2, options(ProgressStyle::silent));
    progress.update(1);
    progress.update(2);
    EXPECT_EQ(written(), "");
}

TEST_F(ProgressTest, AFileGetsPlainLines) {
    {
        Progress progress("train", 1, options(ProgressStyle::automatic));
        progress.update(1);
    }
    const std::string text = written();
    EXPECT_EQ(text.find('\r'), std::string::npos);
    EXPECT_EQ(text, "train  100 %  1/1  0:00 in all\n");
}

// A thousand steps of a tenth of a second: every tenth takes 10 s > 2 s, so there are ten lines.
TEST_F(ProgressTest, SlowTasksGetALinePerTenth) {
    Progress progress("train", 1000, options(ProgressStyle::lines));
    for (int step = 1; step <= 1000; ++step) {
        now_ += 0.1;
        progress.update(step);
    }
    const std::string text = written();
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 10);
}

// Five seconds in all: at most one line in two seconds, and the last.
TEST_F(ProgressTest, FastTasksGetALineEveryTwoSeconds) {
    Progress progress("train", 1000, options(ProgressStyle::lines));
    for (int step = 1; step <= 1000; ++step) {
        now_ += 0.005;
        progress.update(step);
    }
    const std::string text = written();
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3);
    EXPECT_THAT(text, HasSubstr("100 %  1000/1000  0:05 in all\n"));
}

// Uniform speed: 30 of 100 steps in 60 s leave 140 s.
TEST_F(ProgressTest, TheTimeLeftIsExactAtUniformSpeed) {
    Progress progress("train", 100, options(ProgressStyle::lines));
    now_ = 60;
    progress.update(30, "total 12.5");
    EXPECT_EQ(written(), "train   30 %  30/100  2:20 left  total 12.5\n");
}

// Steps of an earlier run took no time in this one: 10 steps in 20 s, 80 to go.
TEST_F(ProgressTest, AResumedTaskMeasuresItsOwnSpeed) {
    ProgressOptions resumed = options(ProgressStyle::lines);
    resumed.first = 10;
    Progress progress("train", 100, resumed);
    now_ = 20;
    progress.update(20);
    EXPECT_THAT(written(), HasSubstr("2:40 left"));
}

TEST_F(ProgressTest, ABarIsRedrawnInPlaceAndEndsItsLine) {
    {
        Progress progress("train", 4, options(ProgressStyle::bar));
        for (int step = 1; step <= 3; ++step) {
            now_ += 1;
            progress.update(step, "total 1");
        }
    }
    const std::string text = written();
    EXPECT_EQ(std::count(text.begin(), text.end(), '\r'), 3);
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1);
    EXPECT_EQ(text.back(), '\n');
    EXPECT_THAT(text, HasSubstr("[############------------]  50 %  2/4  0:02 left  total 1"));
}

TEST_F(ProgressTest, ABarFitsItsTerminal) {
    Progress progress("train", 4, options(ProgressStyle::bar));
    progress.update(1, std::string(500, 'x'));
    EXPECT_LT(written().size(), 90u);  // 80 columns and the control characters
}

TEST_F(ProgressTest, NothingToDoIsDone) {
    Progress progress("train", 0, options(ProgressStyle::lines));
    progress.update(0);
    EXPECT_THAT(written(), HasSubstr("100 %"));
}

TEST(DurationText, IsMinutesAndSecondsOrHours) {
    EXPECT_EQ(duration_text(0.2), "0:00");
    EXPECT_EQ(duration_text(75), "1:15");
    EXPECT_EQ(duration_text(3725), "1:02:05");
    EXPECT_EQ(duration_text(-1), "0:00");
}

}  // namespace
}  // namespace mscomp
