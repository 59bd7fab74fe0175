// SPDX-License-Identifier: MIT
#include "mscomp/base/safetensors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <ctime>
#include <stdexcept>

#include "base/temporary_folder.h"
#include "base/thrown_message.h"
#include "mscomp/base/error.h"

namespace mscomp {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

/// A file as another program would write it: header text as given, then the data.
std::string foreign(const std::string& header, const std::string& data) {
    const std::uint64_t length = header.size();
    std::string bytes(8, '\0');
    std::memcpy(bytes.data(), &length, 8);
    return bytes + header + data;
}

std::string message_of(const std::string& bytes) {
    static const TemporaryFolder folder;  // one for all: making folders is slow
    const std::string path = folder.put("t.safetensors", bytes);
    const std::string message = thrown_message<InputError>([&] { SafetensorsFile file(path); });
    EXPECT_THAT(message, HasSubstr("t.safetensors: "));
    return message;
}

const std::vector<float> kFloats{1.5f, -2, 3, 4, 5, 6};
const std::vector<double> kDoubles{0.1, -1e300};
const std::vector<std::uint8_t> kBytes{7, 8, 9};
const std::vector<std::int64_t> kLongs{-5};

std::string write_sample(const std::string& path) {
    SafetensorsWriter writer;
    writer.add("bytes", {3}, std::span<const std::uint8_t>(kBytes));
    writer.add("floats", {2, 3}, std::span<const float>(kFloats));
    writer.add("doubles", {2, 1}, std::span<const double>(kDoubles));
    writer.add("longs", {1}, std::span<const std::int64_t>(kLongs));
    writer.add("none", {0, 4}, std::span<const float>());
    writer.set_metadata("text", "so \"quoted\"\n\xc3\xa4");
    writer.write(path);
    return path;
}

TEST(Safetensors, ReturnsWhatWasWritten) {
    const TemporaryFolder folder;
    const SafetensorsFile file(write_sample(folder / "t.safetensors"));
    EXPECT_THAT(file.names(), ElementsAre("bytes", "doubles", "floats", "longs", "none"));
    EXPECT_THAT(file.data<float>("floats", {2, 3}), testing::ElementsAreArray(kFloats));
    EXPECT_THAT(file.data<double>("doubles", {-1, 1}), testing::ElementsAreArray(kDoubles));
    EXPECT_THAT(file.data<std::uint8_t>("bytes", {3}), testing::ElementsAreArray(kBytes));
    EXPECT_THAT(file.data<std::int64_t>("longs", {1}), testing::ElementsAreArray(kLongs));
    EXPECT_EQ(file.data<float>("none", {0, 4}).size(), 0u);
    EXPECT_EQ(file.shape("floats"), (Shape{2, 3}));
    EXPECT_EQ(file.type("bytes"), DataType::u8);
    EXPECT_EQ(file.metadata().at("text"), "so \"quoted\"\n\xc3\xa4");
    EXPECT_EQ(file.metadata().at("xxh3").size(), 16u);
    EXPECT_THAT(folder.names(), ElementsAre("t.safetensors"));
}

// The published XXH3-64 of no bytes at all (seed 0).
TEST(Safetensors, WritesThePublishedHash) {
    const TemporaryFolder folder;
    SafetensorsWriter().write(folder / "t");
    EXPECT_EQ(SafetensorsFile(folder / "t").metadata().at("xxh3"), "2d06800538d394c2");
}

TEST(Safetensors, StaysReadableWhenMoved) {
    const TemporaryFolder folder;
    SafetensorsFile first(write_sample(folder / "t"));
    const std::span<const float> data = first.data<float>("floats", {2, 3});
    const SafetensorsFile second(std::move(first));
    EXPECT_EQ(second.data<float>("floats", {2, 3}).data(), data.data());
    EXPECT_THAT(data, testing::ElementsAreArray(kFloats));
}

// So that any reader can map the file: the data begin at a multiple of 8, the largest items first.
TEST(Safetensors, TensorsLieAlignedInTheFile) {
    const TemporaryFolder folder;
    const std::string bytes = TemporaryFolder::content(write_sample(folder / "t"));
    std::uint64_t header_length = 0;
    std::memcpy(&header_length, bytes.data(), 8);
    EXPECT_EQ(header_length % 8, 0u);
    for (const char* place :
         {R"("doubles":{"data_offsets":[0,16])", R"("longs":{"data_offsets":[16,24])",
          R"("floats":{"data_offsets":[24,48])", R"("bytes":{"data_offsets":[48,51])"}) {
        EXPECT_THAT(bytes, HasSubstr(place));
    }
}

TEST(Safetensors, SpansAreAlignedForTheirType) {
    const TemporaryFolder folder;
    const SafetensorsFile own(write_sample(folder / "t"));
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(own.data<double>("doubles", {2, 1}).data()) % 8, 0u);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(own.data<float>("floats", {2, 3}).data()) % 4, 0u);

    // Another program's: an unpadded header and a byte before the double.
    std::string data(9, '\x05');
    const double value = 2.25;
    std::memcpy(data.data() + 1, &value, 8);
    const std::string header = R"({"b":{"dtype":"U8","shape":[1],"data_offsets":[0,1]},)"
                               R"("d":{"dtype":"F64","shape":[],"data_offsets":[1,9]}})";
    for (const char* padding : {"", " ", "  ", "   "}) {
        const SafetensorsFile file(folder.put("f", foreign(header + padding, data)));
        const std::span<const double> read = file.data<double>("d", {});
        EXPECT_EQ(reinterpret_cast<std::uintptr_t>(read.data()) % 8, 0u);
        EXPECT_THAT(read, ElementsAre(2.25));
        EXPECT_THAT(file.data<std::uint8_t>("b", {1}), ElementsAre(5));
    }
}

