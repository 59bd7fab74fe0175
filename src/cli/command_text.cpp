// SPDX-License-Identifier: MIT
#include "command_text.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string_view>

namespace mscomp {
namespace {

constexpr std::string_view kExample = "Example:\n";

/// What stands between `open` and `close`, or "".
std::string between(const std::string& text, std::string_view open, std::string_view close) {
    const std::size_t begin = text.find(open);
    if (begin == std::string::npos) return "";
    const std::size_t from = begin + open.size();
    const std::size_t end = text.find(close, from);
    return end == std::string::npos ? "" : text.substr(from, end - from);
}

std::vector<std::string> pieces(const std::string& text) {
    return text.empty() ? std::vector<std::string>{} : CLI::detail::split(text, ',');
}

std::string with_word(std::string range) {
    const std::size_t dash = range.find(" - ");
    return dash == std::string::npos ? range : range.replace(dash, 3, " to ");
}

/// "TEXT:{obj,ply}", "INT:INT in [0 - 30]" and "FLOAT:NONNEGATIVE" are how CLI11 names types.
void describe_value(OptionText& text, const std::string& type) {
    text.value = type.substr(0, type.find(':'));
    text.choices = pieces(between(type, "{", "}"));
    text.limits = with_word(between(type, " in [", "]"));
    if (type.find("NONNEGATIVE") != std::string::npos) text.limits = "0 or more";
    if (type.find("POSITIVE") != std::string::npos) text.limits = "more than 0";
    text.is_file = text.value == "TEXT" && text.choices.empty();
}

OptionText option_text(const CLI::Option& option) {
    OptionText text;
    text.is_argument = option.get_positional();
    if (text.is_argument) {
        text.names.push_back(option.get_name(true));
    } else {
        text.names = pieces(option.get_name(false, true));
    }
    if (option.get_items_expected_max() > 0) describe_value(text, option.get_type_name());
    text.description = option.get_description();
    text.default_value = option.get_default_str();
    for (const CLI::Option* other : option.get_excludes()) {
        text.conflicts.push_back(other->get_name());
    }
    std::ranges::sort(text.conflicts);
    text.is_required = option.get_required();
    text.is_repeated = option.get_items_expected_max() > 1;
    return text;
}

std::string example_of(const std::string& footer) {
    const std::size_t begin = footer.find(kExample);
    return begin == std::string::npos
               ? ""
               : CLI::detail::trim_copy(footer.substr(begin + kExample.size()));
}

}  // namespace

CommandText command_text(const CLI::App& app) {
    CommandText text;
    text.name = app.get_name();
    text.description = app.get_description();
    text.example = example_of(app.get_footer());
    for (const CLI::Option* option :
         app.get_options([](const CLI::Option* each) { return !each->get_group().empty(); })) {
        text.options.push_back(option_text(*option));
    }
    for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
        text.commands.push_back(command_text(*command));
    }
    return text;
}

}  // namespace mscomp
