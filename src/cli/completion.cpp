// SPDX-License-Identifier: MIT
#include "completion.h"

#include <fmt/format.h>

#include <string_view>
#include <vector>

namespace mscomp {
namespace {

std::string joined(const std::vector<std::string>& words) {
    return fmt::format("{}", fmt::join(words, " "));
}

/// `text` with a backslash before each of `special`.
std::string escaped(std::string_view text, std::string_view special) {
    std::string result;
    for (const char c : text) {
        if (special.find(c) != std::string_view::npos) result += '\\';
        result += c;
    }
    return result;
}

/// A word of bash and zsh in single quotes, which take everything but themselves.
std::string single_quoted(std::string_view text) {
    std::string result = "'";
    for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return result + "'";
}

/// A word of fish in single quotes.
std::string fish_quoted(std::string_view text) { return "'" + escaped(text, "'\\") + "'"; }

bool takes_value(const OptionText& option) { return !option.value.empty(); }

std::vector<std::string> option_names(const CommandText& command) {
    std::vector<std::string> names;
    for (const OptionText& option : command.options) {
        if (option.is_argument) continue;
        names.insert(names.end(), option.names.begin(), option.names.end());
    }
    return names;
}

std::vector<std::string> argument_choices(const CommandText& command) {
    std::vector<std::string> choices;
    for (const OptionText& option : command.options) {
        if (option.is_argument) {
            choices.insert(choices.end(), option.choices.begin(), option.choices.end());
        }
    }
    return choices;
}

std::vector<std::string> command_names(const CommandText& program) {
    std::vector<std::string> names;
    for (const CommandText& command : program.commands) names.push_back(command.name);
    return names;
}

/// The branch of a case for an option that takes a value: "'extract -o' | 'extract --output')".
std::string bash_value(const CommandText& command, const OptionText& option) {
    std::string patterns;
    for (const std::string& name : option.names) {
        patterns += (patterns.empty() ? "" : " | ") + single_quoted(command.name + " " + name);
    }
    std::string body = "return";  // bash itself completes files
    if (!option.choices.empty()) {
        body = "words=" + single_quoted(joined(option.choices));
    } else if (!option.is_file) {
        body = "compopt +o default; return";
    }
    return fmt::format("        {}) {} ;;\n", patterns, body);
}

constexpr const char* kBash = R"(# Completes {0} in bash. Made by {0} from its commands.
_{0}() {{
    local current=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD - 1]}} words=
    COMPREPLY=()
    # --option=value comes as three words.
    if [[ $current == = ]]; then
        current=
    elif [[ $previous == = ]] && ((COMP_CWORD > 2)); then
        previous=${{COMP_WORDS[COMP_CWORD - 2]}}
    fi
    if ((COMP_CWORD == 1)); then
        mapfile -t COMPREPLY < <(compgen -W {1} -- "$current")
        return
    fi
    case "${{COMP_WORDS[1]}} $previous" in
{2}    esac
    if [[ ! $words ]]; then
        case "${{COMP_WORDS[1]}} $current" in
{3}        esac
    fi
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
}}
complete -o default -F _{0} {0}
)";

/// "name[description]:value:action" as _arguments takes it, without the names.
std::string zsh_spec(const OptionText& option) {
    std::string action = option.is_file ? "_files" : " ";
    if (!option.choices.empty()) action = "(" + joined(option.choices) + ")";
    const std::string value =
        takes_value(option) ? ":" + escaped(option.value, "[]:\\") + ":" + action : "";
    return "[" + escaped(option.description, "[]:\\") + "]" + value;
}

std::string zsh_option(const OptionText& option) {
    if (option.is_argument) {
        const std::string action =
            option.choices.empty() ? "_files" : "(" + joined(option.choices) + ")";
        return single_quoted((option.is_repeated ? "*:" : ":") + option.names.front() + ":" +
                             action);
    }
    // An option that has been given is not offered again, under none of its names.
    const std::string once =
        option.is_repeated ? single_quoted("*") : single_quoted("(" + joined(option.names) + ")");
    const std::string names = option.names.size() == 1
                                  ? option.names.front()
                                  : fmt::format("{{{}}}", fmt::join(option.names, ","));
    return once + names + single_quoted(zsh_spec(option));
}