/// What a reader gets from the sample, the hashes apart.
std::string fingerprint(const SafetensorsFile& file) {
    std::string text;
    for (const auto& [key, value] : file.metadata()) {
        if (!value.empty() && key == "text") text += value;
    }
    for (const float x : file.data<float>("floats", {2, 3})) text += std::to_string(x);
    for (const double x : file.data<double>("doubles", {2, 1})) text += std::to_string(x);
    for (const auto x : file.data<std::uint8_t>("bytes", {3})) text += std::to_string(x);
    for (const auto x : file.data<std::int64_t>("longs", {1})) text += std::to_string(x);
    return text;
}

// A damaged byte is an error, or it was in the name of a hash and nothing else is different.
TEST(Safetensors, AFlippedByteNeverChangesWhatIsRead) {
    const TemporaryFolder folder;
    const std::string path = write_sample(folder / "t");
    const std::string sound = TemporaryFolder::content(path);
    const std::string expected = fingerprint(SafetensorsFile(path));
    int unnoticed = 0;
    for (std::size_t at = 0; at < sound.size(); ++at) {
        for (const int mask : {0x01, 0x20}) {
            std::string altered = sound;
            altered[at] = static_cast<char>(altered[at] ^ mask);
            folder.put("t", altered);
            try {
                EXPECT_EQ(fingerprint(SafetensorsFile(path)), expected) << "byte " << at;
                ++unnoticed;
            } catch (const InputError&) {
            }
        }
    }
    EXPECT_LE(unnoticed, 2 * static_cast<int>(std::string_view("xxh3_header").size()));
}

TEST(Safetensors, AFlippedByteOfTheDataFailsTheChecksum) {
    const TemporaryFolder folder;
    std::string altered = TemporaryFolder::content(write_sample(folder / "t"));
    altered.back() = static_cast<char>(altered.back() ^ 1);
    EXPECT_THAT(message_of(altered), HasSubstr("the data do not match their checksum"));
}

TEST(Safetensors, AnAlteredHeaderFailsTheChecksum) {
    const TemporaryFolder folder;
    std::string altered = TemporaryFolder::content(write_sample(folder / "t"));
    altered.replace(altered.find("[2,3]"), 5, "[3,2]");
    EXPECT_THAT(message_of(altered), HasSubstr("the header does not match its checksum"));
}

TEST(Safetensors, EveryTruncationIsNoticed) {
    const TemporaryFolder folder;
    const std::string sound = TemporaryFolder::content(write_sample(folder / "t"));
    for (std::size_t size = 0; size < sound.size(); ++size) message_of(sound.substr(0, size));
    EXPECT_THAT(message_of(sound.substr(0, sound.size() - 1)), HasSubstr("truncated"));
    EXPECT_THAT(message_of(sound + "x"), HasSubstr("the file has"));
}

TEST(Safetensors, AHeaderLongerThanTheFileIsRefusedBeforeAnythingIsAllocated) {
    EXPECT_THAT(message_of(std::string(8, '\xff')), HasSubstr("18446744073709551615"));
    EXPECT_THAT(message_of("abc"), HasSubstr("3 bytes"));
}

