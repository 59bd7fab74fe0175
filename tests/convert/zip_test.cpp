// SPDX-License-Identifier: MIT
#include "mscomp/convert/zip.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <cstring>

#include "base/temporary_folder.h"
#include "base/thrown_message.h"
#include "bytes_of.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"

namespace mscomp {
namespace {

using testing::HasSubstr;

template <class T>
std::string field(T value) {
    return {reinterpret_cast<const char*>(&value), sizeof(T)};
}
std::string u16(unsigned value) { return field(static_cast<std::uint16_t>(value)); }
std::string u32(std::uint64_t value) { return field(static_cast<std::uint32_t>(value)); }

std::string deflated(const std::string& text) {
    z_stream stream{};
    deflateInit2(&stream, 9, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY);
    std::string packed(deflateBound(&stream, text.size()), '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
    stream.avail_in = static_cast<uInt>(text.size());
    stream.next_out = reinterpret_cast<Bytef*>(packed.data());
    stream.avail_out = static_cast<uInt>(packed.size());
    EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
    packed.resize(stream.total_out);
    deflateEnd(&stream);
    return packed;
}

/// One file of an archive in the plain 32-bit form; every test spoils one thing.
struct Part {
    std::string name, content;
    bool pack = false;
    unsigned flags = 0, method = pack ? 8 : 0;
    std::string packed = pack ? deflated(content) : content;
    std::uint64_t crc = ::crc32(0, reinterpret_cast<const Bytef*>(content.data()),
                                static_cast<uInt>(content.size()));
    std::uint64_t size = content.size(), packed_size = packed.size();
    std::int64_t position_shift = 0;
    std::string local_name = name;
};

std::string archive(const std::vector<Part>& parts, const std::string& comment = "",
                    unsigned disk = 0) {
    std::string bytes, directory;
    for (const Part& part : parts) {
        const std::string description = u16(part.flags) + u16(part.method) + u32(0) +
                                        u32(part.crc) + u32(part.packed_size) + u32(part.size);
        directory += "PK\x01\x02" + u16(20) + u16(20) + description + u16(part.name.size()) +
                     u16(0) + u16(0) + u16(0) + u16(0) + u32(0) +
                     u32(bytes.size() + static_cast<std::uint64_t>(part.position_shift)) +
                     part.name;
        bytes += "PK\x03\x04" + u16(20) + description + u16(part.local_name.size()) + u16(0) +
                 part.local_name + part.packed;
    }
    const std::string end = "PK\x05\x06" + u16(disk) + u16(disk) + u16(parts.size()) +
                            u16(parts.size()) + u32(directory.size()) + u32(bytes.size()) +
                            u16(comment.size()) + comment;
    return bytes + directory + end;
}

std::string unpacked(const ZipEntry& entry) {
    std::vector<std::byte> storage;
    const auto bytes = unpack(entry, "x.zip", storage);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// The message of reading or unpacking the archive.
std::string zip_refusal(const std::string& bytes) {
    const std::string message = thrown_message<InputError>([&] {
        for (const ZipEntry& entry : read_zip_entries(bytes_of(bytes), "x.zip")) unpacked(entry);
    });
    EXPECT_THAT(message, testing::StartsWith("x.zip: "));
    return message;
}

TEST(Zip, StoredAndDeflatedFilesComeBack) {
    const std::string repeated(3000000, 'a');
    const std::string bytes = archive({{"a", "alpha"}, {"b", repeated, true}, {"c", "", true}});
    const auto entries = read_zip_entries(bytes_of(bytes), "x.zip");
    ASSERT_EQ(entries.size(), 3U);
    EXPECT_EQ(entries[0].name, "a");
    EXPECT_EQ(unpacked(entries[0]), "alpha");
    EXPECT_TRUE(entries[1].deflated);
    EXPECT_EQ(unpacked(entries[1]), repeated);
    EXPECT_EQ(unpacked(entries[2]), "");
}

TEST(Zip, ACommentAndAnEmptyArchiveAreFine) {
    const std::string bytes = archive({{"a", "alpha"}}, "made by hand");
    EXPECT_EQ(read_zip_entries(bytes_of(bytes), "x.zip").size(), 1U);
    const std::string empty = archive({});
    EXPECT_EQ(read_zip_entries(bytes_of(empty), "x.zip").size(), 0U);
}

TEST(Zip, WhatIsWrittenIsReadAndHasTheSameBytesEveryTime) {
    const TemporaryFolder folder;
    const auto write = [&](const std::string& name) {
        AtomicFile file(folder / name);
        ZipWriter writer(file);
        writer.begin_file("one");
        writer.write(std::string_view("first "));
        writer.write(std::string_view("second"));
        writer.begin_file("empty");
        writer.begin_file("three");
        writer.write(std::string_view(std::string(3000000, 'x')));
        writer.finish();
        file.commit();
        return TemporaryFolder::content(folder / name);
    };
    const std::string bytes = write("a.zip");
    EXPECT_EQ(write("b.zip"), bytes);
    const auto entries = read_zip_entries(bytes_of(bytes), "x.zip");
    ASSERT_EQ(entries.size(), 3U);
    EXPECT_EQ(unpacked(entries[0]), "first second");
    EXPECT_EQ(unpacked(entries[1]), "");
    EXPECT_EQ(unpacked(entries[2]), std::string(3000000, 'x'));
}

TEST(Zip, RefusesWhatIsTruncated) {
    const std::string bytes = archive({{"a", "alpha"}, {"b", "beta", true}});
    for (std::size_t length = 0; length < bytes.size(); ++length) {
        zip_refusal(bytes.substr(0, length));
    }
    EXPECT_THAT(zip_refusal("no archive"), HasSubstr("not a zip archive"));
    EXPECT_THAT(zip_refusal(bytes + "x"), HasSubstr("not a zip archive"));
    EXPECT_THAT(zip_refusal("x" + bytes), HasSubstr("directory should be"));
}

TEST(Zip, RefusesFilesThatWereAltered) {
    Part part{"a", "alpha"};
    part.packed = "alphx";
    EXPECT_THAT(zip_refusal(archive({part})), HasSubstr("does not match its checksum"));
    part = {"a", "alpha", true};
    part.crc ^= 1;
    EXPECT_THAT(zip_refusal(archive({part})), HasSubstr("does not match its checksum"));
    part = {"a", std::string(1000, 'a') + "b", true};
    part.packed[part.packed.size() / 2] =
        static_cast<char>(part.packed[part.packed.size() / 2] ^ 16);
    EXPECT_THAT(zip_refusal(archive({part})),
                testing::AnyOf(HasSubstr("damaged"), HasSubstr("checksum")));
}

TEST(Zip, RefusesSizesThatAreNotTrue) {
    Part part{"a", std::string(1000, 'a'), true};
    for (const std::uint64_t size : {0U, 1U, 999U, 1001U, 60000000U}) {
        part.size = size;
        EXPECT_THAT(zip_refusal(archive({part})), HasSubstr("damaged")) << size;
    }
    part = {"a", "alpha"};
    part.size = 6;
    EXPECT_THAT(zip_refusal(archive({part})), HasSubstr("stored with 5 bytes instead of 6"));
    part.packed_size = part.size = 4000000000U;
    EXPECT_THAT(zip_refusal(archive({part})), HasSubstr("truncated"));
    part = {"a", std::string(1000, 'a'), true};
    part.packed += "left over";
    part.packed_size = part.packed.size();
    EXPECT_THAT(zip_refusal(archive({part})), HasSubstr("damaged"));
}

// Memory grows with what is there, not with what is claimed; and what is there may not explode.
TEST(Zip, RefusesBombs) {
    Part part{"a", "alpha", true};
    part.size = 4000000000U;
    EXPECT_THAT(zip_refusal(archive({part})), HasSubstr("would unpack to 4000000000 bytes"));
    const std::string bomb = archive({{"a", std::string(90U << 20, '\0'), true}});
    EXPECT_THAT(zip_refusal(bomb), HasSubstr("would unpack to 94371840 bytes"));
    std::vector<Part> half(2, {"a", std::string(45U << 20, '\0'), true});
    half[1].name = half[1].local_name = "b";
    EXPECT_THAT(zip_refusal(archive(half)), HasSubstr("'b' would unpack"));
}

TEST(Zip, RefusesTooManyFiles) {
    std::vector<Part> parts;
    for (int i = 0; i < 1001; ++i) parts.push_back({std::to_string(i), ""});
    EXPECT_THAT(zip_refusal(archive(parts)), HasSubstr("1001 files, wanted at most 1000"));
}

TEST(Zip, RefusesFilesThatOverlap) {
    Part first{"a", "alpha"}, second{"a", "alpha"};
    second.position_shift = -static_cast<std::int64_t>(36);
    EXPECT_THAT(zip_refusal(archive({first, second})), HasSubstr("twice"));
    // One file whose content is another file, which the directory names too.
    const std::string inner = archive({{"b", "beta"}}).substr(0, 35);
    Part outer{"a", inner}, hidden{"b", "beta"};
    hidden.position_shift = -static_cast<std::int64_t>(inner.size());
    EXPECT_THAT(zip_refusal(archive({outer, hidden})), HasSubstr("overlap"));
}

TEST(Zip, RefusesADirectoryThatContradictsItsFiles) {
    Part part{"a", "alpha"};
    part.local_name = "b";
    EXPECT_THAT(zip_refusal(archive({part})), HasSubstr("differs from its entry"));
    part = {"a", "alpha"};
    part.position_shift = 3;
    EXPECT_THAT(zip_refusal(archive({part})), HasSubstr("where no file begins"));
    part.position_shift = 2000000000;
    EXPECT_THAT(zip_refusal(archive({part})), HasSubstr("where no file begins"));
}

TEST(Zip, RefusesWhatItCannotRead) {
    Part part{"a", "alpha"};
    part.flags = 1;
    EXPECT_THAT(zip_refusal(archive({part})), HasSubstr("encrypted"));
    part.flags = 0;
    part.method = 12;
    EXPECT_THAT(zip_refusal(archive({part})), HasSubstr("method 12"));
    EXPECT_THAT(zip_refusal(archive({{"a", "alpha"}}, "", 1)), HasSubstr("split"));
}

}  // namespace
}  // namespace mscomp
