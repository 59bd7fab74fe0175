// SPDX-License-Identifier: MIT
#include "mscomp/acap/feature_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "base/temporary_folder.h"
#include "base/thrown_message.h"
#include "mscomp/base/error.h"
#include "mscomp/base/safetensors.h"

namespace mscomp {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Two shapes of four vertices and two faces, every number another one.
FeatureSet sample() {
    FeatureSet set;
    set.names = {"rest", "a \"quoted\" name, caf\xc3\xa9"};
    for (int i = 0; i < 2 * 4 * kFeatureDim; ++i) {
        set.features.push_back(0.1F * static_cast<float>(i) - 2);
    }
    for (int i = 0; i < 2 * 4 * 3; ++i) set.vertices.push_back(0.3F * static_cast<float>(i));
    set.reference.vertices = {{0, 0, 0}, {1, 0, 1.0 / 3}, {1, 1, 0}, {0, 1, 1e-300}};
    set.reference.faces = {{0, 1, 2}, {3, 0, 2}};
    set.rotation = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, -1, 0, 1, 0, 0, 0, 0, 1}};
    set.translation = {{0, 0, 0}, {0.1, -0.2, 7}};
    set.weights = "authors";
    set.principal_energy = {0, 1095};
    set.propagation_energy = {0.5, 20};
    set.relaxation_energy = {std::numeric_limits<double>::quiet_NaN(), 21};  // NaN: not needed
    set.consistency_energy = {0, 19.75};
    set.consistency_gap = {0, 0.5};
    set.largest_jump = {0, 0.6};
    set.large_jumps = {0, 7};
    set.inherent_jumps = {0, 4};
    set.removable_jumps = {0, 1};
    set.warnings = {"2 vertices are in no face", "another"};
    return set;
}

void expect_equal(const FeatureSet& got, const FeatureSet& expected) {
    EXPECT_EQ(got.names, expected.names);
    EXPECT_EQ(got.features, expected.features);
    EXPECT_EQ(got.vertices, expected.vertices);
    EXPECT_EQ(got.reference.vertices, expected.reference.vertices);
    EXPECT_EQ(got.reference.faces, expected.reference.faces);
    EXPECT_EQ(got.rotation, expected.rotation);
    EXPECT_EQ(got.translation, expected.translation);
    EXPECT_EQ(got.weights, expected.weights);
    EXPECT_EQ(got.principal_energy, expected.principal_energy);
    EXPECT_EQ(got.propagation_energy, expected.propagation_energy);
    EXPECT_THAT(got.relaxation_energy,
                testing::Pointwise(testing::NanSensitiveDoubleEq(), expected.relaxation_energy));
    EXPECT_EQ(got.consistency_energy, expected.consistency_energy);
    EXPECT_EQ(got.consistency_gap, expected.consistency_gap);
    EXPECT_EQ(got.largest_jump, expected.largest_jump);
    EXPECT_EQ(got.large_jumps, expected.large_jumps);
    EXPECT_EQ(got.inherent_jumps, expected.inherent_jumps);
    EXPECT_EQ(got.removable_jumps, expected.removable_jumps);
    EXPECT_EQ(got.warnings, expected.warnings);
}

TEST(FeatureFile, ReturnsWhatWasWritten) {
    const TemporaryFolder folder;
    write_features(folder / "f.safetensors", sample());
    expect_equal(read_features(folder / "f.safetensors"), sample());
    EXPECT_THAT(folder.names(), ElementsAre("f.safetensors"));
}

// Names, types and shapes are what other programs rely on.
TEST(FeatureFile, HoldsTheDocumentedTensors) {
    const TemporaryFolder folder;
    write_features(folder / "f", sample());
    const SafetensorsFile file(folder / "f");
    const auto kind = [&](const char* name) {
        return std::pair(file.type(name), file.shape(name));
    };
    EXPECT_EQ(kind("features"), std::pair(DataType::f32, Shape({2, 4, 9})));
    EXPECT_EQ(kind("vertices"), std::pair(DataType::f32, Shape({2, 4, 3})));
    EXPECT_EQ(kind("reference"), std::pair(DataType::f64, Shape({4, 3})));
    EXPECT_EQ(kind("faces"), std::pair(DataType::i32, Shape({2, 3})));
    EXPECT_EQ(kind("rotation"), std::pair(DataType::f64, Shape({2, 3, 3})));
    EXPECT_EQ(kind("translation"), std::pair(DataType::f64, Shape({2, 3})));
    for (const char* name :
         {"principal_energy", "propagation_energy", "relaxation_energy", "consistency_energy",
          "consistency_gap", "largest_jump", "large_jumps", "inherent_jumps", "removable_jumps"}) {
        EXPECT_EQ(kind(name), std::pair(DataType::f64, Shape({2}))) << name;
    }
    EXPECT_EQ(file.metadata().at("format_version"), "1");
    EXPECT_EQ(file.metadata().at("layout"), "rx ry rz s11 s12 s13 s22 s23 s33");
    EXPECT_EQ(file.metadata().at("weights"), "authors");
    EXPECT_EQ(file.metadata().at("names"), "[\"rest\",\"a \\\"quoted\\\" name, caf\xc3\xa9\"]");
}

