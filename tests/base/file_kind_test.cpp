// SPDX-License-Identifier: MIT
#include "mscomp/base/file_kind.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/temporary_folder.h"
#include "base/thrown_message.h"
#include "mscomp/base/error.h"
#include "mscomp/base/safetensors.h"

namespace mscomp {
namespace {

using namespace std::string_literals;
using testing::AllOf;
using testing::HasSubstr;

struct Example {
    std::string bytes, name, cure;
};

// First bytes as the programs write them: gzip, xz, bzip2, zstd, zip, ...
std::vector<Example> examples() {
    std::string stl = "made by hand"s + std::string(68, ' ') + "\1\0\0\0"s + std::string(50, 'x');
    return {
        {"\x1f\x8b\x08\0\0\0"s, "gzip", "unpack"},
        {"\xfd"
         "7zXZ\0\0\4"s,
         "xz", "unpack"},
        {"BZh91AY&SY\x12"s, "bzip2", "unpack"},
        {"\x28\xb5\x2f\xfd\4"s, "zstd", "unpack"},
        {"PK\3\4\x14\0"s, "zip", "unpack"},
        {"7z\xbc\xaf\x27\x1c\0"s, "7-Zip", "unpack"},
        {"Rar!\x1a\7\1"s, "RAR", "unpack"},
        {"\x89HDF\r\n\x1a\n\0"s, "HDF5", "convert"},
        {"MATLAB 7.3 MAT-file, Platform: GLNXA64", "MATLAB 7.3", "npz"},
        {"MATLAB 5.0 MAT-file, Platform: GLNXA64", "MATLAB", "npz"},
        {"version https://git-lfs.github.com/spec/v1\noid sha256:4d\nsize 1\n", "Git LFS",
         "git lfs pull"},
        {"/annex/objects/SHA256E-s1--4d.obj\n", "git-annex", "git annex get"},
        {"\n  <!doctype html>\n", "HTML", "download"},
        {"\xEF\xBB\xBF<HTML><head>", "HTML", "download"},
        {"<?xml version=\"1.0\"?><COLLADA>", "XML", "OBJ"},
        {"%PDF-1.7\n", "PDF", "file"},
        {"\x89PNG\r\n\x1a\n\0"s, "picture", "mesh"},
        {"\xff\xd8\xff\xe0"s, "picture", "mesh"},
        {"Kaydara FBX Binary  \0"s, "FBX", "OBJ"},
        {"glTF\2\0\0\0"s, "glTF", "OBJ"},
        {"solid cube\n facet normal 0 0 1\n", "STL", "OBJ"},
        {stl, "STL", "OBJ"},
        {"\x93NUMPY\1\0v\0"s, "numpy", ".npy"},
        {"\x80\4\x95\0\0"s, "pickle", "savez"},
        {"\2\0\0\0\0\0\0\0{}"s, "safetensors", ".safetensors"},
        {"\0\5\x16\7\0\2"s, "AppleDouble", "without ._"},
        {"# vtk DataFile Version 3.0\n", "VTK", "OBJ"},
    };
}

TEST(FileKind, IsKnownByTheFirstBytes) {
    for (const Example& example : examples()) {
        EXPECT_THAT(thrown_message<InputError>([&] { refuse_other_kinds(example.bytes, "x"); }),
                    AllOf(testing::StartsWith("x: this is a"), HasSubstr(example.name),
                          HasSubstr(": "), HasSubstr(example.cure)))
            << example.name;
    }
}

// No mesh, list, table or configuration is taken for another kind.
TEST(FileKind, OfTextIsNone) {
    for (const std::string text :
         {"", "v 0 0 0\n", "# comment\nv 1 2 3\n", "OFF\n4 4 0\n", "ply\nformat ascii 1.0\n", "PK",
          "solid/1.obj\nsolid/2.obj\n", "BLENDER/1.obj\n", "glTF/1.obj\n", "GIF8/1.obj\n", "0\n1\n",
          "{\"handles\": []}", "model:\n  kind: pca\n", "version: 1\n", "<1>\n", "II/1.obj\n",
          "Ogawa/1.obj\n", "MM/1.obj\n", "BZh/1.obj\n"}) {
        EXPECT_FALSE(file_kind(text)) << text;
    }
}

TEST(FileKind, IsLookedForInEveryTextFile) {
    const TemporaryFolder folder;
    for (const Example& example : examples()) {
        const std::string path = folder.put("list", example.bytes);
        EXPECT_THAT(thrown_message<InputError>([&] { read_text_file(path, "a list"); }),
                    HasSubstr(example.name));
    }
    EXPECT_THAT(thrown_message<InputError>([&] {
                    read_text_file(folder.put("l",
                                              "\xFF\xFE"
                                              "1\0"s),
                                   "a list");
                }),
                HasSubstr("got UTF-16 text, expected a list in ASCII or UTF-8"));
    EXPECT_EQ(read_text_file(folder.put("bom",
                                        "\xEF\xBB\xBF"
                                        "1\n"),
                             "a list"),
              "1\n");
    EXPECT_EQ(read_text_file(folder.put("empty", ""), "a list"), "");
}

// Eight bytes of a length may be those of another kind; the "{" behind them tells.
TEST(FileKind, OfASafetensorsFileIsItsOwn) {
    const TemporaryFolder folder;
    EXPECT_THAT(thrown_message<InputError>([&] {
                    SafetensorsFile(folder.put("a.safetensors", "\x1f\x8b\x08\0\0\0\0\0\0\3ab"s));
                }),
                HasSubstr("this is a gzip file: unpack it"));
    EXPECT_THAT(thrown_message<InputError>([&] {
                    SafetensorsFile(folder.put("b.safetensors", "\x1f\x8b\x08\0\0\0\0\0{}"s));
                }),
                HasSubstr("truncated or not a safetensors file"));
}

}  // namespace
}  // namespace mscomp
