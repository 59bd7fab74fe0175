// SPDX-License-Identifier: MIT
#include "report/true_components.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "base/temporary_folder.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/base/safetensors.h"
#include "mscomp/generate/generate.h"

namespace mscomp {
namespace {

using testing::HasSubstr;

class TrueComponentsFile : public testing::Test {
  protected:
    TrueComponents read(const std::string& text) const {
        return read_true_components(folder_.put("truth.json", text));
    }
    std::string refusal(const std::string& text) const {
        try {
            read(text);
        } catch (const InputError& error) {
            return error.what();
        }
        return "accepted";
    }
    std::string supports(const Shape& shape, const std::vector<float>& values,
                         const std::string& names = "") const {
        SafetensorsWriter writer;
        writer.add<float>("supports", shape, values);
        if (!names.empty()) writer.set_metadata("names", names);
        writer.write(folder_ / "s.safetensors");
        return folder_ / "s.safetensors";
    }
    std::string refused_supports(const Shape& shape, const std::vector<float>& values,
                                 const std::string& names = "") const {
        try {
            read_true_supports(supports(shape, values, names), {"a", "b"}, 3);
        } catch (const InputError& error) {
            return error.what();
        }
        return "accepted";
    }

    TemporaryFolder folder_;
};

const std::string kRest = R"("scales": [0, 1], "frames": ["x", "y"], "weights": [[0, 0], [1, 2]]})";

TEST_F(TrueComponentsFile, IsWhatGenerateWrites) {
    const GeneratedSequence set = generate_face(7, 3, 400);
    write_generated(set, folder_ / "face");
    const TrueComponents truth = read_true_components(folder_ / "face/truth.json");
    EXPECT_EQ(truth.names, set.component_names);
    EXPECT_EQ(truth.scales, set.scales);
    EXPECT_EQ(truth.frames, set.sequence.names);
    ASSERT_EQ(truth.weights.size(), set.weights.size());
    for (std::size_t i = 0; i < truth.weights.size(); ++i) {
        EXPECT_FLOAT_EQ(static_cast<float>(truth.weights[i]), set.weights[i]);
    }
    EXPECT_EQ(read_true_supports(true_supports_path(folder_ / "face/truth.json"), truth.names,
                                 set.sequence.vertex_count()),
              set.supports);
}

TEST_F(TrueComponentsFile, PassesOverOtherKeys) {
    EXPECT_EQ(read(R"({"more": {"a": [1]}, "names": ["a", "b"], )" + kRest).count(), 2);
}

TEST_F(TrueComponentsFile, IsRefusedWithWhatIsWrong) {
    const std::string names = R"({"names": ["a", "b"], )";
    for (const auto& [text, message] : std::vector<std::pair<std::string, std::string>>{
             {"[]", "names is missing, empty or no list"},
             {R"({"names": [], )" + kRest, "names is missing, empty or no list"},
             {R"({"names": {"a": 1}, )" + kRest, "names is missing, empty or no list"},
             {R"({"names": ["a", 1], )" + kRest, "names[1] is 1, wanted a name"},
             {R"({"names": ["a", "a"], )" + kRest,
              "names[1] is \"a\", which stands before it already"},
             {R"({"names": ["a"], )" + kRest, "scales: 2 entries, wanted 1"},
             {names + R"("scales": [0, 2], "frames": ["x"], "weights": [[0, 0]]})",
              "scales[1] is 2, wanted 0 (coarse) or 1 (fine)"},
             {names + R"("scales": [0.0, 1], "frames": ["x"], "weights": [[0, 0]]})",
              "scales[0] is 0.0, wanted"},
             {names + R"("scales": [0, 1], "frames": ["x", "x"], "weights": [[0, 0]]})",
              "frames[1] is \"x\", which stands before it already"},
             {names + R"("scales": [0, 1], "frames": ["x", "y"], "weights": [[0, 0]]})",
              "weights: 1 entries, wanted 2"},
             {names + R"("scales": [0, 1], "frames": ["x"], "weights": [[0]]})",
              "weights[0] is [0], wanted a list of 2 numbers"},
             {names + R"("scales": [0, 1], "frames": ["x"], "weights": [[0, null]]})",
              "weights[0] is [0,null], wanted a list of 2 numbers"},
             {names + R"("scales": [0, 1], "frames": ["x"], "weights": [[0, 1e999]]})",
              "is not valid JSON, or holds a number beyond 1.8e308"},
             {names, "is not valid JSON"},
             {"", "is not valid JSON"},
             {std::string(100, '['), "is nested deeper"}}) {
        EXPECT_THAT(refusal(text), HasSubstr(message)) << text;
        EXPECT_THAT(refusal(text), HasSubstr("truth.json")) << text;
    }
    EXPECT_THROW(read_true_components(folder_ / "nowhere.json"), IoError);
    // What is long is not repeated.
    EXPECT_LT(refusal(R"({"names": [")" + std::string(3000, 'a') + R"(", ")" +
                      std::string(3000, 'a') + R"("], )" + kRest)
                  .size(),
              300U);
}

TEST_F(TrueComponentsFile, WeightsBelongToShapesByName) {
    const TrueComponents truth = read(R"({"names": ["a", "b"], )" + kRest);
    EXPECT_EQ(weights_of_shapes(truth, "t", {"y", "x", "y"}, "f"),
              (std::vector<double>{1, 2, 0, 0, 1, 2}));
    try {
        weights_of_shapes(truth, "t.json", {"x", "z"}, "f.safetensors");
        FAIL();
    } catch (const InputError& error) {
        EXPECT_THAT(error.what(), HasSubstr("t.json: names no frame 'z', a shape of f.saf"));
    }
}

TEST_F(TrueComponentsFile, SupportsStandBesideIt) {
    EXPECT_EQ(true_supports_path("a/truth.json"), "a/truth_supports.safetensors");
    EXPECT_EQ(true_supports_path("other"), "other_supports.safetensors");
    const std::vector<float> values{0, 0.5, 1, 1, 0, 0};
    EXPECT_EQ(read_true_supports(supports({2, 3}, values), {"a", "b"}, 3), values);
    EXPECT_EQ(read_true_supports(supports({2, 3}, values, R"(["a", "b"])"), {"a", "b"}, 3), values);
    EXPECT_THROW(read_true_supports(folder_ / "none.safetensors", {"a"}, 3), IoError);
}

TEST_F(TrueComponentsFile, SupportsOfAnotherMeshOrOutOfRangeAreRefused) {
    const std::vector<float> values{0, 0.5, 1, 1, 0, 0};
    EXPECT_THAT(refused_supports({3, 2}, values), HasSubstr("has shape [3, 2], wanted [2, 3]"));
    EXPECT_THAT(refused_supports({2, 3}, values, R"(["a", "c"])"),
                HasSubstr("holds supports of other components than the truth names"));
    EXPECT_THAT(refused_supports({2, 3}, values, "[["), HasSubstr("other components"));
    for (const float bad : {-0.1F, 1.1F, std::numeric_limits<float>::quiet_NaN(),
                            std::numeric_limits<float>::infinity()}) {
        std::vector<float> wrong = values;
        wrong[4] = bad;
        EXPECT_THAT(refused_supports({2, 3}, wrong), HasSubstr("supports[1, 1] is ")) << bad;
    }
}

}  // namespace
}  // namespace mscomp
