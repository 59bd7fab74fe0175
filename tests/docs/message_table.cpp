// SPDX-License-Identifier: MIT
#include "docs/message_table.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace mscomp {
namespace {

constexpr std::string_view kEllipsis = "…";
constexpr std::string_view kSeparator = " · ";

std::vector<std::string> literal_parts(std::string_view markdown) {
    std::vector<std::string> parts(1);
    bool is_name = false;
    for (std::size_t at = 0; at < markdown.size(); ++at) {
        if (markdown.substr(at).starts_with(kEllipsis)) {
            parts.emplace_back();
            at += kEllipsis.size() - 1;
        } else if (markdown[at] == '*') {
            is_name = !is_name;
            if (is_name) parts.emplace_back();
        } else {
            if (markdown[at] == '\\') ++at;
            if (!is_name) parts.back() += markdown[at];
        }
    }
    return parts;
}

std::vector<std::string> parts_between_fields(const std::string& text) {
    std::vector<std::string> parts(1);
    for (std::size_t at = 0; at < text.size(); ++at) {
        const bool is_doubled = at + 1 < text.size() && text[at] == text[at + 1];
        if (text[at] == '{' && !is_doubled) {
            at = std::min(text.find('}', at), text.size());
            parts.emplace_back();
            continue;
        }
        parts.back() += text[at];
        if (is_doubled && (text[at] == '{' || text[at] == '}')) ++at;
    }
    return parts;
}

/// Literals of one file, as far as a scan by lines tells: comments, preprocessor lines and
/// static_asserts are passed over.
class LiteralScan {
  public:
    std::vector<std::string> literals;

    void line(std::string_view text) {
        const std::string_view begin =
            text.substr(std::min(text.find_first_not_of(' '), text.size()));
        if (begin.starts_with("//") || begin.starts_with("#")) return;
        if (begin.starts_with("static_assert")) return;
        for (std::size_t at = 0; at < text.size(); ++at) {
            if (text.substr(at).starts_with("//")) return;
            if (text.substr(at).starts_with("'\"'")) {
                at += 2;
                goes_on_ = false;
            } else if (text[at] == '"') {
                at = literal(text, at + 1);
            } else if (text[at] != ' ') {
                goes_on_ = false;
            }
        }
    }

  private:
    std::size_t literal(std::string_view text, std::size_t at) {
        if (!goes_on_) literals.emplace_back();
        goes_on_ = true;
        for (; at < text.size() && text[at] != '"'; ++at) {
            const bool is_escaped = text[at] == '\\' && at + 1 < text.size();
            if (is_escaped) ++at;
            literals.back() += is_escaped && text[at] == 'n' ? '\n' : text[at];
        }
        return at;
    }

    bool goes_on_ = false;
};

}  // namespace

std::vector<DocumentedMessage> documented_messages(const std::string& page) {
    std::vector<DocumentedMessage> messages;
    std::string section, line;
    std::istringstream lines(page);
    while (std::getline(lines, line)) {
        if (line.starts_with("## ")) section = line.substr(3);
        if (!line.starts_with("| ") || line.starts_with("| message |")) continue;
        std::string_view cell(line);
        cell = cell.substr(2, cell.find(" | ") - 2);
        for (std::size_t end = 0; end != std::string_view::npos;) {
            end = cell.find(kSeparator);
            const std::string text(cell.substr(0, end));
            messages.push_back({text, section, literal_parts(text)});
            if (end != std::string_view::npos) cell.remove_prefix(end + kSeparator.size());
        }
    }
    return messages;
}

bool matches(const DocumentedMessage& documented, std::string_view message) {
    for (const std::string& part : documented.literal) {
        const std::size_t at = message.find(part);
        if (at == std::string_view::npos) return false;
        message.remove_prefix(at + part.size());
    }
    return true;
}

std::vector<SourceLiteral> source_literals(const std::string& folder) {
    std::vector<SourceLiteral> all;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
        const std::string extension = entry.path().extension().string();
        if (extension != ".cpp" && extension != ".h") continue;
        LiteralScan scan;
        std::ifstream file(entry.path());
        for (std::string line; std::getline(file, line);) scan.line(line);
        for (const std::string& text : scan.literals) {
            all.push_back({entry.path().string(), text, parts_between_fields(text)});
        }
    }
    return all;
}

std::string_view trimmed(std::string_view text) {
    const std::size_t begin = text.find_first_not_of(" :\n");
    if (begin == std::string_view::npos) return {};
    return text.substr(begin, text.find_last_not_of(" :\n") + 1 - begin);
}

std::string_view longest(const std::vector<std::string>& parts) {
    std::string_view found;
    for (const std::string& part : parts) {
        if (trimmed(part).size() > found.size()) found = trimmed(part);
    }
    return found;
}

}  // namespace mscomp
