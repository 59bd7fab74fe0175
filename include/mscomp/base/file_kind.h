// SPDX-License-Identifier: MIT
// What a file is by its first bytes, for readers that got another one than they wanted.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace mscomp {

/// A kind of file that none of our text readers reads, and what turns it into one that is read.
struct FileKind {
    std::string_view name;  // "a gzip file"
    std::string_view cure;  // "unpack it"
};

/// By the first bytes (of binary STL by the size as well); none for what is not in the table, plain
/// text among it.
std::optional<FileKind> file_kind(std::string_view bytes);

/// Throws InputError "this is a gzip file: unpack it" where `bytes` are of a known kind. A reader
/// of such a kind looks for its own first bytes before it asks.
void refuse_other_kinds(std::string_view bytes, const std::string& path);

/// Where the text begins: behind a UTF-8 byte order mark. Throws InputError if there is nothing, or
/// if it is UTF-16, UTF-32 or of a known kind; `wanted` is such as "an OBJ mesh".
std::size_t text_begin(std::string_view bytes, const std::string& path, std::string_view wanted);

/// The text of a file, from text_begin on; empty of an empty file. Throws IoError, InputError.
std::string read_text_file(const std::string& path, std::string_view wanted);

}  // namespace mscomp
