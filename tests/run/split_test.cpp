// SPDX-License-Identifier: MIT
#include "mscomp/run/split.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "base/temporary_folder.h"
#include "mscomp/base/error.h"
#include "mscomp/base/path_from.h"

namespace mscomp {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

SplitConfig split_config(SplitKind kind) {
    SplitConfig config;
    config.train = kind;
    return config;
}

// Train and test are ascending, disjoint and together 0 .. n-1.
void expect_partition(const Split& split, int shape_count) {
    EXPECT_TRUE(std::is_sorted(split.train.begin(), split.train.end()));
    EXPECT_TRUE(std::is_sorted(split.test.begin(), split.test.end()));
    std::vector<int> all = split.train;
    all.insert(all.end(), split.test.begin(), split.test.end());
    std::sort(all.begin(), all.end());
    std::vector<int> wanted(static_cast<std::size_t>(shape_count));
    std::iota(wanted.begin(), wanted.end(), 0);
    EXPECT_EQ(all, wanted);
}

class SplitFile : public testing::Test {
  protected:
    Split resolve(const std::string& text, int shape_count) {
        folder_.put("indices.txt", text);
        SplitConfig config = split_config(SplitKind::file);
        config.path = "indices.txt";
        return resolve_split(config, shape_count, folder_.path());
    }
    std::string refusal(const std::string& text, int shape_count) {
        try {
            resolve(text, shape_count);
        } catch (const InputError& error) {
            return error.what();
        }
        ADD_FAILURE() << "accepted";
        return {};
    }

    TemporaryFolder folder_;
};

TEST(Split, AllTrainsOnEverything) {
    const Split split = resolve_split(split_config(SplitKind::all), 3, "");
    EXPECT_THAT(split.train, ElementsAre(0, 1, 2));
    EXPECT_THAT(split.test, IsEmpty());
}

TEST(Split, EveryTakesMultiplesOfTheStep) {
    SplitConfig config = split_config(SplitKind::every);
    config.step = 3;
    const Split split = resolve_split(config, 8, "");
    EXPECT_THAT(split.train, ElementsAre(0, 3, 6));
    EXPECT_THAT(split.test, ElementsAre(1, 2, 4, 5, 7));
}

TEST(Split, RandomIsAPartitionThatFollowsTheSeed) {
    SplitConfig config = split_config(SplitKind::random);
    config.count = 36;
    const Split first = resolve_split(config, 71, "");
    EXPECT_EQ(first.train.size(), 36u);
    expect_partition(first, 71);
    EXPECT_EQ(resolve_split(config, 71, "").train, first.train);
    config.seed = 1;
    EXPECT_NE(resolve_split(config, 71, "").train, first.train);
}

TEST(Split, MoreTrainingShapesThanShapesIsRefused) {
    SplitConfig config = split_config(SplitKind::random);
    config.count = 6;
    EXPECT_EQ(resolve_split(config, 6, "").train.size(), 6u);
    EXPECT_THROW(resolve_split(config, 5, ""), UsageError);
}

TEST_F(SplitFile, HoldsOneIndexPerLineInAnyOrder) {
    const Split split = resolve("4\r\n 0 \n\n2", 6);
    EXPECT_THAT(split.train, ElementsAre(0, 2, 4));
    expect_partition(split, 6);
}

TEST_F(SplitFile, RefusesWithTheLine) {
    EXPECT_THAT(refusal("0\n1\nx\n", 6), HasSubstr("indices.txt:3: got \"x\", wanted one shape"));
    EXPECT_THAT(refusal("0\n6\n", 6), HasSubstr("indices.txt:2: got \"6\""));
    EXPECT_THAT(refusal("-1\n", 6), HasSubstr("indices.txt:1: "));
    EXPECT_THAT(refusal("1 2\n", 6), HasSubstr("indices.txt:1: "));
    EXPECT_THAT(refusal("1.0\n", 6), HasSubstr("indices.txt:1: "));
    EXPECT_THAT(refusal("3\n1\n3\n", 6), HasSubstr("indices.txt:3: shape 3 stands in line 1"));
    EXPECT_THAT(refusal("\n", 6), HasSubstr("no shape index"));
}

TEST(Split, AMissingFileIsAnIoError) {
    SplitConfig config = split_config(SplitKind::file);
    config.path = "/nowhere/indices.txt";
    EXPECT_THROW(resolve_split(config, 5, "elsewhere"), IoError);
}

TEST(PathFrom, CountsOnlyRelativePathsFromTheFolder) {
    EXPECT_EQ(path_from("runs", "f.safetensors"), "runs/f.safetensors");
    EXPECT_EQ(path_from("runs", "/data/f.safetensors"), "/data/f.safetensors");
    EXPECT_EQ(path_from("", "f.safetensors"), "f.safetensors");
}

}  // namespace
}  // namespace mscomp