/// A file of another program: tensors in a fixed order behind each other, header as that program
/// has it, no hash. Every test spoils one thing.
struct ForeignFile {
    std::string metadata = R"({"layout":"rx ry rz s11 s12 s13 s22 s23 s33","source":"random"})";
    std::vector<std::pair<std::string, std::string>> shapes{
        {"features", "[2,4,9]"}, {"vertices", "[2,4,3]"}, {"reference", "[4,3]"},
        {"faces", "[2,3]"},      {"rotation", "[2,3,3]"}, {"translation", "[2,3]"}};
    FeatureSet set = sample();

    std::string bytes() const {
        std::string header = "{\"__metadata__\":" + metadata, data;
        for (const auto& [name, shape] : shapes) {
            const std::string raw = raw_of(name);
            const char* type = name == "faces"                            ? "I32"
                               : name == "features" || name == "vertices" ? "F32"
                                                                          : "F64";
            header += ", \"" + name + "\": {\"dtype\": \"" + type + "\", \"shape\": " + shape +
                      ", \"data_offsets\": [" + std::to_string(data.size()) + ", " +
                      std::to_string(data.size() + raw.size()) + "]}";
            data += raw;
        }
        header += "}";
        const std::uint64_t length = header.size();
        return std::string(reinterpret_cast<const char*>(&length), 8) + header + data;
    }
    template <class T>
    static std::string raw(const std::vector<T>& values) {
        return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
    }
    std::string raw_of(const std::string& name) const {
        if (name == "features") return raw(set.features);
        if (name == "vertices") return raw(set.vertices);
        if (name == "reference") return raw(set.reference.vertices);
        if (name == "faces") return raw(set.reference.faces);
        if (name == "rotation") return raw(set.rotation);
        if (name == "translation") return raw(set.translation);
        if (name == "relaxation_energy") return raw(set.relaxation_energy);
        return raw(set.largest_jump);
    }
};

std::string message_of(const ForeignFile& file) {
    const TemporaryFolder folder;
    const std::string path = folder.put("f.safetensors", file.bytes());
    const std::string message = thrown_message<InputError>([&] { read_features(path); });
    EXPECT_THAT(message, testing::StartsWith(path + ": "));
    return message;
}

TEST(FeatureFile, OfAnotherProgramIsReadWithDefaultsForWhatItLacks) {
    const TemporaryFolder folder;
    FeatureSet expected = sample();
    expected.names = {"shape_0000", "shape_0001"};
    expected.weights = "cotangent";
    expected.principal_energy.clear();
    expected.propagation_energy.clear();
    expected.relaxation_energy.clear();
    expected.consistency_energy.clear();
    expected.consistency_gap.clear();
    expected.largest_jump.clear();
    expected.large_jumps.clear();
    expected.inherent_jumps.clear();
    expected.removable_jumps.clear();
    expected.warnings.clear();
    ForeignFile file;
    expect_equal(read_features(folder.put("f", file.bytes())), expected);
    file.metadata = "{}";
    expect_equal(read_features(folder.put("f", file.bytes())), expected);
}

TEST(FeatureFile, RefusesNumbersThatAreNotFiniteAndSaysWhere) {
    ForeignFile file;
    file.set.features[1 * 36 + 2 * 9 + 5] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_THAT(message_of(file),
                AllOf(HasSubstr("features[1, 2, 5] is nan"), HasSubstr("finite")));
    file = {};
    file.set.vertices[23] = std::numeric_limits<float>::infinity();
    EXPECT_THAT(message_of(file), HasSubstr("vertices[1, 3, 2] is inf"));
    file = {};
    file.set.reference.vertices[3][0] = -std::numeric_limits<double>::infinity();
    EXPECT_THAT(message_of(file), HasSubstr("reference[3, 0] is -inf"));
    file = {};
    file.set.rotation[1][4] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THAT(message_of(file), HasSubstr("rotation[1, 1, 1] is nan"));
    file = {};
    file.set.translation[0][2] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THAT(message_of(file), HasSubstr("translation[0, 2] is nan"));
}

