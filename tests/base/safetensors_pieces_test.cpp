// SPDX-License-Identifier: MIT
#include "mscomp/base/safetensors_pieces.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <numeric>
#include <stdexcept>

#include "base/full_disk.h"
#include "base/temporary_folder.h"
#include "base/thrown_message.h"
#include "mscomp/base/error.h"
#include "mscomp/base/parallel.h"

namespace mscomp {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr std::int64_t kRows = 500, kWidth = 1001;  // 2 MB, more than one block

std::vector<float> row(std::int64_t index) {
    std::vector<float> values(kWidth);
    std::iota(values.begin(), values.end(), static_cast<float>(index * 3));
    return values;
}

std::vector<float> all_rows() {
    std::vector<float> values;
    for (std::int64_t i = 0; i < kRows; ++i) {
        const std::vector<float> next = row(i);
        values.insert(values.end(), next.begin(), next.end());
    }
    return values;
}

const std::vector<double> kThreeDoubles{0.5, -1e300, 3};

SafetensorsPieceWriter writer_in(const TemporaryFolder& folder, std::size_t reserve = 0) {
    return {folder / "t",
            {{"rows", DataType::f32, {kRows, kWidth}}, {"doubles", DataType::f64, {3}}},
            {{"key", "value"}},
            reserve};
}

void write_row(SafetensorsPieceWriter& writer, std::int64_t index) {
    const std::vector<float> values = row(index);
    writer.write("rows", index * kWidth, std::span<const float>(values));
}

void write_all(SafetensorsPieceWriter& writer) {
    writer.write("doubles", 0, std::span<const double>(kThreeDoubles));
    parallel_for(kRows, [&](std::int64_t i) { write_row(writer, kRows - 1 - i); });
}

TEST(SafetensorsPieces, GiveTheBytesOfAFileWrittenAtOnce) {
    const TemporaryFolder folder;
    const std::vector<float> values = all_rows();
    SafetensorsWriter whole;
    whole.add("rows", {kRows, kWidth}, std::span<const float>(values));
    whole.add("doubles", {3}, std::span<const double>(kThreeDoubles));
    whole.set_metadata("key", "value");
    whole.write(folder / "whole");
    for (const int threads : {1, 2, 7}) {
        set_thread_count(threads);
        SafetensorsPieceWriter writer = writer_in(folder);
        write_all(writer);
        writer.finish();
        EXPECT_TRUE(TemporaryFolder::content(folder / "t") ==
                    TemporaryFolder::content(folder / "whole"));
    }
    set_thread_count(0);
}

TEST(SafetensorsPieces, CanBeReadAndWrittenAgain) {
    const TemporaryFolder folder;
    SafetensorsPieceWriter writer = writer_in(folder);
    const std::vector<float> first(kWidth, 7.0F);
    writer.write("rows", 2 * kWidth, std::span<const float>(first));
    std::vector<float> read(kWidth);
    writer.read("rows", 2 * kWidth, std::span<float>(read));
    EXPECT_EQ(read, first);
    write_all(writer);
    writer.read("rows", 2 * kWidth, std::span<float>(read));
    EXPECT_EQ(read, row(2));
    const std::vector<float> values = all_rows();
    writer.write("rows", 0, std::span<const float>(values));
    writer.finish();
    const SafetensorsFile file(folder / "t");
    EXPECT_TRUE(std::ranges::equal(file.data<float>("rows", {kRows, kWidth}), values));
    EXPECT_THAT(file.data<double>("doubles", {3}), testing::ElementsAreArray(kThreeDoubles));
}

// What is computed from it would otherwise be written with a valid checksum.
TEST(SafetensorsPieces, NoticeWhatTheDiskGivesBackWrong) {
    const TemporaryFolder folder;
    SafetensorsPieceWriter writer = writer_in(folder);
    write_all(writer);
    const std::string file = folder / folder.names().at(0);
    std::fstream disk(file, std::ios::in | std::ios::out | std::ios::binary);
    disk.seekp(-4 * kWidth, std::ios::end);  // the last row
    disk.put('!').flush();
    std::vector<float> read(kWidth);
    writer.read("rows", 0, std::span<float>(read));
    EXPECT_THAT(thrown_message<IoError>(
                    [&] { writer.read("rows", (kRows - 1) * kWidth, std::span<float>(read)); }),
                HasSubstr("differs from what was written"));
}

TEST(SafetensorsPieces, AppearOnlyWhenFinishedAndLeaveNothingOtherwise) {
    const TemporaryFolder folder;
    folder.put("t", "earlier");
    {
        SafetensorsPieceWriter writer = writer_in(folder);
        write_all(writer);
        EXPECT_EQ(TemporaryFolder::content(folder / "t"), "earlier");
        EXPECT_EQ(folder.names().size(), 2u);
    }
    EXPECT_THAT(folder.names(), ElementsAre("t"));
    EXPECT_EQ(TemporaryFolder::content(folder / "t"), "earlier");
}

TEST(SafetensorsPieces, MetadataThatComeLateHaveRoomInTheReserve) {
    const TemporaryFolder folder;
    constexpr std::size_t kReserve = 1000;
    SafetensorsPieceWriter writer = writer_in(folder, kReserve);
    write_all(writer);
    EXPECT_TRUE(writer.has_room_for({{"late", std::string(kReserve - 16, 'x')}}));
    // Escaped, each of these takes two bytes of the header.
    EXPECT_FALSE(writer.has_room_for({{"late", std::string(kReserve - 16, '"')}}));
    EXPECT_FALSE(writer.has_room_for({{"late", std::string(kReserve, 'x')}}));
    EXPECT_THROW(writer.finish({{"late", std::string(2 * kReserve, 'x')}}), std::logic_error);
    writer.finish({{"late", "text"}});
    const SafetensorsFile file(folder / "t");
    EXPECT_EQ(file.metadata().at("late"), "text");
    EXPECT_EQ(file.metadata().at("key"), "value");
    EXPECT_EQ(file.metadata().at("xxh3").size(), 16u);
}

// A disk that returns other bytes than it was given must not go unnoticed, wherever that happens.
TEST(SafetensorsPieces, NoticeThatOtherBytesArrived) {
    const std::int64_t size = kRows * kWidth * 4 + 24;
    for (const std::int64_t from_end : {std::int64_t{1}, size / 2, size - 24, size}) {
        const TemporaryFolder folder;
        std::string message;
        {
            SafetensorsPieceWriter writer = writer_in(folder);
            write_all(writer);
            const std::vector<std::string> names = folder.names();
            ASSERT_EQ(names.size(), 1u);
            std::fstream file(folder / names[0], std::ios::in | std::ios::out | std::ios::binary);
            file.seekg(-from_end, std::ios::end);
            const auto byte = static_cast<char>(file.get() ^ 4);
            file.seekp(-from_end, std::ios::end);
            file.put(byte);
            file.close();
            message = thrown_message<IoError>([&] { writer.finish(); });
        }
        EXPECT_THAT(message, HasSubstr("differs")) << from_end;
        EXPECT_THAT(folder.names(), IsEmpty());
    }
}

TEST(SafetensorsPieces, AFullDiskShowsBeforeAnythingIsWritten) {
    const TemporaryFolder folder;
    std::string message;
    {
        const FullDisk full(1 << 16);
        message = thrown_message<IoError>([&] { writer_in(folder); });
    }
    EXPECT_THAT(message, AllOf(HasSubstr("t: cannot write"), HasSubstr("File too large")));
    EXPECT_THAT(folder.names(), IsEmpty());
}

TEST(SafetensorsPieces, ThatAreMissingOrDoNotFitAreABug) {
    const TemporaryFolder folder;
    SafetensorsPieceWriter writer = writer_in(folder);
    const auto refusal = [](auto&& call) { return thrown_message<std::logic_error>(call); };
    writer.write("doubles", 0, std::span<const double>(kThreeDoubles));
    EXPECT_THAT(refusal([&] { writer.finish(); }),
                HasSubstr("'rows' was never written from element 0 on"));
    write_row(writer, 0);
    write_row(writer, 2);
    EXPECT_THAT(refusal([&] { writer.finish(); }),
                HasSubstr("'rows' was never written from element 1001 on"));
    const std::vector<float> values = row(0);
    const std::span<const float> data(values);
    EXPECT_THROW(writer.write("rows", kRows * kWidth - 1, data), std::logic_error);
    EXPECT_THROW(writer.write("rows", -1, data), std::logic_error);
    EXPECT_THROW(writer.write("rows", 1, data), std::logic_error);           // cuts into row 0 ...
    EXPECT_THROW(writer.write("rows", kWidth + 1, data), std::logic_error);  // ... and into row 2
    EXPECT_THROW(writer.write("doubles", 0, data.first(1)), std::logic_error);
    EXPECT_THROW(writer.write("none", 0, data), std::logic_error);
    using Tensors = std::vector<SafetensorsPieceWriter::Tensor>;
    EXPECT_THROW(SafetensorsPieceWriter(folder / "u", Tensors{{"a", DataType::u8, {-1}}}),
                 std::logic_error);
    EXPECT_THROW(SafetensorsPieceWriter(
                     folder / "u", Tensors{{"a", DataType::u8, {1}}, {"a", DataType::u8, {1}}}),
                 std::logic_error);
}

TEST(SafetensorsPieces, OfNothingAreAFile) {
    const TemporaryFolder folder;
    SafetensorsPieceWriter writer(folder / "t", {{"none", DataType::f32, {0, 9}}});
    writer.finish();
    EXPECT_EQ(SafetensorsFile(folder / "t").data<float>("none", {0, 9}).size(), 0u);
}

}  // namespace
}  // namespace mscomp