std::string zsh_options(const CommandText& command, const std::string& indent) {
    std::string text;
    for (const OptionText& option : command.options) {
        text += fmt::format(" \\\n{}{}", indent, zsh_option(option));
    }
    return text;
}

constexpr const char* kZsh = R"(#compdef {0}
# Completes {0} in zsh. Made by {0} from its commands.
_{0}() {{
    local curcontext=$curcontext state line
    typeset -A opt_args
    local -a commands=({1}
    )
    _arguments -C{2} \
        '1: :->command' \
        '*:: :->words'
    case $state in
        command) _describe -t commands command commands ;;
        words)
            case $words[1] in
{3}            esac
            ;;
    esac
}}
_{0} "$@"
)";

/// One line of fish for an option: "complete -c mscomp -n ... -s o -l output -r -F -d '...'".
std::string fish_option(const std::string& condition, const OptionText& option) {
    std::string text = condition;
    if (option.is_argument) {
        if (option.choices.empty()) return option.is_file ? text + " -F\n" : "";
        return text + " -f -a " + fish_quoted(joined(option.choices)) + "\n";
    }
    for (const std::string& name : option.names) {
        text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
    }
    if (!option.choices.empty()) {
        text += " -x -a " + fish_quoted(joined(option.choices));
    } else if (takes_value(option)) {
        text += option.is_file ? " -r -F" : " -x";
    }
    return text + " -d " + fish_quoted(option.description) + "\n";
}

}  // namespace

std::string bash_completion(const CommandText& program) {
    std::vector<std::string> first = command_names(program);
    const std::vector<std::string> own = option_names(program);
    first.insert(first.end(), own.begin(), own.end());
    std::string values, words;
    for (const CommandText& command : program.commands) {
        for (const OptionText& option : command.options) {
            if (!option.is_argument && takes_value(option)) values += bash_value(command, option);
        }
        words += fmt::format("            {}\\ -*) words={} ;;\n", command.name,
                             single_quoted(joined(option_names(command))));
        const std::vector<std::string> choices = argument_choices(command);
        if (choices.empty()) continue;
        words += fmt::format("            {}\\ *) words={} ;;\n", command.name,
                             single_quoted(joined(choices)));
    }
    return fmt::format(kBash, program.name, single_quoted(joined(first)), values, words);
}

std::string zsh_completion(const CommandText& program) {
    std::string commands, branches;
    for (const CommandText& command : program.commands) {
        commands += "\n        " + single_quoted(escaped(command.name, ":") + ":" +
                                                 escaped(command.description, ":\\"));
        branches += fmt::format("                {}) _arguments{} ;;\n", command.name,
                                zsh_options(command, "                    "));
    }
    return fmt::format(kZsh, program.name, commands, zsh_options(program, "        "), branches);
}

std::string fish_completion(const CommandText& program) {
    const std::string complete = "complete -c " + program.name;
    std::string text =
        fmt::format("# Completes {0} in fish. Made by {0} from its commands.\n{1} -f\n",
                    program.name, complete);
    const std::string first = complete + " -n __fish_use_subcommand";
    for (const CommandText& command : program.commands) {
        text += fmt::format("{} -f -a {} -d {}\n", first, command.name,
                            fish_quoted(command.description));
    }
    for (const OptionText& option : program.options) text += fish_option(first, option);
    for (const CommandText& command : program.commands) {
        const std::string condition =
            fmt::format("{} -n '__fish_seen_subcommand_from {}'", complete, command.name);
        for (const OptionText& option : command.options) text += fish_option(condition, option);
    }
    return text;
}

}  // namespace mscomp
