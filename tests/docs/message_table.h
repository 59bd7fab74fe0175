// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace mscomp {

/// A message as docs/messages.md writes it.
struct DocumentedMessage {
    std::string text;                  // as on the page
    std::string section;               // heading, with the exit code in brackets
    std::vector<std::string> literal;  // what stands between *names* and …, in this order
};

/// The first column of every table of the page, several messages in a cell taken apart.
std::vector<DocumentedMessage> documented_messages(const std::string& page);

/// Whether the literal parts occur in `message` one after the other.
bool matches(const DocumentedMessage& documented, std::string_view message);

/// A string literal of a source file; neighbouring literals are one.
struct SourceLiteral {
    std::string file;
    std::string text;                // unescaped
    std::vector<std::string> parts;  // between the {} of fmt
};

std::vector<SourceLiteral> source_literals(const std::string& folder);

/// Without blanks, line ends and colons at both ends.
std::string_view trimmed(std::string_view text);

std::string_view longest(const std::vector<std::string>& parts);

}  // namespace mscomp