// Only the energy of the relaxation is not a number where there was no need for one.
TEST(FeatureFile, KnowsWhichNumbersPerShapeMayBeMissing) {
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    ForeignFile file;
    file.shapes.emplace_back("relaxation_energy", "[2]");
    file.set.relaxation_energy = {1, kNaN};
    const TemporaryFolder folder;
    EXPECT_TRUE(std::isnan(read_features(folder.put("f", file.bytes())).relaxation_energy[1]));
    file.set.relaxation_energy = {1, std::numeric_limits<double>::infinity()};
    EXPECT_THAT(message_of(file), HasSubstr("relaxation_energy[1] is inf"));
    file = {};
    file.shapes.emplace_back("largest_jump", "[2]");
    file.set.largest_jump = {kNaN, 1};
    EXPECT_THAT(message_of(file), HasSubstr("largest_jump[0] is nan"));
}

TEST(FeatureFile, HandsOutTheRowsThatReadFeaturesCopies) {
    const TemporaryFolder folder;
    write_features(folder / "f", sample());
    const FeatureFile file(folder / "f");
    EXPECT_EQ(file.shape_count(), 2);
    EXPECT_EQ(file.vertex_count(), 4);
    const FeatureSet set = sample();
    for (int n = 0; n < 2; ++n) {
        EXPECT_TRUE(std::ranges::equal(file.shape(n), set.shape(n)));
        EXPECT_TRUE(std::ranges::equal(
            file.vertices(n),
            std::span(set.vertices).subspan(static_cast<std::size_t>(n) * 12, 12)));
    }
    file.forget(1);
    EXPECT_TRUE(std::ranges::equal(file.shape(1), set.shape(1)));
    FeatureSet outline = sample();
    outline.features.clear();
    outline.vertices.clear();
    expect_equal(file.outline(), outline);
}

TEST(FeatureFile, RefusesFacesOutOfRange) {
    ForeignFile file;
    file.set.reference.faces[1][2] = 4;
    EXPECT_THAT(message_of(file), HasSubstr("faces[1] refers to vertex 4, the file has 0 to 3"));
    file.set.reference.faces[1][2] = -1;
    EXPECT_THAT(message_of(file), HasSubstr("vertex -1"));
    file.set.reference.faces.clear();
    file.shapes[3].second = "[0,3]";
    EXPECT_THAT(message_of(file), HasSubstr("no faces"));
}

TEST(FeatureFile, RefusesShapesThatDoNotMatch) {
    ForeignFile file;
    file.shapes[0].second = "[2,9,4]";
    EXPECT_THAT(message_of(file), AllOf(HasSubstr("'features'"), HasSubstr("[2, 9, 4]"),
                                        HasSubstr("wanted [any, any, 9]")));
    file = {};
    file.shapes[1].second = "[4,2,3]";
    EXPECT_THAT(message_of(file), AllOf(HasSubstr("'vertices'"), HasSubstr("wanted [2, 4, 3]")));
    file = {};
    file.set.reference.vertices.pop_back();
    file.shapes[2].second = "[3,3]";
    EXPECT_THAT(message_of(file), AllOf(HasSubstr("'reference'"), HasSubstr("wanted [4, 3]")));
    file = {};
    file.shapes[4].second = "[2,9]";
    EXPECT_THAT(message_of(file), AllOf(HasSubstr("'rotation'"), HasSubstr("wanted [2, 3, 3]")));
    file = {};
    file.set.translation.pop_back();
    file.shapes[5].second = "[1,3]";
    EXPECT_THAT(message_of(file), AllOf(HasSubstr("'translation'"), HasSubstr("wanted [2, 3]")));
    file = {};
    file.set.largest_jump = {1, 2, 3};
    file.shapes.emplace_back("largest_jump", "[3]");
    EXPECT_THAT(message_of(file), AllOf(HasSubstr("'largest_jump'"), HasSubstr("wanted [2]")));
}

TEST(FeatureFile, RefusesAFileWithoutShapesOrFeatures) {
    ForeignFile file;
    file.shapes.erase(file.shapes.begin());
    EXPECT_THAT(message_of(file), AllOf(HasSubstr("'features'"), HasSubstr("vertices")));
    file = {};
    file.set.features.clear();
    file.shapes[0].second = "[0,4,9]";
    EXPECT_THAT(message_of(file), HasSubstr("0 shapes"));
    file.shapes[0].second = "[2,0,9]";
    EXPECT_THAT(message_of(file), HasSubstr("0 vertices"));
}

