// SPDX-License-Identifier: MIT
// Manual pages and completions against what the programs' own help says.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "base/temporary_folder.h"
#include "install/shell.h"
#include "mscomp/base/atomic_file.h"

namespace mscomp {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsSupersetOf;

using Words = std::set<std::string>;

/// A command as its help has it.
struct Help {
    Words options;                         // with their dashes
    std::map<std::string, Words> choices;  // of options and arguments that have them
    Words commands;
};

Help parse_help(const std::string& text) {
    static const std::regex kName(R"((^|,| )(--?[A-Za-z][\w-]*))");
    static const std::regex kChoices(R"(\{([^}]*)\})");
    Help help;
    std::string section, last;
    for (const std::string& line : lines_of(text)) {
        if (!line.empty() && line[0] != ' ') section = line;
        if (section == "Subcommands:" && std::regex_match(line, std::regex("  \\S.*"))) {
            help.commands.insert(line.substr(2, line.find(' ', 2) - 2));
        }
        const bool is_entry = (section == "Options:" || section == "Positionals:") &&
                              std::regex_match(line, std::regex("  \\S.*"));
        if (!is_entry) continue;
        // Names end where two blanks or the type begin; a long head has the description below.
        const std::string head = line.substr(2, line.find("  ", 2) - 2);
        const std::string names = head.substr(0, head.find(' '));
        if (section == "Options:") {
            for (std::sregex_iterator it(names.begin(), names.end(), kName), end; it != end; ++it) {
                help.options.insert((*it)[2]);
            }
        }
        std::smatch match;
        if (!std::regex_search(line, match, kChoices)) continue;
        const std::string list = match[1];
        static const std::regex kComma(",");
        help.choices[names.substr(names.find(',') + 1)] = {
            std::sregex_token_iterator(list.begin(), list.end(), kComma, -1),
            std::sregex_token_iterator()};
    }
    return help;
}

/// Pages of one program, made anew, beside the help of each of its commands.
class CommandPages : public testing::TestWithParam<std::string> {
  protected:
    CommandPages() {
        EXPECT_EQ(run(program() + " --command-pages pages").code, 0);
        program_help_ = help_of("");
        for (const std::string& command : program_help_.commands) {
            helps_[command] = help_of(command);
        }
    }

    ShellOutcome run(const std::string& command) const {
        return run_in(folder_.path(), "PATH='" MSCOMP_BIN_DIR "':$PATH\n" + command);
    }
    const std::string& program() const { return GetParam(); }
    Help help_of(const std::string& command) const {
        return parse_help(run(program() + " " + command + " --help").out);
    }

    /// What bash would offer for `words`, the last of which is being typed.
    Words bash(const std::vector<std::string>& words) const {
        std::string array;
        for (const std::string& word : words) array += " '" + word + "'";
        const ShellOutcome outcome =
            run("compopt() { :; }\nsource pages/bash/" + program() + "\nCOMP_WORDS=(" + array +
                ")\nCOMP_CWORD=" + std::to_string(words.size() - 1) + "\n_" + program() +
                "\n((${#COMPREPLY[@]} == 0)) || printf '%s\\n' \"${COMPREPLY[@]}\"");
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        EXPECT_EQ(outcome.err, "");
        const std::vector<std::string> lines = lines_of(outcome.out);
        return {lines.begin(), lines.end()};
    }

