// SPDX-License-Identifier: MIT
// What no source may do by itself, since one place does it soundly.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "mscomp/base/atomic_file.h"

namespace mscomp {
namespace {

namespace fs = std::filesystem;

const fs::path kSources = fs::path(MSCOMP_TESTS_DIR).parent_path();

struct Source {
    std::string path;  // "src/base/error.cpp"
    std::string text;  // without comments
};

std::string without_comments(const std::string& text) {
    std::string result, line;
    for (std::istringstream lines(text); std::getline(lines, line);) {
        result += line.substr(0, line.find("//")) + "\n";
    }
    return result;
}

const std::vector<Source>& sources() {
    static const std::vector<Source> found = [] {
        std::vector<Source> all;
        for (const char* folder : {"src", "include"}) {
            for (const auto& entry : fs::recursive_directory_iterator(kSources / folder)) {
                const std::string extension = entry.path().extension().string();
                if (extension != ".cpp" && extension != ".h") continue;
                all.push_back({fs::relative(entry.path(), kSources).string(),
                               without_comments(read_file(entry.path().string()))});
            }
        }
        return all;
    }();
    return found;
}

/// Statements in which `expression` is found, with what ends them, of files other than `allowed`.
std::vector<std::string> statements_with(const std::string& expression,
                                         const std::vector<std::string>& allowed) {
    std::vector<std::string> found;
    const std::regex searched(expression);
    for (const Source& source : sources()) {
        if (std::ranges::find(allowed, source.path) != allowed.end()) continue;
        for (std::size_t begin = 0; begin < source.text.size();) {
            const std::size_t end =
                std::min(source.text.find_first_of(";{}", begin), source.text.size());
            const std::string statement = source.text.substr(begin, end + 1 - begin);
            if (std::regex_search(statement, searched))
                found.push_back(source.path + ": " + statement);
            begin = end + 1;
        }
    }
    return found;
}

void expect_none(const std::vector<std::string>& found, const char* instead) {
    for (const std::string& statement : found) ADD_FAILURE() << statement << "\nwanted " << instead;
}

// The check itself sees what it is there for.
TEST(Sources, AreRead) {
    EXPECT_GT(sources().size(), 300U);
    EXPECT_FALSE(statements_with("::write\\(descriptor", {}).empty());
}

TEST(Sources, SpeakToTerminalsInOnePlaceOnly) {
    expect_none(statements_with("\\bstderr\\b|\\bstdout\\b|std::(cout|cerr|clog)\\b|fmt::print\\b|"
                                "\\bprintf\\(|\\bfprintf\\(|\\bputs\\(|\\bputchar\\(|\\bperror\\(|"
                                "STD(OUT|ERR)_FILENO",
                                {"src/cli/say.cpp", "src/cli/progress.h", "src/cli/process.cpp",
                                 "src/cli/program.cpp", "src/cli/signals.cpp"}),
                "say or print_out of cli/say.h, or Progress");
    expect_none(statements_with("\\bstderr\\b|\\bstdout\\b|std::(cout|cerr|clog)\\b|fmt::print\\b",
                                {"src/cli/progress.h"}),
                "say or print_out of cli/say.h, or Progress");
}

// A call that throws std::filesystem_error says neither what was wanted nor which option was wrong.
TEST(Sources, AskTheFileSystemInAWayThatDoesNotThrow) {
    std::vector<std::string> found = statements_with(
        "(fs|filesystem)::(exists|is_\\w+|status|symlink_status|file_size|hard_link_count|remove|"
        "remove_all|rename|create_\\w+|absolute|canonical|weakly_canonical|relative|proximate|copy|"
        "copy_\\w+|current_path|last_write_time|equivalent|read_symlink|resize_file|space|"
        "temp_directory_path|permissions|(recursive_)?directory_iterator)\\b",
        {});
    static const std::regex kSound("\\b(error|ignored|unknown)\\b|status_of\\(|status\\)");
    std::erase_if(found, [](const std::string& text) { return std::regex_search(text, kSound); });
    expect_none(found, "a std::error_code, or base/paths.h");
    // Entries and iterators of folders throw likewise.
    expect_none(
        statements_with("\\.(exists|is_\\w+_file|is_directory|is_symlink|is_other|file_size|"
                        "status|symlink_status|last_write_time|refresh|increment)\\(\\)",
                        {}),
        "a std::error_code, or base/paths.h");
}

// What of std::filesystem iterates ends the program where memory runs out.
TEST(Sources, ListFoldersInOnePlaceOnly) {
    expect_none(statements_with("directory_iterator\\b|(fs|filesystem)::is_empty\\(", {}),
                "names_in of base/folder_entries.h");
}

TEST(Sources, WriteAndReadJsonInOnePlaceOnly) {
    expect_none(statements_with("\\.dump\\(", {"include/mscomp/base/json_text.h",
                                               "src/base/safetensors_header.cpp"}),
                "json_text of base/json_text.h");
    expect_none(statements_with("(<<|>>) ?\\w*[jJ]son\\b", {}),
                "json_text or parsed_json of base/json_text.h");
    expect_none(statements_with("[jJ]son::(parse|sax_parse|accept)\\(",
                                {"include/mscomp/base/json_text.h", "src/base/json_text.cpp",
                                 "src/base/safetensors_header.cpp", "src/sweep/sweep_run.cpp"}),
                "parsed_json or sound_json of base/json_text.h");
    expect_none(statements_with("YAML::Load\\w*\\(", {"src/config/config_reader.cpp"}),
                "load_document of config/config_reader.h");
}

// A JSON value of nothing takes the kind of what is put into it before it has memory for that:
// where there is none left, it ends the program as it goes.
TEST(Sources, BeginEveryJsonValueAsWhatItIs) {
    std::vector<std::string> found =
        statements_with("^\\s*(\\w+::)*(ordered_json|json|Json) \\w+(, \\w+)*;$", {});
    std::erase_if(found, [](const std::string& text) { return text.find(".h: ") != text.npos; });
    expect_none(found, "a value: json::object(), json::array(), or nullptr for none");
    expect_none(statements_with(
                    "\\w\\[\"\\w+\"\\]\\s*(\\[[^=]*\\]\\s*=[^=]|\\.(push|emplace)_back\\()", {}),
                "an array or object that is filled first");
}

TEST(Sources, ReadNumbersInAWayThatDoesNotThrow) {
    expect_none(
        statements_with("\\bsto(i|l|ll|ul|ull|f|d|ld)\\(|\\bato(i|l|ll|f)\\(|"
                        "\\bstrto(l|ll|ul|ull|f|d|ld)\\(|\\bsscanf\\(",
                        {"src/acap/mesh/number_text.cpp", "src/cli/acapfeat/convert_formats.cpp"}),
        "parsed_number of base/parsed_number.h");
}

}  // namespace
}  // namespace mscomp