TEST(FeatureFile, RefusesMetadataItDoesNotUnderstand) {
    const auto with = [](const char* metadata) {
        ForeignFile file;
        file.metadata = metadata;
        return message_of(file);
    };
    EXPECT_THAT(with(R"({"format_version":"2"})"), AllOf(HasSubstr("'2'"), HasSubstr("reads '1'")));
    EXPECT_THAT(with(R"({"layout":"s11 rx"})"),
                AllOf(HasSubstr("'s11 rx'"), HasSubstr("wanted 'rx")));
    EXPECT_THAT(with(R"({"weights":"heavy"})"),
                AllOf(HasSubstr("'heavy'"), HasSubstr("cotangent")));
    EXPECT_THAT(with(R"({"names":"[\"a\"]"})"), HasSubstr("1 names for 2 shapes"));
    EXPECT_THAT(with(R"({"names":"a, b"})"), HasSubstr("'names' is not a JSON list of strings"));
    EXPECT_THAT(with(R"({"names":"[\"a\",2]"})"), HasSubstr("'names'"));
    EXPECT_THAT(with(R"({"warnings":"{}"})"), HasSubstr("'warnings'"));
}

TEST(FeatureFile, NumbersThatAreNotFiniteAreNotWritten) {
    const TemporaryFolder folder;
    FeatureSet set = sample();
    set.features[7] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_THAT(thrown_message<NumericalError>([&] { write_features(folder / "f", set); }),
                AllOf(HasSubstr("features[0, 0, 7] is nan"), HasSubstr("nothing was written")));
    EXPECT_THAT(folder.names(), IsEmpty());
}

// Rows of the sample in the order 1, 0, each written twice.
void write_rows(FeatureFileWriter& writer, const FeatureSet& set) {
    const std::vector<float> draft(4 * kFeatureDim, 5.0F);
    for (const int n : {1, 0}) {
        writer.put_features(n, draft);
        std::vector<float> read(draft.size());
        writer.get_features(n, read);
        EXPECT_EQ(read, draft);
        writer.put_features(n, set.shape(n));
        writer.put_vertices(n,
                            std::span(set.vertices).subspan(static_cast<std::size_t>(n) * 12, 12));
    }
}

TEST(FeatureFileWriter, TakesRowsInAnyOrderAndAgain) {
    const TemporaryFolder folder;
    {
        FeatureFileWriter writer(folder / "f", sample());
        write_rows(writer, sample());
        EXPECT_FALSE(std::filesystem::exists(folder / "f"));
        writer.finish(sample());
        EXPECT_THAT(folder.names(), ElementsAre("f"));
        FeatureFileWriter other(folder / "g", sample());
        write_rows(other, sample());
    }
    EXPECT_THAT(folder.names(), ElementsAre("f"));
    expect_equal(read_features(folder / "f"), sample());
}

// The header is written last but stands first: what it has no room for is counted.
TEST(FeatureFileWriter, ShortensWarningsThatDoNotFit) {
    const TemporaryFolder folder;
    FeatureSet set = sample();
    set.warnings.clear();
    for (int i = 0; i < 1000; ++i)
        set.warnings.push_back(std::to_string(i) + std::string(500, '"'));
    write_features(folder / "f", set);
    const FeatureSet read = read_features(folder / "f");
    ASSERT_GT(read.warnings.size(), 10u);
    ASSERT_LT(read.warnings.size(), 1000u);
    const std::size_t kept = read.warnings.size() - 1;
    for (std::size_t i = 0; i < kept; ++i) EXPECT_EQ(read.warnings[i], set.warnings[i]);
    EXPECT_EQ(read.warnings.back(),
              std::to_string(1000 - kept) + " further warnings did not fit into the file");
    EXPECT_EQ(read.features, set.features);

    set.warnings = {std::string(1'000'000, 'x')};
    write_features(folder / "g", set);
    EXPECT_THAT(read_features(folder / "g").warnings, ElementsAre(HasSubstr("1 further")));
}

TEST(FeatureFileWriter, RefusesRowsThatAreNotFinite) {
    const TemporaryFolder folder;
    {
        FeatureFileWriter writer(folder / "f", sample());
        std::vector<float> row(4 * kFeatureDim, 1.0F);
        row[20] = -std::numeric_limits<float>::infinity();
        EXPECT_THAT(thrown_message<NumericalError>([&] { writer.put_features(1, row); }),
                    HasSubstr("features[1, 2, 2] is -inf"));
        EXPECT_THROW(writer.put_features(1, std::span(row).first(9)), std::logic_error);
        EXPECT_THROW(writer.finish(sample()), std::logic_error);  // no row was written
    }
    EXPECT_THAT(folder.names(), IsEmpty());
}

TEST(FeatureFile, WritingArraysOfAnotherCountIsABug) {
    const TemporaryFolder folder;
    FeatureSet set = sample();
    set.translation.pop_back();
    EXPECT_THROW(write_features(folder / "f", set), std::logic_error);
    EXPECT_THAT(folder.names(), IsEmpty());
}

}  // namespace
}  // namespace mscomp