    TemporaryFolder folder_;
    Help program_help_;
    std::map<std::string, Help> helps_;
};

TEST_P(CommandPages, HelpIsReadRightly) {
    ASSERT_GE(helps_.size(), 6U);
    const Help& help = helps_.begin()->second;
    EXPECT_THAT(help.options, IsSupersetOf({"-h", "--help"}));
}

TEST_P(CommandPages, EveryCommandHasAPageWithEveryOption) {
    Words names;
    for (const auto& entry : fs::directory_iterator(folder_ / "pages/man/man1")) {
        names.insert(entry.path().filename().string());
    }
    Words wanted{program() + ".1"};
    for (const auto& [command, help] : helps_) wanted.insert(program() + "-" + command + ".1");
    EXPECT_EQ(names, wanted);

    for (const auto& [command, help] : helps_) {
        std::string page =
            read_file(folder_ / ("pages/man/man1/" + program() + "-" + command + ".1"));
        page = std::regex_replace(page, std::regex("\\\\-"), "-");
        for (const std::string& option : help.options) {
            EXPECT_THAT(page, HasSubstr("\\fB" + option + "\\fR")) << command;
        }
        for (const char* section :
             {"NAME", "SYNOPSIS", "DESCRIPTION", "OPTIONS", "EXIT STATUS", "EXAMPLE", "SEE ALSO"}) {
            EXPECT_THAT(page, HasSubstr("\n.SH " + std::string(section) + "\n")) << command;
        }
    }
}

TEST_P(CommandPages, ManFormatsThemWithoutAWarning) {
    if (!is_installed("man")) GTEST_SKIP() << "no man";
    for (const auto& entry : fs::directory_iterator(folder_ / "pages/man/man1")) {
        const std::string page = "'" + entry.path().string() + "'";
        const ShellOutcome checked = run("man --warnings -E UTF-8 -l -Tutf8 -Z " + page);
        EXPECT_EQ(checked.code, 0) << page;
        EXPECT_EQ(checked.err, "") << page;
        if (is_installed("groff")) {
            EXPECT_EQ(run("groff -man -ww -Tutf8 " + page).err, "") << page;
        }
    }
}

TEST_P(CommandPages, ManShowsDefaultsChoicesAndExamplesAsTyped) {
    if (!is_installed("man")) GTEST_SKIP() << "no man";
    for (const auto& [command, help] : helps_) {
        const std::string shown = run("MANWIDTH=500 man -E ascii -l pages/man/man1/" + program() +
                                      "-" + command + ".1 | sed 's/.\\x08//g'")
                                      .out;
        const std::string text = run(program() + " " + command + " --help").out;
        const std::string mark = "Example:\n  ";
        ASSERT_THAT(text, HasSubstr(mark));
        const std::string example = lines_of(text.substr(text.find(mark) + mark.size())).front();
        EXPECT_THAT(shown, HasSubstr(example)) << command;
        for (const auto& [name, words] : help.choices) {
            for (const std::string& word : words) EXPECT_THAT(shown, HasSubstr(word)) << command;
        }
        if (!help.options.contains("--threads")) continue;
        EXPECT_THAT(shown, HasSubstr("Default: 0.")) << command;
    }
}

TEST_P(CommandPages, BashCompletesEveryCommandAndOption) {
    EXPECT_THAT(bash({program(), ""}), IsSupersetOf(program_help_.commands));
    EXPECT_EQ(bash({program(), "-"}), program_help_.options);
    for (const auto& [command, help] : helps_) {
        EXPECT_EQ(bash({program(), command, "-"}), help.options) << command;
        EXPECT_EQ(bash({program(), command, "--hel"}), Words{"--help"}) << command;
    }
}

TEST_P(CommandPages, BashCompletesTheValuesOfAnOption) {
    int checked = 0;
    for (const auto& [command, help] : helps_) {
        for (const auto& [name, words] : help.choices) {
            ++checked;
            if (!name.starts_with("-")) {
                EXPECT_EQ(bash({program(), command, ""}), words) << command << " " << name;
                continue;
            }
            const std::string first = *words.begin();
            EXPECT_EQ(bash({program(), command, name, ""}), words) << command << " " << name;
            EXPECT_EQ(bash({program(), command, name, "="}), words) << command << " " << name;
            EXPECT_THAT(bash({program(), command, name, "=", first}), testing::Contains(first));
            EXPECT_THAT(bash({program(), command, name, first}), testing::Contains(first));
        }
        // Everything else is left to bash, which completes files.
        if (!help.options.contains("--output")) continue;
        EXPECT_EQ(bash({program(), command, "--output", ""}), Words{}) << command;
    }
    EXPECT_GE(checked, 4);
    const std::string known =
        run("source pages/bash/" + program() + "; complete -p " + program()).out;
    EXPECT_EQ(known, "complete -o default -F _" + program() + " " + program() + "\n");
}

TEST_P(CommandPages, FishCompletesEveryCommandAndOption) {
    if (!is_installed("fish")) GTEST_SKIP() << "no fish";
    const auto fish = [&](const std::string& line) {
        const ShellOutcome outcome = run("HOME=$PWD fish --no-config -c \"source pages/fish/" +
                                         program() + ".fish; complete -C '" + line + "'\"");
        EXPECT_EQ(outcome.err, "");
        Words words;
        for (const std::string& each : lines_of(outcome.out)) {
            words.insert(each.substr(0, each.find('\t')));
        }
        return words;
    };
    EXPECT_THAT(fish(program() + " "), IsSupersetOf(program_help_.commands));
    for (const auto& [command, help] : helps_) {
        EXPECT_THAT(fish(program() + " " + command + " -"), IsSupersetOf(help.options)) << command;
        for (const auto& [name, words] : help.choices) {
            const std::string option = name.starts_with("-") ? name + " " : "";
            EXPECT_THAT(fish(program() + " " + command + " " + option), IsSupersetOf(words));
        }
    }
}

TEST_P(CommandPages, ZshKnowsEveryCommandAndOption) {
    if (!is_installed("zsh")) GTEST_SKIP() << "no zsh";
    // What completion calls is replaced by functions that print what they are given.
    const auto zsh = [&](const std::string& state, const std::string& command) {
        const ShellOutcome outcome =
            run("zsh -f -c \"_describe() { print -rl -- \\${(P)4} }; "
                "_arguments() { state=" +
                state + "; print -rl -- \\$@ }; words=(" + command + "); source pages/zsh/_" +
                program() + "\"");
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        EXPECT_EQ(outcome.err, "");
        return outcome.out;
    };
    const std::string commands = zsh("command", "");
    for (const std::string& command : program_help_.commands) {
        EXPECT_THAT(commands, HasSubstr("\n" + command + ":"));
    }
    for (const auto& [command, help] : helps_) {
        const std::string specs = zsh("words", command);
        for (const std::string& option : help.options) {
            EXPECT_TRUE(std::regex_search(
                specs, std::regex("\n(\\([^)]*\\)|\\*)" + option + "\\[[^\n]*\\]")))
                << command << " " << option << "\n"
                << specs;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Of, CommandPages, testing::Values("acapfeat", "mscomp"),
                         [](const auto& each) { return each.param; });

}  // namespace
}  // namespace mscomp
