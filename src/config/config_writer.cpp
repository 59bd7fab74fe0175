// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>
#include <string>

#include "config_table.h"
#include "mscomp/base/json_text.h"
#include "mscomp/config/config_file.h"

namespace mscomp {
namespace {

constexpr std::size_t kCommentColumn = 38;

// Shortest text that reads back exactly; with a point before an exponent, as YAML 1.1 readers want.
std::string number_text(double value) {
    std::string text = fmt::format("{}", value);
    const std::size_t exponent = text.find('e');
    if (exponent != std::string::npos && text.find('.') == std::string::npos) {
        text.insert(exponent, ".0");
    }
    return text;
}

bool is_plain_path(const std::string& text) {
    const auto is_harmless = [](unsigned char c) {
        return std::isalnum(c) != 0 || c == '.' || c == '/' || c == '_' || c == '-';
    };
    return !text.empty() && text.find_first_of("./") != std::string::npos &&
           (std::isalpha(static_cast<unsigned char>(text[0])) != 0 || text[0] == '/') &&
           std::all_of(text.begin(), text.end(), is_harmless);
}

// A JSON string is a YAML one.
std::string quoted(const std::string& text) { return json_text(nlohmann::json(text)); }

struct ValueText {
    std::string operator()(const bool* field) const { return *field ? "true" : "false"; }
    std::string operator()(const int* field) const { return fmt::format("{}", *field); }
    std::string operator()(const std::uint64_t* field) const { return fmt::format("{}", *field); }
    std::string operator()(const double* field) const { return number_text(*field); }
    std::string operator()(const std::string* field) const {
        return is_plain_path(*field) ? *field : quoted(*field);
    }
    std::string operator()(const Choice& field) const { return field.names[field.get()]; }
    std::string operator()(const std::optional<double>* field) const {
        return field->has_value() ? number_text(**field) : "null";
    }
    std::string operator()(const IntervalField& field) const {
        const IntervalField::Interval interval = field.get();
        if (!interval) return "null";
        return fmt::format("[{}, {}]", number_text(interval->first), number_text(interval->second));
    }
    std::string operator()(const List&) const { return {}; }
    std::string operator()(const Table&) const { return {}; }
};

class ConfigWriter {
  public:
    explicit ConfigWriter(bool with_comments) : with_comments_(with_comments) {}

    void write(const Table& table, const std::string& indent) {
        for (const Key& key : table) write(key, indent);
    }
    void remark(const std::string& indent, const std::string& comment) {
        if (with_comments_) text_ += indent + "# " + comment + "\n";
    }
    const std::string& text() const { return text_; }

  private:
    void write(const Key& key, const std::string& indent) {
        if (const auto* section = std::get_if<Table>(&key.field)) {
            if (with_comments_ && indent.empty()) text_ += "\n";
            remark(indent, key.comment);
            line(indent + key.name + ":", "");
            write(*section, indent + "  ");
        } else if (const auto* list = std::get_if<List>(&key.field)) {
            line(indent + key.name + ":", key.comment);
            const bool with_comments = with_comments_;
            for (std::size_t i = 0; i < list->size(); ++i) {
                write_entry(list->entry(i), indent + "  ");
                with_comments_ = false;  // the first entry has said it
            }
            with_comments_ = with_comments;
        } else {
            line(fmt::format("{}{}: {}", indent, key.name, std::visit(ValueText{}, key.field)),
                 fmt::format("{} ({})", key.comment, wanted(key)));
        }
    }

    void line(std::string text, const std::string& comment) {
        if (with_comments_ && !comment.empty()) {
            text.resize(std::max(kCommentColumn, text.size() + 2), ' ');
            text += "# " + comment;
        }
        text_ += text + "\n";
    }

    // A list entry: its first line carries the dash.
    void write_entry(const Table& table, const std::string& indent) {
        const std::size_t begin = text_.size();
        write(table, indent + "  ");
        text_[begin + indent.size()] = '-';
    }

    bool with_comments_;
    std::string text_;
};

}  // namespace

std::string write_config(const Config& config, bool with_comments) {
    Config copy = config;  // the table is bound to fields that can be set
    ConfigWriter writer(with_comments);
    writer.remark("",
                  "Configuration of mscomp train. Everything but data.features may be left out;");
    writer.remark("", "the defaults are what `mscomp init " + config.kind + "` prints.");
    writer.write(config_table(copy), "");
    return writer.text();
}

}  // namespace mscomp
