// SPDX-License-Identifier: MIT
#include "mscomp/convert/npy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "base/thrown_message.h"
#include "bytes_of.h"
#include "mscomp/base/error.h"

namespace mscomp {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using namespace std::string_literals;

template <class T>
std::string raw(const std::vector<T>& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

/// An array as numpy 1.24 writes it: header padded with blanks to `length` and a line end.
std::string numpy_file(const std::string& dictionary, const std::string& data, char version = 1) {
    std::string text = dictionary;
    text.append(117 - text.size(), ' ');
    text += '\n';
    const std::uint32_t length = static_cast<std::uint32_t>(text.size());
    std::string file = std::string("\x93NUMPY") + version + '\0';
    file.append(reinterpret_cast<const char*>(&length), version == 1 ? 2 : 4);
    return file + text + data;
}

std::string numpy_floats(const std::string& shape, std::size_t count) {
    return numpy_file("{'descr': '<f4', 'fortran_order': False, 'shape': " + shape + ", }",
                      std::string(4 * count, '\0'));
}

std::string refusal(const std::string& file) {
    const std::string message =
        thrown_message<InputError>([&] { parse_npy(bytes_of(file), "x.npy"); });
    EXPECT_THAT(message, testing::StartsWith("x.npy: "));
    return message;
}

TEST(Npy, ReadsWhatNumpyWrites) {
    const std::string file =
        numpy_file("{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }",
                   raw<double>({0, 0.25, 0.5, 0.75, 1, 1.25}));
    const NpyArray array = parse_npy(bytes_of(file), "x.npy");
    EXPECT_EQ(array.type, NpyType::f64);
    EXPECT_EQ(array.shape, Shape({2, 3}));
    EXPECT_THAT(array.doubles(0, 2), ElementsAre(0, 0.25, 0.5, 0.75, 1, 1.25));
    EXPECT_THAT(array.doubles(1, 1), ElementsAre(0.75, 1, 1.25));
    EXPECT_THAT(array.floats(1, 1), ElementsAre(0.75F, 1.0F, 1.25F));
    EXPECT_THAT(array.doubles(2, 0), ElementsAre());
}

// numpy.asfortranarray(numpy.arange(12).reshape(2, 3, 2)) lies in memory with the first axis
// fastest: 0 6 2 8 4 10 1 7 3 9 5 11.
TEST(Npy, FortranOrderIsTransposed) {
    const std::string file =
        numpy_file("{'descr': '<f4', 'fortran_order': True, 'shape': (2, 3, 2), }",
                   raw<float>({0, 6, 2, 8, 4, 10, 1, 7, 3, 9, 5, 11}));
    const NpyArray array = parse_npy(bytes_of(file), "x.npy");
    EXPECT_THAT(array.doubles(0, 2), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11));
    EXPECT_THAT(array.doubles(1, 1), ElementsAre(6, 7, 8, 9, 10, 11));
    const std::string faces =
        numpy_file("{'descr': '<i8', 'fortran_order': True, 'shape': (2, 3), }",
                   raw<std::int64_t>({0, 2, 1, 1, 2, 3}));
    EXPECT_THAT(parse_npy(bytes_of(faces), "x").integers(), ElementsAre(0, 1, 2, 2, 1, 3));
}

// 1, -2.5, the smallest and the largest number, infinity, as numpy.float16 has them.
TEST(Npy, ReadsHalves) {
    const std::string file = numpy_file("{'descr': '<f2', 'fortran_order': False, 'shape': (4,), }",
                                        raw<std::uint16_t>({0x3c00, 0xc100, 0x0001, 0x7bff}));
    EXPECT_THAT(parse_npy(bytes_of(file), "x").doubles(0, 4),
                ElementsAre(1, -2.5, std::ldexp(1.0, -24), 65504));
    const std::string infinite = numpy_file(
        "{'descr': '<f2', 'fortran_order': False, 'shape': (1,), }", raw<std::uint16_t>({0x7c00}));
    EXPECT_THAT(
        thrown_message<InputError>([&] { parse_npy(bytes_of(infinite), "x").doubles(0, 1); }),
        HasSubstr("[0] is inf"));
}

TEST(Npy, ReadsEitherByteOrderAndEveryIntegerType) {
    const auto file = [](const std::string& descr, const std::string& data) {
        return numpy_file("{'descr': '" + descr + "', 'fortran_order': False, 'shape': (2,), }",
                          data);
    };
    const std::string one_and_half("\x3f\xf0\0\0\0\0\0\0\x3f\xe0\0\0\0\0\0\0", 16);
    EXPECT_THAT(parse_npy(bytes_of(file(">f8", one_and_half)), "x").doubles(0, 2),
                ElementsAre(1, 0.5));
    const auto integers = [&](const std::string& descr, const std::string& data) {
        const std::string bytes = file(descr, data);
        return parse_npy(bytes_of(bytes), "x").integers();
    };
    EXPECT_THAT(integers(">i4", std::string("\0\0\1\2\xff\xff\xff\xff", 8)), ElementsAre(258, -1));
    EXPECT_THAT(integers("<i2", raw<std::int16_t>({-7, 300})), ElementsAre(-7, 300));
    EXPECT_THAT(integers("|u1", raw<std::uint8_t>({0, 255})), ElementsAre(0, 255));
    EXPECT_THAT(integers("|i1", raw<std::int8_t>({-1, 127})), ElementsAre(-1, 127));
    EXPECT_THAT(integers("<u2", raw<std::uint16_t>({0, 65535})), ElementsAre(0, 65535));
    EXPECT_THAT(integers("<u4", raw<std::uint32_t>({0, 70000})), ElementsAre(0, 70000));
    EXPECT_THAT(integers("<u8", raw<std::uint64_t>({5, 6})), ElementsAre(5, 6));
    EXPECT_THAT(integers("<f8", raw<double>({5, 6})), ElementsAre(5, 6));
    EXPECT_THAT(thrown_message<InputError>([&] {
                    integers("<u8", raw<std::uint64_t>({~0ULL, 6}));
                }),
                HasSubstr("integer of 32 bits"));
    EXPECT_THAT(thrown_message<InputError>([&] {
                    integers("<f4", raw<float>({0.5F, 6}));
                }),
                HasSubstr("no integers but 0.5"));
    const std::string texts = file("|S3", std::string("ab\0cde", 6));
    EXPECT_THAT(parse_npy(bytes_of(texts), "x").texts(), ElementsAre("ab", "cde"));
    EXPECT_THAT(thrown_message<InputError>([&] { parse_npy(bytes_of(file("|O", "")), "x"); }),
                HasSubstr("Python objects"));
}

TEST(Npy, ReadsAllThreeFormats) {
    for (const char version : {1, 2, 3}) {
        const std::string file =
            numpy_file("{'descr': '<i4', 'fortran_order': False, 'shape': (3,), }",
                       raw<std::int32_t>({0, -1, 2147483647}), version);
        EXPECT_THAT(parse_npy(bytes_of(file), "x").integers(), ElementsAre(0, -1, 2147483647));
    }
    EXPECT_THAT(refusal(std::string("\x93NUMPY\x04\0v\0", 10)), HasSubstr("format 4.0"));
}

// numpy keeps text as UTF-32, padded with zeros.
TEST(Npy, TextIsUtf8Outside) {
    const std::u32string characters = U"rest\0\0\0\0caf\u00e9 \u4e2d\U0001F600\0"s;
    const std::string data(reinterpret_cast<const char*>(characters.data()), 2 * 8 * 4);
    const std::string file =
        numpy_file("{'descr': '<U8', 'fortran_order': False, 'shape': (2,), }", data);
    const std::vector<std::string> texts = parse_npy(bytes_of(file), "x").texts();
    EXPECT_THAT(texts, ElementsAre("rest", "caf\xc3\xa9 \xe4\xb8\xad\xf0\x9f\x98\x80"));
    EXPECT_EQ(parse_npy(bytes_of(npy_texts(texts)), "x").texts(), texts);
    EXPECT_EQ(parse_npy(bytes_of(npy_texts({"authors"}, true)), "x").shape, Shape());
    EXPECT_THAT(parse_npy(bytes_of(npy_texts({"authors"}, true)), "x").texts(),
                ElementsAre("authors"));
}

TEST(Npy, BytesThatAreNoUtf8AreReplaced) {
    const std::string replaced = "\xef\xbf\xbd";
    const auto back = [](const std::string& text) {
        const std::string file = npy_texts({text, "next"});
        return parse_npy(bytes_of(file), "x").texts().front();
    };
    EXPECT_EQ(back("a\xff"
                   "b"),
              "a" + replaced + "b");
    EXPECT_EQ(back("a\xc3"), "a" + replaced);                         // cut off
    EXPECT_EQ(back("\xc0\xaf"), replaced + replaced);                 // longer than needed
    EXPECT_EQ(back("\xed\xa0\x80"), replaced + replaced + replaced);  // a surrogate
    EXPECT_EQ(back(""), "");
}

TEST(Npy, WhatIsWrittenIsRead) {
    const std::string file = npy_header(NpyType::f32, {2, 1}, 4) + raw<float>({1.5F, -0.0F});
    EXPECT_EQ(npy_header(NpyType::f32, {2, 1}, 4).size() % 64, 0U);
    const NpyArray array = parse_npy(bytes_of(file), "x");
    EXPECT_EQ(array.shape, Shape({2, 1}));
    EXPECT_EQ(array.floats(0, 2)[0], 1.5F);
    EXPECT_TRUE(std::signbit(array.floats(0, 2)[1]));
}

TEST(Npy, TheDictionaryMayBeSpacedAndOrderedOtherwise) {
    const std::string file = numpy_file(
        "{ \"shape\" : ( 1 , 2 , ) , 'fortran_order':False,'descr':\"<f4\"}", std::string(8, '\0'));
    EXPECT_EQ(parse_npy(bytes_of(file), "x").shape, Shape({1, 2}));
}

TEST(Npy, RefusesWhatIsNoArray) {
    EXPECT_THAT(refusal(""), HasSubstr("not a numpy array"));
    EXPECT_THAT(refusal("PK\x03\x04 and so on"), HasSubstr("this is a zip archive"));
    EXPECT_THAT(refusal(std::string("\x93NUMPY\x01\0\xff\xff", 10)), HasSubstr("truncated"));
    EXPECT_THAT(refusal(std::string("\x93NUMPY\x02\0\xff\xff\xff\xff", 12)),
                HasSubstr("truncated"));
    EXPECT_THAT(refusal(std::string("\x93NUMPY\x02\0\0", 9)), HasSubstr("numpy array"));
    std::string long_header("\x93NUMPY\x02\0\x01\0\x01\0", 12);
    EXPECT_THAT(refusal(long_header + std::string(70000, ' ')), HasSubstr("at most 65536"));
}

TEST(Npy, RefusesHeadersThatAreNoPlainDictionary) {
    const auto with = [](const std::string& dictionary) {
        return refusal(numpy_file(dictionary, std::string(24, '\0')));
    };
    const std::string rest = "'fortran_order': False, 'shape': (2, 3), }";
    EXPECT_THAT(with(""), HasSubstr("no '{' here"));
    EXPECT_THAT(with("{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), "),
                HasSubstr("no string here"));
    EXPECT_THAT(with("{'descr': '<f4', " + rest + " + 1"), HasSubstr("goes on"));
    EXPECT_THAT(with("{'descr': '<f4', 'descr': '<f4', " + rest), HasSubstr("'descr' twice"));
    EXPECT_THAT(with("{'descr': '<f4', 'shape': (2, 3)}"), HasSubstr("no 'fortran_order'"));
    EXPECT_THAT(with("{'x': '<f4', " + rest), HasSubstr("unknown key 'x'"));
    EXPECT_THAT(with("{'descr': [('a', '<f4')], " + rest), HasSubstr("structured"));
    EXPECT_THAT(with("{'descr': '<f4, " + rest), HasSubstr("numpy header"));
    EXPECT_THAT(with("{'descr': '<f4', 'fortran_order': 0, 'shape': (2, 3), }"),
                HasSubstr("neither True nor False"));
    for (const char* shape :
         {"(2, -3)", "(2, 3.0)", "(2 3)", "(99999999999999999999, 1)", "(6)", "2, 3", "(2, x)"}) {
        EXPECT_THAT(
            with("{'descr': '<f4', 'fortran_order': False, 'shape': " + std::string(shape) + ", }"),
            HasSubstr("numpy header, at its byte"))
            << shape;
    }
}

TEST(Npy, RefusesTypesItDoesNotKnow) {
    for (const char* descr :
         {"<f16", "<c16", "|S0", "<U0", "<U", "<U99999999999", "|b1", "<f", ""}) {
        EXPECT_THAT(refusal(numpy_file("{'descr': '" + std::string(descr) +
                                           "', 'fortran_order': False, 'shape': (0,), }",
                                       "")),
                    HasSubstr("wanted '<f4', '<f8'"))
            << descr;
    }
}

TEST(Npy, EmptyArraysHaveNoEntriesHoweverLongTheOtherAxes) {
    const std::string file = numpy_file(
        "{'descr': '<f8', 'fortran_order': True, 'shape': (4, 9223372036854775807, 9, 0), }", "");
    EXPECT_THAT(parse_npy(bytes_of(file), "x").doubles(0, 4), ElementsAre());
}

// A hostile shape is measured against the file before anything is allocated.
TEST(Npy, RefusesShapesThatDoNotMatchTheData) {
    EXPECT_THAT(refusal(numpy_floats("(2, 3)", 5)), AllOf(HasSubstr("24 bytes"), HasSubstr("20")));
    EXPECT_THAT(refusal(numpy_floats("(2, 3)", 7)), HasSubstr("28"));
    EXPECT_THAT(refusal(numpy_floats("(4294967296, 4294967296)", 1)), HasSubstr("more than 2^62"));
    EXPECT_THAT(refusal(numpy_floats("(9223372036854775807, 2)", 1)), HasSubstr("more than 2^62"));
    EXPECT_THAT(refusal(numpy_floats("(1000000000, 7000, 3)", 1)), HasSubstr("are there"));
}

TEST(Npy, ReadingAnotherTypeIsRefused) {
    const std::string floats = numpy_floats("(2,)", 2);
    const NpyArray array = parse_npy(bytes_of(floats), "x");
    EXPECT_THAT(array.integers(), ElementsAre(0, 0));  // whole numbers of any type
    EXPECT_THAT(thrown_message<InputError>([&] { array.texts(); }), HasSubstr("no text"));
    const std::string whole =
        numpy_file("{'descr': '<i8', 'fortran_order': False, 'shape': (1,), }",
                   raw<std::int64_t>({std::int64_t{1} << 31}));
    const NpyArray integers = parse_npy(bytes_of(whole), "x");
    EXPECT_THAT(integers.floats(0, 1), ElementsAre(2147483648.0F));
    const std::string words = npy_texts({"a"});
    EXPECT_THAT(thrown_message<InputError>([&] { parse_npy(bytes_of(words), "x").floats(0, 1); }),
                HasSubstr("holds no numbers"));
    EXPECT_THAT(thrown_message<InputError>([&] { integers.integers(); }), HasSubstr("2147483648"));
}

TEST(Npy, NumbersThatAreNotFiniteAreRefusedWithTheirPlace) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const std::string file =
        numpy_file("{'descr': '<f8', 'fortran_order': True, 'shape': (2, 3), }",
                   raw<double>({0, 0, 0, nan, 1e300, 0}));
    const NpyArray array = parse_npy(bytes_of(file), "x");
    // In Fortran order the fourth and fifth numbers are [1, 1] and [0, 2].
    EXPECT_THAT(thrown_message<InputError>([&] { array.doubles(0, 2); }),
                HasSubstr("[1, 1] is nan"));
    EXPECT_THAT(thrown_message<InputError>([&] { array.doubles(1, 1); }),
                HasSubstr("[1, 1] is nan"));
    EXPECT_THAT(thrown_message<InputError>([&] { array.floats(0, 1); }),
                AllOf(HasSubstr("[0, 2] is 1e+300"), HasSubstr("float32")));
    EXPECT_TRUE(std::isnan(array.doubles(1, 1, true)[1]));
}

}  // namespace
}  // namespace mscomp
