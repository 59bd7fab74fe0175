// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <glob.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "mesh_format.h"
#include "mscomp/acap/mesh/mesh_sequence.h"
#include "mscomp/base/error.h"
#include "number_text.h"

namespace mscomp {
namespace {

namespace fs = std::filesystem;

/// The digits at `at` without leading zeros; `at` moves behind them.
std::string_view take_number(std::string_view text, std::size_t& at) {
    while (at < text.size() && text[at] == '0') ++at;
    const std::size_t begin = at;
    while (at < text.size() && is_digit(text[at])) ++at;
    return text.substr(begin, at - begin);
}

/// Less than, equal to or greater than 0 as strcmp; "07" and "7" are equal.
int natural_compare(std::string_view a, std::string_view b) {
    std::size_t i = 0, j = 0;
    while (i < a.size() && j < b.size()) {
        if (is_digit(a[i]) && is_digit(b[j])) {
            const std::string_view x = take_number(a, i), y = take_number(b, j);
            if (x.size() != y.size()) return x.size() < y.size() ? -1 : 1;
            if (const int order = x.compare(y); order != 0) return order;
        } else {
            const auto x = static_cast<unsigned char>(a[i++]),
                       y = static_cast<unsigned char>(b[j++]);
            if (x != y) return x < y ? -1 : 1;
        }
    }
    return static_cast<int>(i < a.size()) - static_cast<int>(j < b.size());
}

/// Pipes, sockets and devices in a folder are nobody's meshes. A link to nowhere is: a shape that
/// is missing must be noticed.
bool is_file_or_broken_link(const fs::directory_entry& entry) {
    std::error_code error;
    const fs::file_type type = entry.status(error).type();
    return type != fs::file_type::directory &&
           (type == fs::file_type::regular || !fs::exists(entry.path(), error));
}

std::vector<std::string> meshes_in_folder(const std::string& folder) {
    std::vector<std::string> files;
    std::error_code error;
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
         entry.increment(error)) {
        const std::string path = entry->path().string();
        if (mesh_format(path) && is_file_or_broken_link(*entry)) files.push_back(path);
    }
    if (error) throw IoError(folder, "cannot read the folder: " + error.message());
    if (files.empty()) {
        throw UsageError(fmt::format("folder '{}' holds no {} file", folder, kMeshExtensions));
    }
    return files;
}

std::vector<std::string> matches_of(const std::string& pattern) {
    struct Result {
        glob_t found{};
        ~Result() { globfree(&found); }
    } result;
    const int status = ::glob(pattern.c_str(), GLOB_NOSORT, nullptr, &result.found);
    if (status == GLOB_NOMATCH) throw UsageError(fmt::format("nothing matches '{}'", pattern));
    if (status != 0) throw IoError(pattern, "cannot search the folders of this pattern");
    return {result.found.gl_pathv, result.found.gl_pathv + result.found.gl_pathc};
}

bool is_glob(const std::string& input) { return input.find_first_of("*?[") != std::string::npos; }

void append_input(const std::string& input, bool may_be_glob, std::vector<std::string>& files) {
    std::error_code error;
    if (fs::is_directory(input, error)) {
        const std::vector<std::string> found = meshes_in_folder(input);
        files.insert(files.end(), found.begin(), found.end());
    } else if (fs::exists(input, error)) {
        files.push_back(input);
    } else if (may_be_glob && is_glob(input)) {
        for (const std::string& match : matches_of(input)) append_input(match, false, files);
    } else {
        throw UsageError(fmt::format("there is no file or folder '{}'", input));
    }
}

void refuse_repeated_files(const std::vector<std::string>& files) {
    std::map<std::string, std::string> first_name;
    for (const std::string& file : files) {
        std::error_code error;
        const fs::path real = fs::weakly_canonical(file, error);
        const auto [at, fresh] = first_name.try_emplace(error ? file : real.string(), file);
        if (!fresh) {
            throw UsageError(fmt::format("'{}' and '{}' are the same file, wanted every mesh once",
                                         at->second, file));
        }
    }
}

}  // namespace

bool natural_less(std::string_view a, std::string_view b) {
    const int order = natural_compare(a, b);
    return order != 0 ? order < 0 : a < b;
}

std::vector<std::string> expand_inputs(const std::vector<std::string>& inputs) {
    if (inputs.empty()) throw UsageError("no input given, wanted mesh files, folders or patterns");
    std::vector<std::string> files;
    for (const std::string& input : inputs) append_input(input, true, files);
    refuse_repeated_files(files);
    std::sort(files.begin(), files.end(), natural_less);
    return files;
}

}  // namespace mscomp
