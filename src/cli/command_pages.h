// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace mscomp {

/// Writes the manual pages of `program` and its commands and what makes shells complete them:
/// man/man1/NAME.1 and NAME-COMMAND.1, bash/NAME, zsh/_NAME and fish/NAME.fish under `folder`.
/// Throws IoError.
void write_command_pages(const CLI::App& program, const std::string& folder);

/// Gives `program` the hidden option --command-pages FOLDER, which writes them and ends: for the
/// build and for packagers.
void add_command_pages(CLI::App& program);

}  // namespace mscomp
