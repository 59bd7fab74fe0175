// SPDX-License-Identifier: MIT
#include "mscomp/config/config_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/temporary_folder.h"
#include "config/config_cases.h"
#include "mscomp/base/error.h"
#include "mscomp/kinds/kinds.h"
#include "mscomp/units/units.h"

namespace mscomp {
namespace {

using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;

const std::string kData = "data: {features: f.safetensors}\n";

struct Refusal {
    std::string key, message;
    std::int64_t line = -1, column = -1;
};

/// Of a configuration of the kind with the most keys, unless the text names one.
Refusal refusal_of(const std::string& yaml, std::vector<std::string> overrides = {}) {
    const bool names_kind = yaml.find("kind") != std::string::npos;
    if (!names_kind) overrides.insert(overrides.begin(), "model.kind=stacked-attention");
    try {
        parse_config(yaml, "c.yaml", overrides);
    } catch (const ConfigError& error) {
        EXPECT_EQ(error.exit_code(), ExitCode::usage);
        return {error.key(), error.what(), error.where().line, error.where().column};
    }
    ADD_FAILURE() << "accepted: " << yaml;
    return {};
}

Config with(const std::string& override) {
    return parse_config(kData, "c.yaml", {"model.kind=stacked-attention", override});
}

TEST(ConfigFile, WhatIsLeftOutKeepsItsDefault) {
    for (const std::string& kind : kind_names()) {
        Config defaults = default_config(kind);
        defaults.data.features = "f.safetensors";
        const Config read = parse_config(kData, "c.yaml", {"model.kind=" + kind});
        EXPECT_EQ(all_of(read), all_of(defaults));
    }
    EXPECT_EQ(parse_config(kData, "c.yaml").kind, kind_names().front());
}

/// ASCII in another encoding: so many bytes a character, lowest or highest first.
std::string widened(const std::string& mark, const std::string& ascii, std::size_t bytes,
                    bool lowest_first) {
    std::string result = mark;
    for (const char c : ascii) {
        std::string character(bytes, '\0');
        (lowest_first ? character.front() : character.back()) = c;
        result += character;
    }
    return result;
}

// YAML may be UTF-8, UTF-16 or UTF-32 with or without a mark: editors of Windows save such files.
TEST(ConfigFile, IsReadInEveryEncodingOfYaml) {
    const std::string plain = kData + "train: {epochs: 7}\n";
    const std::vector<std::string> encoded{
        "\xEF\xBB\xBF" + plain,
        widened("\xFF\xFE", plain, 2, true),
        widened("\xFE\xFF", plain, 2, false),
        widened("", plain, 2, true),
        widened("", plain, 2, false),
        widened(std::string("\xFF\xFE\0\0", 4), plain, 4, true),
        widened(std::string("\0\0\xFE\xFF", 4), plain, 4, false)};
    for (const std::string& text : encoded) {
        const TemporaryFolder folder;
        const std::string path = folder.put("c.yaml", text);
        EXPECT_EQ(read_config(path, {}).train.epochs, 7) << testing::PrintToString(text);
    }
    const Refusal refusal =
        refusal_of(widened("\xFF\xFE", kData + "trian: {epochs: 7}\n", 2, true));
    EXPECT_EQ(refusal.line, 2);
    EXPECT_THAT(refusal.message, HasSubstr("train"));
}

// The example of the contract, literally.
TEST(ConfigFile, ReadsTheFlowStyleOfTheContract) {
    const Config c = parse_config(
        "model: {kind: stacked-attention, attention: true, joint: true, tied: transpose,\n"
        "        levels: [{components: 12, sparsity_range: 0.5}, {components: 4, "
        "sparsity_range: 0.25, sparsity_ramp: [0.1, 0.3]}]}\n"
        "loss:  {reconstruction: 1, sparsity: 500, range: 1, range_limit: 5}\n"
        "data:  {features: scape.safetensors, split: {train: random, count: 36, seed: 2}}\n"
        "train: {epochs: 20, batch: 2, learning_rate: 1.0e-3, seed: 0, start: random,\n"
        "        sparsity_step: subgradient}\n",
        "c.yaml");
    ASSERT_EQ(stacked(c).model.levels.size(), 2u);
    EXPECT_EQ(stacked(c).model.levels[0].components, 12);
    EXPECT_EQ(stacked(c).model.levels[0].sparsity_range, 0.5);
    EXPECT_FALSE(stacked(c).model.levels[0].sparsity_ramp.has_value());
    EXPECT_EQ(stacked(c).model.levels[1].sparsity_ramp->to, 0.3);
    EXPECT_EQ(stacked(c).loss.sparsity, 500);
    EXPECT_EQ(c.data.split.train, SplitKind::random);
    EXPECT_EQ(c.data.split.count, 36);
    EXPECT_EQ(c.train.learning_rate, 1e-3);
    EXPECT_EQ(c.train.start, Start::random);
}

TEST(ConfigFile, UnknownKeyNamesPlaceAndNearestKey) {
    const Refusal r = refusal_of(kData + "train:\n  epochs: 5\n  learnin_rate: 1\n");
    EXPECT_EQ(r.key, "train.learnin_rate");
    EXPECT_EQ(r.line, 4);
    EXPECT_EQ(r.column, 3);
    EXPECT_THAT(r.message, testing::StartsWith("c.yaml:4:3: "));
    EXPECT_THAT(r.message, EndsWith("nearest known key is train.learning_rate"));
}

TEST(ConfigFile, UnknownKeyInALevelNamesTheKeyOfThatLevel) {
    const Refusal r = refusal_of(
        kData + "model: {levels: [{components: 1, sparsity_range: 0}, {component: 2}]}\n");
    EXPECT_EQ(r.key, "model.levels[1].component");
    EXPECT_THAT(r.message, EndsWith("nearest known key is model.levels[1].components"));
}

TEST(ConfigFile, KeyInTheWrongSectionIsFoundWhereItBelongs) {
    EXPECT_THAT(refusal_of("epochs: 5\n").message, EndsWith("is train.epochs"));
    EXPECT_THAT(refusal_of("loss: {mask_power: 2}\n").message, EndsWith("is model.mask_power"));
    EXPECT_THAT(refusal_of("modell: {}\n").message, EndsWith("is model"));
}

struct WrongValue {
    std::string yaml, key;
    std::int64_t line, column;
    std::string got, wanted;
};

TEST(ConfigFile, WrongValueNamesPlaceGotAndWanted) {
    const std::vector<WrongValue> cases{
        {"train:\n  epochs: many\n", "train.epochs", 2, 11, "\"many\"", "a whole number >= 1"},
        {"train: {epochs: 0}\n", "train.epochs", 1, 17, "\"0\"", "a whole number >= 1"},
        {"train: {epochs: 1.5}\n", "train.epochs", 1, 17, "\"1.5\"", "a whole number >= 1"},
        {"train: {epochs: \"5\"}\n", "train.epochs", 1, 17, "\"5\"", "a whole number"},
        {"train: {epochs: 3000000000}\n", "train.epochs", 1, 17, "\"3000000000\"", "whole"},
        {"train: {epochs: }\n", "train.epochs", 1, 17, "nothing", "a whole number >= 1"},
        {"train: {epochs: [1]}\n", "train.epochs", 1, 17, "a list", "a whole number >= 1"},
        {"train: {seed: -1}\n", "train.seed", 1, 15, "\"-1\"", "a whole number >= 0"},
        {"train: {learning_rate: 0}\n", "train.learning_rate", 1, 24, "\"0\"", "a number > 0"},
        {"train: {learning_rate: .nan}\n", "train.learning_rate", 1, 24, "\".nan\"", "> 0"},
        {"train: {learning_rate: nan}\n", "train.learning_rate", 1, 24, "\"nan\"", "> 0"},
        {"train: {learning_rate: inf}\n", "train.learning_rate", 1, 24, "\"inf\"", "> 0"},
        {"train:\n  learning_rate: 0,1\n", "train.learning_rate", 2, 18, "\"0,1\"", "> 0"},
        {"train: {learning_rate_decay: 1.01}\n", "train.learning_rate_decay", 1, 30, "\"1.01\"",
         "a number > 0 and <= 1"},
        {"model: {levels: [{components: 1, sparsity_range: 0, max_support: 0}]}\n",
         "model.levels[0].max_support", 1, 66, "\"0\"", "a number > 0 and <= 1, or null"},
        {"model: {joint: yes}\n", "model.joint", 1, 16, "\"yes\"", "true or false"},
        {"model: {tied: samee}\n", "model.tied", 1, 15, "\"samee\"",
         "transpose, same or none; the nearest is same"},
        {"model: {kind: stacked}\n", "model.kind", 1, 15, "\"stacked\"", "stacked-attention"},
        {"model: {levels: []}\n", "model.levels", 1, 17, "a list", "at least one level"},
        {"model: {levels: [5]}\n", "model.levels[0]", 1, 18, "\"5\"", "a mapping"},
        {"model: 3\n", "model", 1, 8, "\"3\"", "a mapping with the keys kind, attention"},
        {"- 1\n", "configuration", 1, 1, "a list", "a mapping with the keys model"},
        {"data: {features: [a]}\n", "data.features", 1, 18, "a list", "a file name"},
    };
    for (const WrongValue& each : cases) {
        SCOPED_TRACE(each.yaml);
        const Refusal r = refusal_of(each.yaml);
        EXPECT_EQ(r.key, each.key);
        EXPECT_EQ(r.line, each.line);
        EXPECT_EQ(r.column, each.column);
        EXPECT_THAT(r.message, HasSubstr("got " + each.got + ", wanted"));
        EXPECT_THAT(r.message, HasSubstr(each.wanted));
    }
}

TEST(ConfigFile, ARampRisesWithinTheUnitRange) {
    for (const std::string ramp : {"[0.4, 0.2]", "[0.2, 0.2]", "[-0.1, 0.2]", "[0.2, 1.1]", "[0.2]",
                                   "[0.1, 0.2, 0.3]", "[a, 0.3]", "0.3"}) {
        const Refusal r = refusal_of(
            "model: {levels: [{components: 1, sparsity_range: 0, "
            "sparsity_ramp: " +
            ramp + "}]}\n");
        EXPECT_EQ(r.key, "model.levels[0].sparsity_ramp") << ramp;
        EXPECT_THAT(r.message, HasSubstr("[from, to] with 0 <= from < to <= 1"));
    }
}

TEST(ConfigFile, ARepeatedKeyIsRefusedAtItsSecondPlace) {
    const Refusal r = refusal_of("train:\n  epochs: 5\n  seed: 1\n  epochs: 6\n");
    EXPECT_EQ(r.key, "train.epochs");
    EXPECT_EQ(r.line, 4);
    EXPECT_EQ(r.column, 3);
    EXPECT_THAT(r.message, HasSubstr("given twice"));
}

TEST(ConfigFile, WhatIsRequiredIsAskedFor) {
    EXPECT_EQ(refusal_of("").key, "data.features");
    EXPECT_EQ(refusal_of("# nothing\n").key, "data.features");
    const Refusal no_features = refusal_of("train: {seed: 1}\ndata:\n  center: minmax\n");
    EXPECT_EQ(no_features.key, "data.features");
    EXPECT_EQ(no_features.line, 3);
    const Refusal no_count = refusal_of("data:\n  features: f\n  split: {train: random}\n");
    EXPECT_EQ(no_count.key, "data.split.count");
    EXPECT_EQ(no_count.line, 3);
    EXPECT_EQ(refusal_of("data: {features: f, split: {train: file}}").key, "data.split.path");
    const Refusal no_range = refusal_of("model:\n  levels:\n    - components: 3\n");
    EXPECT_EQ(no_range.key, "model.levels[0].sparsity_range");
    EXPECT_EQ(no_range.line, 3);
}

TEST(ConfigFile, BrokenYamlNamesLineAndColumn) {
    const Refusal r = refusal_of("train:\n  epochs: [1, 2\nloss: 3\n");
    EXPECT_EQ(r.line, 3);
    EXPECT_GT(r.column, 0);
    EXPECT_THAT(r.message, HasSubstr("not valid YAML"));
    EXPECT_THAT(refusal_of("a: \"open\n").message, HasSubstr("not valid YAML"));
    EXPECT_THAT(refusal_of("train: *nobody\n").message, HasSubstr("not valid YAML"));
    EXPECT_THAT(refusal_of(std::string(100000, '[')).message, HasSubstr("not valid YAML"));
    EXPECT_THAT(refusal_of(kData + "---\ntrain: {seed: 1}\n").message, HasSubstr("second"));
    // The parser never gets past a comma outside of brackets.
    EXPECT_THAT(refusal_of(", c").message, testing::StartsWith("c.yaml:1:1: YAML: not valid"));
    EXPECT_THAT(refusal_of("{data: {features: f}}, c").message, HasSubstr("second"));
    EXPECT_THAT(refusal_of(kData + "---\n, c").message, HasSubstr("second"));
}

TEST(ConfigFile, OverridesSetWhatTheyName) {
    EXPECT_EQ(with("train.epochs=100").train.epochs, 100);
    EXPECT_EQ(stacked(with("model.tied=same")).model.tied, nn::Tied::same);
    EXPECT_EQ(with("data.features=a=b.safetensors").data.features, "a=b.safetensors");
    const Config level = with("model.levels[1].components=7");
    EXPECT_EQ(stacked(level).model.levels[1].components, 7);
    EXPECT_EQ(stacked(level).model.levels[1].sparsity_range, 0.3);
    EXPECT_EQ(stacked(level).model.levels[0].components, 10);
    const Config list = with("model.levels=[{components: 50, sparsity_range: 0.3}]");
    ASSERT_EQ(stacked(list).model.levels.size(), 1u);
    EXPECT_EQ(stacked(list).model.levels[0].components, 50);
    const Config section = with("data.split={train: every, step: 4}");
    EXPECT_EQ(section.data.split.train, SplitKind::every);
    EXPECT_EQ(section.data.split.step, 4);
    EXPECT_EQ(section.data.features, "f.safetensors");
}

TEST(ConfigFile, LaterOverridesWin) {
    const Config c = parse_config(kData, "c.yaml", {"train.seed=1", "train.seed=2"});
    EXPECT_EQ(c.train.seed, 2u);
}

TEST(ConfigFile, AnOverrideCanGiveWhatTheFileLacks) {
    EXPECT_EQ(parse_config("", "c.yaml", {"data.features=g"}).data.features, "g");
}

TEST(ConfigFile, WrongOverridesNameTheOption) {
    const Refusal unknown = refusal_of(kData, {"train.epocs=5"});
    EXPECT_EQ(unknown.key, "train.epocs");
    EXPECT_THAT(unknown.message, testing::StartsWith("--set train.epocs=5: "));
    EXPECT_THAT(unknown.message, EndsWith("train.epochs"));
    EXPECT_THAT(refusal_of(kData, {"train.epochs=no"}).message, HasSubstr("got \"no\", wanted"));
    EXPECT_THAT(refusal_of(kData, {"train.epochs"}).message, HasSubstr("key=value"));
    EXPECT_THAT(refusal_of(kData, {"=5"}).message, HasSubstr("key=value"));
    EXPECT_THAT(refusal_of(kData, {"train.epochs.more=5"}).message, HasSubstr("unknown key"));
    EXPECT_THAT(refusal_of(kData, {"train.epochs[0]=5"}).message, HasSubstr("unknown key"));
    EXPECT_THAT(refusal_of(kData, {"model.levels[2].components=5"}).message,
                HasSubstr("there are 2, numbered from 0"));
    EXPECT_THAT(refusal_of(kData, {"model.levels[x].components=5"}).message,
                HasSubstr("no such level"));
    EXPECT_THAT(refusal_of(kData, {"train.epochs=[1"}).message, HasSubstr("not valid YAML"));
    EXPECT_THAT(refusal_of(kData, {"data.split={trian: all}"}).message,
                EndsWith("data.split.train"));
}

TEST(ConfigFile, UnknownKindListsTheKnownOnes) {
    EXPECT_THAT(kind_names(), ElementsAre("multiscale", "stacked-attention", "autoencoder",
                                          "spectral-vae", "units", "pca"));
    try {
        default_config("pcaa");
        FAIL();
    } catch (const UsageError& error) {
        EXPECT_THAT(error.what(), HasSubstr("stacked-attention"));
    }
}

// What units change is their own to say; the filter counts in what that is.
TEST(ConfigFile, UnitsChangeFeaturesOrPositions) {
    const std::string yaml = kData + "model: {kind: units, rows: positions}\n";
    const Config config = parse_config(yaml, "c");
    EXPECT_EQ(config.own<UnitSettings>().rows, ShapeRows::positions);
    EXPECT_EQ(kind_named("units").rows(config), ShapeRows::positions);
    EXPECT_EQ(config.filter.rule, FilterRule::strength) << "votes choose";
    EXPECT_EQ(config.filter.minimum_strength, 0);
    EXPECT_EQ(config.filter.minimum_share, 0);
    EXPECT_EQ(kind_named("units").rows(default_config("units")), ShapeRows::features);
    const std::string text = write_config(config, true);
    EXPECT_THAT(text, HasSubstr("rows: positions"));
    EXPECT_THAT(text, HasSubstr("as parts of the radius of the reference"));
    EXPECT_EQ(write_config(parse_config(text, "c"), true), text);
    EXPECT_THAT(write_config(default_config("units"), true), HasSubstr("in unscaled features"));
    EXPECT_THAT(refusal_of(kData, {"model.kind=units", "model.rows=vertices"}).message,
                HasSubstr("wanted"));
}

// Keys and defaults are those of the kind, wherever it is named.
TEST(ConfigFile, KeysDependOnTheKind) {
    const Config one = parse_config(kData + "model: {components: 7, kind: autoencoder}\n", "c");
    EXPECT_EQ(one.kind, "autoencoder");
    ASSERT_EQ(stacked(one).model.levels.size(), 1u);
    EXPECT_EQ(stacked(one).model.levels[0].components, 7);
    for (const auto& overrides :
         std::vector<std::vector<std::string>>{{"model.filter_order=4", "model.kind=spectral-vae"},
                                               {"model={filter_order: 4, kind: spectral-vae}"}}) {
        const Config vae = parse_config(kData, "c", overrides);
        EXPECT_EQ(vae.kind, "spectral-vae");
        EXPECT_EQ(spectral(vae).model.filter_order, 4);
        EXPECT_EQ(spectral(vae).model.components,
                  spectral(default_config("spectral-vae")).model.components);
    }
    EXPECT_THAT(
        refusal_of(kData + "model: {kind: autoencoder, mask_power: 1}\n").message,
        HasSubstr("a key of the kind stacked-attention; this is a configuration of the kind "
                  "autoencoder"));
    EXPECT_THAT(refusal_of(kData + "model: {kind: spectral}\n").message, HasSubstr("spectral-vae"));
    EXPECT_EQ(refusal_of(kData + "model: [kind]\n").key, "model");
}

TEST(ConfigFile, AMissingFileIsAnIoError) {
    EXPECT_THROW(read_config("/nowhere/config.yaml", {}), IoError);
}

}  // namespace
}  // namespace mscomp