TEST(Safetensors, HostileHeadersAreRefusedWithTheReason) {
    const std::string four(4, '\0');
    const auto tensor = [](const char* entry) { return std::string(R"({"t":)") + entry + "}"; };
    EXPECT_THAT(message_of(foreign("{", "")), HasSubstr("not JSON"));
    EXPECT_THAT(message_of(foreign("[]", "")), HasSubstr("array"));
    // A number beyond double; found by fuzzing.
    EXPECT_THAT(message_of(foreign("{\"a\":1e9999}", "")), HasSubstr("not JSON, at its byte 11"));
    EXPECT_THAT(message_of(foreign(R"({"__metadata__":{"a":1}})", "")), HasSubstr("'a'"));
    EXPECT_THAT(message_of(foreign(tensor("3"), four)), HasSubstr("'t'"));
    EXPECT_THAT(
        message_of(foreign(tensor(R"({"dtype":"BF16","shape":[2],"data_offsets":[0,4]})"), four)),
        AllOf(HasSubstr("'BF16'"), HasSubstr("F32")));
    for (const char* shape : {"[-1]", "[1.0]", "[\"1\"]", "1", "[18446744073709551615]"}) {
        EXPECT_THAT(message_of(foreign(tensor((std::string(R"({"dtype":"F32","shape":)") + shape +
                                               R"(,"data_offsets":[0,4]})")
                                                  .c_str()),
                                       four)),
                    HasSubstr("'shape'"))
            << shape;
    }
    // 2^32 * 2^32 * 4 bytes wraps around to 0 in 64 bits.
    EXPECT_THAT(message_of(foreign(tensor(R"({"dtype":"F32","shape":[4294967296,4294967296],)"
                                          R"("data_offsets":[0,0]})"),
                                   "")),
                HasSubstr("does not fit"));
    EXPECT_THAT(
        message_of(foreign(tensor(R"({"dtype":"F32","shape":[2],"data_offsets":[0,4]})"), four)),
        HasSubstr("does not fit its 4 bytes"));
    EXPECT_THAT(
        message_of(foreign(tensor(R"({"dtype":"F32","shape":[1],"data_offsets":[4,0]})"), four)),
        HasSubstr("data_offsets"));
    EXPECT_THAT(
        message_of(foreign(tensor(R"({"dtype":"F32","shape":[1],"data_offsets":[8,12]})"), four)),
        HasSubstr("the file has 4"));
}

// Copying or printing a tree of JSON calls itself for every level: a million would end the program.
TEST(Safetensors, DeepNestingIsRefused) {
    const std::string levels(1000000, '['), ends(1000000, ']');
    for (const std::string& header :
         {levels, "{\"a\":{\"dtype\":\"U8\",\"shape\":[1],\"data_offsets\":[0,1],\"x\":" + levels +
                      ends + "}}"}) {
        EXPECT_THAT(message_of(foreign(header, "x")), HasSubstr("nested deeper than 16 levels"));
    }
}

// The time is in proportion to the header, not to its square.
TEST(Safetensors, ManyTensorsAreReadInNoTime) {
    std::string header = "{";
    for (int i = 0; i < 40000; ++i) {
        header += (i == 0 ? "\"" : ",\"") + std::to_string(i) +
                  "\":{\"dtype\":\"U8\",\"shape\":[0],\"data_offsets\":[0,0]}";
    }
    const TemporaryFolder folder;
    const std::string path = folder.put("t", foreign(header + "}", ""));
    const std::clock_t start = std::clock();
    EXPECT_EQ(SafetensorsFile(path).names().size(), 40000u);
    EXPECT_LT(std::clock() - start, 10 * CLOCKS_PER_SEC);
}

TEST(Safetensors, OverlapsHolesAndRepeatedNamesAreRefused) {
    const std::string a = R"("a":{"dtype":"U8","shape":[2],"data_offsets":[0,2]})";
    const auto b = [](int begin) {
        return R"("b":{"dtype":"U8","shape":[2],"data_offsets":[)" + std::to_string(begin) + "," +
               std::to_string(begin + 2) + "]}";
    };
    EXPECT_THAT(message_of(foreign("{" + a + "," + b(1) + "}", "xyz")), HasSubstr("overlap"));
    EXPECT_THAT(message_of(foreign("{" + a + "," + b(3) + "}", "xyzuv")), HasSubstr("hole"));
    EXPECT_THAT(message_of(foreign("{" + a + "," + a + "}", "xy")), HasSubstr("'a' twice"));
    EXPECT_THAT(message_of(foreign("{" + a + "}", "xyz")), HasSubstr("end at byte 2"));
}

TEST(Safetensors, AWrongHashInTheMetadataIsRefused) {
    const std::string header = R"({"__metadata__":{"xxh3":"0123456789abcdef"},)"
                               R"("a":{"dtype":"U8","shape":[1],"data_offsets":[0,1]}})";
    EXPECT_THAT(message_of(foreign(header, "x")), HasSubstr("checksum"));
}

