// SPDX-License-Identifier: MIT
#include "man_page.h"

#include <fmt/format.h>

#include <array>
#include <cctype>
#include <string_view>

#include "mscomp/base/error.h"

namespace mscomp {
namespace {

struct ExitStatus {
    ExitCode code;
    const char* meaning;
};

/// The table of docs/cli.md.
constexpr std::array kExitStatuses{
    ExitStatus{ExitCode::ok, "Done."},
    ExitStatus{ExitCode::bug, "A bug."},
    ExitStatus{ExitCode::usage, "A wrong command line or configuration."},
    ExitStatus{ExitCode::invalid_input, "A wrong input file; the message names file and line."},
    ExitStatus{ExitCode::io, "The system refused to read or write, or memory ran out."},
    ExitStatus{ExitCode::numerical, "A value became infinite or undefined, or a solve failed."},
    ExitStatus{ExitCode::checkpoint, "An unusable checkpoint."},
    ExitStatus{ExitCode::interrupted, "Stopped by Ctrl-C."},
    ExitStatus{ExitCode::terminated, "Stopped by SIGTERM."}};

/// `text` for roff to print as it is: characters that it or a terminal would take for others are
/// named, and no line begins with a control character.
std::string literal(std::string_view text) {
    std::string result;
    for (const char c : text) {
        if (result.empty() && (c == '.' || c == '\'')) result = "\\&";
        switch (c) {
            case '\\':
                result += "\\(rs";
                break;
            case '-':
                result += "\\-";
                break;
            case '\'':
                result += "\\(aq";
                break;
            case '"':
                result += "\\(dq";
                break;
            case '`':
                result += "\\(ga";
                break;
            case '^':
                result += "\\(ha";
                break;
            case '~':
                result += "\\(ti";
                break;
            case '\n':
                result += "\n.br\n";
                break;
            default:
                result += c;
        }
    }
    return result;
}

std::string bold(std::string_view text) { return "\\fB" + literal(text) + "\\fR"; }
std::string italic(std::string_view text) { return "\\fI" + literal(text) + "\\fR"; }

std::string upper(std::string text) {
    for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    return text;
}

std::string lower_first(std::string text) {
    // "ACAP features" keeps its capitals.
    if (text.size() > 1 && std::islower(static_cast<unsigned char>(text[1])) != 0) {
        text[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(text[0])));
    }
    return text;
}

std::string sentence(const std::string& text) {
    const bool is_whole = text.empty() || text.ends_with('.');
    return literal(is_whole ? text : text + ".");
}

std::string joined(const std::vector<std::string>& words, std::string (*style)(std::string_view)) {
    std::string result;
    for (const std::string& word : words) result += (result.empty() ? "" : ", ") + style(word);
    return result;
}

std::string head(const OptionText& option) {
    const std::string dots = option.is_repeated ? "..." : "";
    if (option.is_argument) return italic(option.names.front()) + dots;
    const std::string value = option.value.empty() ? "" : " " + italic(option.value) + dots;
    return joined(option.names, bold) + value;
}

std::string entry(const OptionText& option) {
    std::string text = ".TP\n" + head(option) + "\n" + sentence(option.description) + "\n";
    if (!option.choices.empty()) text += "One of " + joined(option.choices, bold) + ".\n";
    if (!option.limits.empty()) text += "Range: " + literal(option.limits) + ".\n";
    if (!option.conflicts.empty()) text += "Not with " + joined(option.conflicts, bold) + ".\n";
    if (option.is_required && !option.is_argument) text += "Required.\n";
    if (!option.default_value.empty()) text += "Default: " + literal(option.default_value) + ".\n";
    return text;
}

/// The arguments of a command, or the options, under a heading; nothing if there are none.
std::string entries(const CommandText& command, bool arguments, const char* heading) {
    std::string text;
    for (const OptionText& option : command.options) {
        if (option.is_argument == arguments) text += entry(option);
    }
    return text.empty() ? "" : fmt::format(".SH {}\n{}", heading, text);
}

std::string synopsis(const CommandText& command) {
    std::string text;
    for (const OptionText& option : command.options) {
        if (option.is_argument) {
            text += option.is_required ? " " + head(option) : " [" + head(option) + "]";
        } else if (option.is_required) {
            text += " " + bold(option.names.front()) + " " + italic(option.value);
        }
    }
    if (!command.commands.empty()) text += " " + italic("COMMAND");
    return text + " [" + italic("OPTION") + "]...";
}

std::string exit_statuses() {
    std::string text = ".SH EXIT STATUS\n";
    for (const ExitStatus& status : kExitStatuses) {
        text += fmt::format(".TP\n\\fB{}\\fR\n{}\n", static_cast<int>(status.code),
                            literal(status.meaning));
    }
    return text;
}

std::string page_name(const CommandText& program, const CommandText& command) {
    return &program == &command ? program.name : program.name + "-" + command.name;
}

std::string list_of_commands(const CommandText& program) {
    std::string text = ".SH COMMANDS\n";
    for (const CommandText& command : program.commands) {
        text += ".TP\n" + bold(command.name) + "\n" + sentence(command.description) + " See " +
                bold(page_name(program, command)) + "(1).\n";
    }
    return text;
}

std::string see_also(const CommandText& program, const CommandText& command) {
    std::string text;
    const auto add = [&](const CommandText& other) {
        if (&other == &command) return;
        text += (text.empty() ? "" : ",\n") + bold(page_name(program, other)) + "(1)";
    };
    add(program);
    for (const CommandText& other : program.commands) add(other);
    return ".SH SEE ALSO\n" + text + "\n";
}

ManPage man_page(const CommandText& program, const CommandText& command,
                 const std::string& version) {
    const bool is_program = &program == &command;
    const std::string name = page_name(program, command);
    const std::string called = is_program ? program.name : program.name + " " + command.name;
    std::string roff = ".\\\" Made by " + program.name + " from its commands.\n";
    roff +=
        fmt::format(".TH \"{}\" \"1\" \"\" \"{}\" \"\"\n", literal(upper(name)), literal(version));
    roff += fmt::format(".SH NAME\n{} \\- {}\n", literal(name),
                        literal(lower_first(command.description)));
    roff += ".SH SYNOPSIS\n" + bold(called) + synopsis(command) + "\n";
    roff += ".SH DESCRIPTION\n" + sentence(command.description) + "\n";
    if (is_program) roff += list_of_commands(program);
    roff += entries(command, true, "ARGUMENTS");
    roff += entries(command, false, "OPTIONS");
    roff += exit_statuses();
    if (!command.example.empty()) {
        roff += ".SH EXAMPLE\n.nf\n" + literal(command.example) + "\n.fi\n";
    }
    return {name, roff + see_also(program, command)};
}

}  // namespace

std::vector<ManPage> man_pages(const CommandText& program, const std::string& version) {
    std::vector<ManPage> pages{man_page(program, program, version)};
    for (const CommandText& command : program.commands) {
        pages.push_back(man_page(program, command, version));
    }
    return pages;
}

}  // namespace mscomp
