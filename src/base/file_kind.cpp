// SPDX-License-Identifier: MIT
#include "mscomp/base/file_kind.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"

namespace mscomp {
namespace {

using namespace std::string_view_literals;

struct Signature {
    std::size_t place;  // of the bytes in the file
    std::string_view bytes;
    FileKind kind;
};

constexpr FileKind kMatlab73{"a MATLAB 7.3 file (HDF5)",
                             "save its arrays as .npz, or as HDF5 in the form of SPLOCS"};
constexpr FileKind kZip{"a zip archive", "unpack it; archives of numpy arrays are called .npz"};
constexpr FileKind kLfs{"a Git LFS pointer", "run git lfs pull"};
constexpr FileKind kPickle{"a Python pickle", "save its arrays with numpy.savez"};
constexpr FileKind kHtml{"a web page (HTML)", "download the file itself"};
constexpr FileKind kXml{"an XML file", "export as OBJ, PLY or OFF"};
constexpr FileKind kStl{"an STL mesh, which has no common vertices", "convert it to OBJ or PLY"};
constexpr FileKind kBlender{"a Blender file", "export as OBJ, PLY or OFF"};
constexpr FileKind kAlembic{"an Alembic file", "export its frames as OBJ, PLY or OFF"};
constexpr FileKind kPicture{"a picture", "name the mesh"};

constexpr Signature kSignatures[] = {
    {0, "\x1f\x8b"sv, {"a gzip file", "unpack it"}},
    {0, "\x1f\x9d"sv, {"a compress (.Z) file", "unpack it"}},
    {0,
     "\xfd"
     "7zXZ\0"sv,
     {"an xz file", "unpack it"}},
    {4, "1AY&SY"sv, {"a bzip2 file", "unpack it"}},
    {0, "\x28\xb5\x2f\xfd"sv, {"a zstd file", "unpack it"}},
    {0, "\x04\x22\x4d\x18"sv, {"an lz4 file", "unpack it"}},
    {0, "LZIP\x01"sv, {"an lzip file", "unpack it"}},
    {0, "7z\xbc\xaf\x27\x1c"sv, {"a 7-Zip archive", "unpack it"}},
    {0, "Rar!\x1a\x07"sv, {"a RAR archive", "unpack it"}},
    {0, "PK\x03\x04"sv, kZip},
    {0, "PK\x05\x06"sv, kZip},
    {257, "ustar"sv, {"a tar archive", "unpack it"}},
    {0, "version https://git-lfs."sv, kLfs},
    {0, "version https://hawser.github.com/"sv, kLfs},
    {0, "/annex/objects/"sv, {"a git-annex pointer", "run git annex get"}},
    {0, "MATLAB 7.3 MAT-file"sv, kMatlab73},
    {0, "MATLAB 5.0 MAT-file"sv, {"a MATLAB file", "save its arrays as .npz (scipy.io.loadmat)"}},
    {0, "\x89HDF\r\n\x1a\n"sv, {"an HDF5 file", "convert it; its extension is .h5"}},
    {0, "\x93NUMPY"sv, {"a numpy array", "convert it; its extension is .npy"}},
    {0, "%PDF-"sv, {"a PDF", "name the file itself"}},
    {0, "\x89PNG\r\n\x1a\n"sv, kPicture},
    {0, "\xff\xd8\xff"sv, kPicture},
    {0, "GIF87a"sv, kPicture},
    {0, "GIF89a"sv, kPicture},
    {0, "II*\0"sv, kPicture},
    {0, "MM\0*"sv, kPicture},
    {0, "Kaydara FBX Binary"sv, {"an FBX file", "export as OBJ, PLY or OFF"}},
    {0, "; FBX "sv, {"an FBX file", "export as OBJ, PLY or OFF"}},
    {0, "glTF\x02\0"sv, {"a binary glTF file", "export as OBJ, PLY or OFF"}},
    {0, "BLENDER-v"sv, kBlender},
    {0, "BLENDER_v"sv, kBlender},
    {0, "BLENDER17-"sv, kBlender},
    {0, "Ogawa\0"sv, kAlembic},
    {0, "Ogawa\xff"sv, kAlembic},
    {0, "PXR-USDC"sv, {"a USD file", "export as OBJ, PLY or OFF"}},
    {0, "#usda "sv, {"a USD file", "export as OBJ, PLY or OFF"}},
    {0, "# vtk DataFile"sv, {"a VTK file", "export as OBJ, PLY or OFF"}},
    {0, "#VRML"sv, {"a VRML file", "export as OBJ, PLY or OFF"}},
    {0, "//Maya ASCII"sv, {"a Maya file", "export as OBJ, PLY or OFF"}},
    {0, "\0\x05\x16\x07"sv, {"a side file of a Mac (AppleDouble)", "name the file without ._"}},
    {0, "{\\rtf"sv, {"a text with formatting (RTF)", "save it as plain text"}},
};

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

/// Whether `bytes` begin with `word`, in any case.
bool begins_with(std::string_view bytes, std::string_view word) {
    const auto lower = [](char c) { return 'A' <= c && c <= 'Z' ? static_cast<char>(c + 32) : c; };
    return bytes.size() >= word.size() &&
           std::equal(word.begin(), word.end(), bytes.begin(),
                      [&](char a, char b) { return lower(a) == lower(b); });
}

std::optional<FileKind> kind_of_markup(std::string_view bytes) {
    if (bytes.starts_with("\xEF\xBB\xBF")) bytes.remove_prefix(3);
    while (!bytes.empty() && is_blank(bytes.front())) bytes.remove_prefix(1);
    if (begins_with(bytes, "<!doctype html") || begins_with(bytes, "<html")) return kHtml;
    if (bytes.starts_with("<?xml")) return kXml;
    return std::nullopt;
}

/// Protocols 2 to 5 begin with their number; what follows opens a frame, a tuple, a list, ...
bool is_pickle(std::string_view bytes) {
    return bytes.size() > 3 && bytes[0] == '\x80' && bytes[1] >= 2 && bytes[1] <= 5;
}

bool is_stl(std::string_view bytes) {
    constexpr std::size_t header = 84, triangle = 50;
    if (bytes.starts_with("solid")) {
        return bytes.substr(0, 1000).find("facet normal") != std::string_view::npos;
    }
    if (bytes.size() < header + triangle) return false;
    std::uint32_t count = 0;
    std::memcpy(&count, bytes.data() + header - 4, sizeof(count));
    return bytes.size() == header + triangle * count;
}

/// 8 bytes of length, then JSON: "{" and a name or nothing.
bool is_safetensors(std::string_view bytes) {
    if (bytes.size() < 10) return false;
    std::uint64_t length = 0;
    std::memcpy(&length, bytes.data(), sizeof(length));
    return length <= bytes.size() - 8 && bytes[8] == '{' && (bytes[9] == '"' || bytes[9] == '}');
}

/// By the mark at its start or, where there is none, by the zeros between ASCII characters.
std::string_view wide_encoding(std::string_view bytes) {
    if (bytes.starts_with("\xFF\xFE\0\0"sv) || bytes.starts_with("\0\0\xFE\xFF"sv)) return "UTF-32";
    if (bytes.starts_with("\xFF\xFE"sv) || bytes.starts_with("\xFE\xFF"sv)) return "UTF-16";
    if (bytes.size() < 4) return "";
    const bool high_first = bytes[0] == 0 && bytes[1] != 0 && bytes[2] == 0 && bytes[3] != 0;
    const bool low_first = bytes[0] != 0 && bytes[1] == 0 && bytes[2] != 0 && bytes[3] == 0;
    return high_first || low_first ? "UTF-16" : "";
}

}  // namespace

std::optional<FileKind> file_kind(std::string_view bytes) {
    for (const Signature& signature : kSignatures) {
        if (bytes.size() > signature.place &&
            bytes.substr(signature.place).starts_with(signature.bytes)) {
            return signature.kind;
        }
    }
    if (const auto kind = kind_of_markup(bytes)) return kind;
    if (is_safetensors(bytes)) {
        return FileKind{"a safetensors file", "convert it; its extension is .safetensors"};
    }
    if (is_pickle(bytes)) return kPickle;
    if (is_stl(bytes)) return kStl;
    return std::nullopt;
}

void refuse_other_kinds(std::string_view bytes, const std::string& path) {
    const std::optional<FileKind> kind = file_kind(bytes);
    if (kind) throw InputError({path}, fmt::format("this is {}: {}", kind->name, kind->cure));
}

std::size_t text_begin(std::string_view bytes, const std::string& path, std::string_view wanted) {
    if (bytes.empty())
        throw InputError({path}, fmt::format("the file is empty, expected {}", wanted));
    refuse_other_kinds(bytes, path);
    if (const std::string_view encoding = wide_encoding(bytes); !encoding.empty()) {
        throw InputError({path, 1, 1}, fmt::format("got {} text, expected {} in ASCII or UTF-8",
                                                   encoding, wanted));
    }
    return bytes.starts_with("\xEF\xBB\xBF") ? 3 : 0;
}

std::string read_text_file(const std::string& path, std::string_view wanted) {
    std::string text = read_file(path);
    if (!text.empty()) text.erase(0, text_begin(text, path, wanted));
    return text;
}

}  // namespace mscomp