TEST(Safetensors, ACheckSeesEveryElementOnceAndInOrder) {
    const TemporaryFolder folder;
    std::vector<float> many(3'000'000);  // of several pieces
    for (std::size_t i = 0; i < many.size(); ++i) many[i] = static_cast<float>(i);
    SafetensorsWriter writer;
    writer.add("many", {1000, 3000}, std::span<const float>(many));
    writer.add("bytes", {3}, std::span<const std::uint8_t>(kBytes));
    writer.write(folder / "t");
    std::vector<float> seen;
    std::vector<std::uint8_t> seen_bytes;
    const SafetensorsFile file(folder / "t", [&](const SafetensorsPiece& piece) {
        if (piece.name == "many") {
            EXPECT_EQ(piece.type, DataType::f32);
            EXPECT_EQ(piece.shape, (Shape{1000, 3000}));
            ASSERT_EQ(piece.first, static_cast<std::int64_t>(seen.size()));
            seen.resize(seen.size() + piece.bytes.size() / sizeof(float));
            std::memcpy(seen.data() + piece.first, piece.bytes.data(), piece.bytes.size());
        } else {
            for (const std::byte b : piece.bytes)
                seen_bytes.push_back(std::to_integer<std::uint8_t>(b));
        }
    });
    EXPECT_TRUE(seen == many);
    EXPECT_EQ(seen_bytes, kBytes);
    EXPECT_TRUE(std::ranges::equal(file.data<float>("many", {1000, 3000}), many));
}

// A damaged file is called that, whatever else is wrong with it.
TEST(Safetensors, WhatACheckThrowsComesAfterTheHash) {
    const TemporaryFolder folder;
    const std::string path = write_sample(folder / "t");
    const PieceCheck refuse = [](const SafetensorsPiece& piece) {
        throw InputError({"x"}, piece.name + " refused");
    };
    EXPECT_THAT(thrown_message<InputError>([&] { SafetensorsFile file(path, refuse); }),
                HasSubstr("doubles refused"));
    std::string altered = TemporaryFolder::content(path);
    altered.back() = static_cast<char>(altered.back() ^ 1);
    folder.put("t", altered);
    EXPECT_THAT(thrown_message<InputError>([&] { SafetensorsFile file(path, refuse); }),
                HasSubstr("checksum"));
}

TEST(Safetensors, AskingForWhatIsNotThereSaysWhatIs) {
    const TemporaryFolder folder;
    const SafetensorsFile file(write_sample(folder / "t"));
    const auto asking = [&](auto&& call) { return thrown_message<InputError>(call); };
    EXPECT_THAT(asking([&] { file.data<float>("weights", {2}); }),
                AllOf(HasSubstr("'weights'"), HasSubstr("floats")));
    EXPECT_THAT(asking([&] {
                    file.data<double>("floats", {2, 3});
                }),
                AllOf(HasSubstr("F32"), HasSubstr("wanted F64")));
    EXPECT_THAT(asking([&] {
                    file.data<float>("floats", {3, 2});
                }),
                AllOf(HasSubstr("[2, 3]"), HasSubstr("wanted [3, 2]")));
    EXPECT_THAT(asking([&] {
                    file.data<float>("floats", {2, -1, 1});
                }),
                HasSubstr("wanted [2, any, 1]"));
}

TEST(Safetensors, MissingFilesAreReportedAsSuch) {
    const TemporaryFolder folder;
    EXPECT_THAT(thrown_message<IoError>([&] { SafetensorsFile file(folder / "nowhere"); }),
                HasSubstr("No such file"));
    EXPECT_THAT(thrown_message<IoError>([&] { SafetensorsFile file(folder.path()); }),
                HasSubstr("folder"));
}

TEST(Safetensors, WritingShapesThatDoNotFitIsABug) {
    SafetensorsWriter writer;
    EXPECT_THROW(writer.add("x", {5}, std::span<const float>(kFloats)), std::logic_error);
    EXPECT_THROW(writer.add("x", {-6}, std::span<const float>(kFloats)), std::logic_error);
    EXPECT_THROW(writer.add("x", {-1, 0}, std::span<const std::uint8_t>()), std::logic_error);
    writer.add("x", {6}, std::span<const float>(kFloats));
    EXPECT_THROW(writer.add("x", {6}, std::span<const float>(kFloats)), std::logic_error);
}

// A name in another encoding than UTF-8 must not lose a day of training when it is saved.
TEST(Safetensors, TextsThatAreNotUtf8CanBeWritten) {
    const TemporaryFolder folder;
    SafetensorsWriter writer;
    writer.set_metadata("name", "caf\xe9");
    writer.write(folder / "t");
    EXPECT_THAT(SafetensorsFile(folder / "t").metadata().at("name"),
                AllOf(HasSubstr("caf"), Not(HasSubstr("\xe9"))));
}

}  // namespace
}  // namespace mscomp
