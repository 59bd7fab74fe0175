// SPDX-License-Identifier: MIT
#include "mscomp/convert/authors_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>

#include "base/temporary_folder.h"
#include "base/thrown_message.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"

namespace mscomp {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

const std::string kSkew = "0 -3 2  3 0 -1  -2 1 0";  // of r = (1, 2, 3)
const std::string kSymmetric = "1 2 3  2 4 5  3 5 6";

AuthorsText parse(const std::string& text, AuthorsMatrix kind) {
    return parse_authors_text(text, kind, "x.txt");
}

std::string refusal(const std::string& text, AuthorsMatrix kind) {
    return thrown_message<InputError>([&] { parse(text, kind); });
}

// The skew matrix of r maps x to the cross product r × x.
TEST(AuthorsText, ReadsTheRotationVectorOfASkewMatrix) {
    const AuthorsText text = parse(kSkew + "\n", AuthorsMatrix::log_rotation);
    EXPECT_EQ(text.shape_count, 1);
    EXPECT_EQ(text.vertex_count, 1);
    EXPECT_THAT(text.channels, ElementsAre(1, 2, 3));
}

TEST(AuthorsText, ReadsTheUpperHalfOfASymmetricMatrix) {
    const AuthorsText text =
        parse(kSymmetric + " " + kSymmetric + "\n" + kSymmetric + "\t" + kSymmetric + "  \n",
              AuthorsMatrix::stretch);
    EXPECT_EQ(text.shape_count, 2);
    EXPECT_EQ(text.vertex_count, 2);
    EXPECT_THAT(text.channels, ElementsAre(1, 2, 3, 4, 5, 6, 1, 2, 3, 4, 5, 6, 1, 2, 3, 4, 5, 6, 1,
                                           2, 3, 4, 5, 6));
}

TEST(AuthorsText, AcceptsWhatIsHarmless) {
    for (const std::string& text :
         {"\xEF\xBB\xBF" + kSkew, kSkew + "\r\n", "\n" + kSkew + "\n\n", " " + kSkew + " \n \n"}) {
        EXPECT_THAT(parse(text, AuthorsMatrix::log_rotation).channels, ElementsAre(1, 2, 3));
    }
    EXPECT_THAT(parse("1 2 3  2.00001 4 5  3 5 6", AuthorsMatrix::stretch).channels[1], 2.000005F);
    const std::string full_turns = "0 -600 0  600.02 0 0  0 0 0";
    EXPECT_THAT(parse(full_turns, AuthorsMatrix::log_rotation).channels[2], 600.01F);
}

TEST(AuthorsText, RefusesMatricesOfTheOtherKindWithTheirPlace) {
    EXPECT_THAT(refusal(kSkew + "\n" + kSymmetric, AuthorsMatrix::log_rotation),
                AllOf(HasSubstr("x.txt:2:19: "), HasSubstr("vertex 0"), HasSubstr("not skew"),
                      HasSubstr("entry 1,1 is 1")));
    EXPECT_THAT(refusal(kSymmetric + " " + kSkew, AuthorsMatrix::stretch),
                AllOf(HasSubstr("x.txt:1:"), HasSubstr("vertex 1"), HasSubstr("not symmetric"),
                      HasSubstr("entry 1,2 is -3 and entry 2,1 is 3")));
    EXPECT_THAT(refusal("0 -3 2  3.001 0 -1  -2 1 0", AuthorsMatrix::log_rotation),
                HasSubstr("not skew"));
    EXPECT_THAT(refusal("1 2 3  2 4 5  3 5.001 6", AuthorsMatrix::stretch),
                HasSubstr("entry 2,3 is 5 and entry 3,2 is 5.001"));
}

TEST(AuthorsText, RefusesOtherCountsWithTheirPlace) {
    EXPECT_THAT(refusal("1 2 3  2 4 5  3 5", AuthorsMatrix::stretch),
                AllOf(HasSubstr("x.txt:1:18: "), HasSubstr("8 numbers, expected a multiple of 9")));
    EXPECT_THAT(refusal(kSkew + " " + kSkew + "\n" + kSkew, AuthorsMatrix::log_rotation),
                AllOf(HasSubstr("x.txt:2:"), HasSubstr("9 numbers, expected 18")));
    EXPECT_THAT(refusal(kSkew + "\n" + kSkew + " 0", AuthorsMatrix::log_rotation),
                AllOf(HasSubstr("x.txt:2:24: "), HasSubstr("more than 9 numbers")));
    EXPECT_THAT(refusal("", AuthorsMatrix::stretch), HasSubstr("empty"));
    EXPECT_THAT(refusal("\n\n", AuthorsMatrix::stretch), HasSubstr("no numbers"));
}

TEST(AuthorsText, RefusesWhatIsNoFiniteNumber) {
    EXPECT_THAT(refusal("1 2 3  2 nan 5  3 5 6", AuthorsMatrix::stretch),
                AllOf(HasSubstr("x.txt:1:10: "), HasSubstr("nan"), HasSubstr("finite")));
    EXPECT_THAT(refusal("1 2 3  2 4 5  3 5 1e39", AuthorsMatrix::stretch), HasSubstr("float32"));
    EXPECT_THAT(refusal("1 2 3  2 4 5  3 5 1e999", AuthorsMatrix::stretch),
                HasSubstr("x.txt:1:19"));
    EXPECT_THAT(refusal("1 2,5 3  2 4 5  3 5 6", AuthorsMatrix::stretch),
                AllOf(HasSubstr("x.txt:1:3: "), HasSubstr("decimal comma")));
    EXPECT_THAT(refusal(kSymmetric + " x", AuthorsMatrix::stretch), HasSubstr("'x'"));
}

TEST(AuthorsText, RefusesPairsThatDoNotMatch) {
    const AuthorsText r = parse(kSkew + "\n" + kSkew, AuthorsMatrix::log_rotation);
    const AuthorsText s = parse(kSymmetric, AuthorsMatrix::stretch);
    EXPECT_THAT(thrown_message<InputError>([&] { join_authors_text(r, s, "S.txt"); }),
                HasSubstr("S.txt: 1 shapes of 1 vertices, but its LOGRNEW file has 2 of 1"));
    EXPECT_THAT(join_authors_text(parse(kSkew, AuthorsMatrix::log_rotation), s, "S.txt"),
                ElementsAre(1, 2, 3, 1, 2, 3, 4, 5, 6));
}

TEST(AuthorsText, TheSFileStandsBeside) {
    EXPECT_EQ(stretch_path_of("x/LOGRNEW_withopt.txt"), "x/S_withopt.txt");
    EXPECT_EQ(stretch_path_of("LOGRNEW.txt"), "S.txt");
    EXPECT_EQ(stretch_path_of("LOGRNEW/x.txt"), "");
}

// Nine significant digits tell every float32 from its neighbours.
TEST(AuthorsText, FloatsComeBackBitForBit) {
    FeatureSet set;
    set.names = {"a", "b"};
    set.reference.vertices.resize(500);
    std::uint32_t bits = 12345;
    while (set.features.size() < 2 * 500 * kFeatureDim) {
        bits = bits * 1664525U + 1013904223U;
        float value = 0;
        std::memcpy(&value, &bits, sizeof value);
        if (std::isfinite(value)) set.features.push_back(value);
    }
    set.features[0] = -0.0F;
    set.features[3] = -0.0F;
    set.features[10] = std::numeric_limits<float>::denorm_min();
    const TemporaryFolder folder;
    write_authors_text(folder / "r", set, AuthorsMatrix::log_rotation);
    write_authors_text(folder / "s", set, AuthorsMatrix::stretch);
    const std::vector<float> back = join_authors_text(
        parse_authors_text(read_file(folder / "r"), AuthorsMatrix::log_rotation, "r"),
        parse_authors_text(read_file(folder / "s"), AuthorsMatrix::stretch, "s"), "s");
    ASSERT_EQ(back.size(), set.features.size());
    EXPECT_EQ(std::memcmp(back.data(), set.features.data(), back.size() * sizeof(float)), 0);
}

TEST(AuthorsText, WhatIsNotFiniteIsNotWritten) {
    FeatureSet set;
    set.names = {"a"};
    set.reference.vertices.resize(1);
    set.features.assign(kFeatureDim, 0);
    set.features[8] = std::numeric_limits<float>::quiet_NaN();
    const TemporaryFolder folder;
    EXPECT_THROW(write_authors_text(folder / "s", set, AuthorsMatrix::stretch), NumericalError);
    EXPECT_THAT(folder.names(), testing::IsEmpty());
}

// The authors' own files, printed with six digits, are read and written again as the same numbers.
TEST(AuthorsText, TheirFilesAreRead) {
    const std::string base = MSCOMP_SHARED_DIR "/reference/acap-bar/";
    if (!std::filesystem::exists(base)) GTEST_SKIP() << base << " is not there";
    const AuthorsText r = parse_authors_text(read_file(base + "LOGRNEW_withopt_GT.txt"),
                                             AuthorsMatrix::log_rotation, "r");
    const AuthorsText s =
        parse_authors_text(read_file(base + "S_withopt_GT.txt"), AuthorsMatrix::stretch, "s");
    EXPECT_EQ(r.shape_count, 3);
    EXPECT_EQ(r.vertex_count, 1154);
    EXPECT_EQ(s.shape_count, 3);
    EXPECT_EQ(s.vertex_count, 1154);
    // First matrix of the second line of each file.
    EXPECT_THAT(
        std::vector<float>(r.channels.begin() + 1154 * 3, r.channels.begin() + 1154 * 3 + 3),
        ElementsAre(0.000217235F, 0.000858244F, -0.0176209F));
    EXPECT_FLOAT_EQ(s.channels[1154 * 6], 1.09346F);
}

}  // namespace
}  // namespace mscomp
