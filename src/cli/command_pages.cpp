// SPDX-License-Identifier: MIT
#include "command_pages.h"

#include <CLI/CLI.hpp>
#include <filesystem>

#include "command_text.h"
#include "completion.h"
#include "man_page.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"

namespace mscomp {
namespace {

namespace fs = std::filesystem;

void write_page(const fs::path& path, const std::string& text) {
    std::error_code error;
    fs::create_directories(path.parent_path(), error);
    if (error) throw IoError(path.parent_path().string(), error.message());
    write_file(path.string(), text);
}

}  // namespace

void write_command_pages(const CLI::App& program, const std::string& folder) {
    const CommandText text = command_text(program);
    const fs::path root = folder;
    for (const ManPage& page : man_pages(text, program.version())) {
        write_page(root / "man/man1" / (page.name + ".1"), page.roff);
    }
    write_page(root / "bash" / text.name, bash_completion(text));
    write_page(root / "zsh" / ("_" + text.name), zsh_completion(text));
    write_page(root / "fish" / (text.name + ".fish"), fish_completion(text));
}

void add_command_pages(CLI::App& program) {
    program
        .add_option_function<std::string>(
            "--command-pages",
            [&program](const std::string& folder) {
                write_command_pages(program, folder);
                throw CLI::Success();
            },
            "Write manual pages and completions into this folder")
        ->group("");
}

}  // namespace mscomp
