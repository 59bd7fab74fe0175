// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace mscomp {

/// An option or an argument of a command, as its help has it.
struct OptionText {
    std::vector<std::string> names;    // "-o", "--output"; of an argument its name alone, "RUN"
    std::string value;                 // what it takes, "TEXT"; empty for flags
    std::vector<std::string> choices;  // the values it can have; empty: any
    std::string limits;                // of its numbers, "0 to 30"; empty: none
    std::string description;
    std::string default_value;           // empty: none
    std::vector<std::string> conflicts;  // options it does not go with
    bool is_argument = false;
    bool is_required = false;
    bool is_repeated = false;
    bool is_file = false;  // any text, so perhaps a path
};

/// A program or one of its commands.
struct CommandText {
    std::string name;         // "extract"
    std::string description;  // one sentence without its full stop
    std::string example;      // a line that can be pasted
    std::vector<OptionText> options;
    std::vector<CommandText> commands;
};

/// What the help of `app` and of its commands says. Hidden options are left out.
CommandText command_text(const CLI::App& app);

}  // namespace mscomp
