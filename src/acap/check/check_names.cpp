// SPDX-License-Identifier: MIT
// Numbers in file names: what is missing, what is there twice, what programs may order otherwise.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <map>
#include <optional>

#include "check_findings.h"
#include "mscomp/acap/mesh/natural_order.h"

namespace mscomp {
namespace {

struct NumberedFile {
    std::int64_t number = 0;
    std::string digits;
    const CheckedFile* file = nullptr;
};

/// Files whose names differ in their last run of digits only.
struct Series {
    std::string prefix, suffix;  // around the digits, without folder and extension
    std::vector<NumberedFile> files;
};

std::optional<std::pair<Series, NumberedFile>> split_name(const CheckedFile& named) {
    const std::string stem = std::filesystem::path(named.path).stem().string();
    constexpr const char* kDigits = "0123456789";
    const std::size_t last = stem.find_last_of(kDigits);
    if (last == std::string::npos) return std::nullopt;
    const std::size_t before = stem.find_last_not_of(kDigits, last);
    const std::size_t first = before == std::string::npos ? 0 : before + 1;
    NumberedFile file{0, stem.substr(first, last + 1 - first), &named};
    const char* end = file.digits.data() + file.digits.size();
    if (std::from_chars(file.digits.data(), end, file.number).ec != std::errc{}) {
        return std::nullopt;
    }
    return std::pair{Series{stem.substr(0, first), stem.substr(last + 1), {}}, std::move(file)};
}

std::vector<Series> series_of(const std::vector<CheckedFile>& files) {
    std::map<std::array<std::string, 3>, Series> found;
    for (const CheckedFile& named : files) {
        auto parts = split_name(named);
        if (!parts) continue;
        auto& [series, file] = *parts;
        const std::string folder = std::filesystem::path(named.path).parent_path().string();
        Series& target =
            found.try_emplace({folder, series.prefix, series.suffix}, series).first->second;
        target.files.push_back(std::move(file));
    }
    std::vector<Series> result;
    for (auto& [key, series] : found) {
        std::stable_sort(
            series.files.begin(), series.files.end(),
            [](const NumberedFile& a, const NumberedFile& b) { return a.number < b.number; });
        result.push_back(std::move(series));
    }
    return result;
}

/// The most frequent difference of successive numbers, the smallest of those; none unless at least
/// half of the differences are equal to it.
std::optional<std::int64_t> step_of(const Series& series) {
    std::map<std::int64_t, int> frequency;
    int differences = 0;
    for (std::size_t k = 1; k < series.files.size(); ++k) {
        const std::int64_t step = series.files[k].number - series.files[k - 1].number;
        if (step == 0) continue;
        ++frequency[step];
        ++differences;
    }
    const auto most =
        std::max_element(frequency.begin(), frequency.end(),
                         [](const auto& a, const auto& b) { return a.second < b.second; });
    if (differences < 2 || 2 * most->second < differences) return std::nullopt;
    return most->first;
}

void find_gaps(const Series& series, FindingBuilder& gaps) {
    const std::optional<std::int64_t> step = step_of(series);
    if (!step) return;
    for (std::size_t k = 1; k < series.files.size(); ++k) {
        const NumberedFile& before = series.files[k - 1];
        const NumberedFile& after = series.files[k];
        const std::int64_t missing = (after.number - before.number - 1) / *step;
        if (after.number - before.number <= *step || missing == 0) continue;
        const std::int64_t first = before.number + *step;
        std::string name =
            fmt::format("{}{:0{}}{}", series.prefix, first, before.digits.size(), series.suffix);
        if (missing > 1) name += fmt::format(" and {} more", missing - 1);
        CheckPlace place{.text = fmt::format("{} between {} and {}", name, before.file->label,
                                             after.file->label),
                         .file = before.file->path,
                         .other_file = after.file->path};
        place.count = missing;
        gaps.add(std::move(place), missing);
    }
}

void find_equal_numbers(const Series& series, FindingBuilder& equal) {
    for (std::size_t k = 1; k < series.files.size(); ++k) {
        const NumberedFile& before = series.files[k - 1];
        const NumberedFile& after = series.files[k];
        if (before.number != after.number) continue;
        equal.add({.text = fmt::format("{} and {}", before.file->label, after.file->label),
                   .file = before.file->path,
                   .other_file = after.file->path});
    }
}

/// Padded to different widths: a leading zero in one, and another that is shorter, or has a leading
/// zero and is longer.
void find_mixed_padding(const Series& series, FindingBuilder& mixed) {
    const auto is_padded = [](const NumberedFile& file) {
        return file.digits.size() > 1 && file.digits.front() == '0';
    };
    const auto padded = std::find_if(series.files.begin(), series.files.end(), is_padded);
    if (padded == series.files.end()) return;
    for (const NumberedFile& file : series.files) {
        const bool is_shorter = file.digits.size() < padded->digits.size();
        if (!is_shorter && !(is_padded(file) && file.digits.size() != padded->digits.size())) {
            continue;
        }
        mixed.add({.text = fmt::format("{} beside {}", file.file->label, padded->file->label),
                   .file = file.file->path,
                   .other_file = padded->file->path});
    }
}

/// The first place at which the order given is not the one `less` makes.
template <class Less>
void find_other_order(const std::vector<CheckedFile>& files, Less less, FindingBuilder& builder) {
    for (std::size_t k = 1; k < files.size(); ++k) {
        const CheckedFile& before = files[k - 1];
        const CheckedFile& after = files[k];
        if (!less(after.path, before.path)) continue;
        builder.add({.text = fmt::format("{} is used before {}", before.label, after.label),
                     .file = before.path,
                     .other_file = after.path});
    }
}

void find_order(const std::vector<CheckedFile>& files, std::vector<Finding>& findings) {
    FindingBuilder listed(Severity::note, "order_not_natural");
    std::vector<std::string> paths;
    for (const CheckedFile& file : files) paths.push_back(file.path);
    const NaturalOrder natural(paths);
    const auto natural_less = [&](const auto& a, const auto& b) { return natural.less(a, b); };
    find_other_order(files, natural_less, listed);
    if (listed.count() > 0) {
        listed.finish("the list does not go by the numbers in the names",
                      "Its order is kept. If the numbers count time, sort the list.", findings);
        return;
    }
    if (!natural.doubt().empty()) {
        FindingBuilder doubt(Severity::warning, "order_in_doubt");
        doubt.add({.text = natural.doubt(), .file = files.front().path});
        doubt.finish("the order of the shapes is in doubt",
                     "Name the files in their order with --list.", findings);
    }
    FindingBuilder plain(Severity::note, "order_not_plain");
    find_other_order(files, std::less<>(), plain);
    plain.finish("shapes are used in the order of their numbers, not of their letters",
                 "Mind this where another program (ls, a script) goes through the same files.",
                 findings);
}

}  // namespace

void find_numbering(const std::vector<CheckedFile>& files, std::vector<Finding>& findings) {
    FindingBuilder gaps(Severity::note, "missing_numbers");
    FindingBuilder equal(Severity::warning, "same_number_twice");
    FindingBuilder mixed(Severity::note, "mixed_padding");
    for (const Series& series : series_of(files)) {
        find_gaps(series, gaps);
        find_equal_numbers(series, equal);
        find_mixed_padding(series, mixed);
    }
    equal.finish(
        counted(equal.count(), "number occurs", "numbers occur") + " twice in the file names",
        "Both files are used as shapes. Remove the one that is a leftover.", findings);
    gaps.finish(counted(gaps.count(), "number is", "numbers are") + " missing in the file names",
                "If shapes were lost in copying, bring them back; if they were left out on "
                "purpose, nothing is to be done.",
                findings);
    mixed.finish(counted(mixed.count(), "number is", "numbers are") +
                     " padded with zeros to another width than the others",
                 "The order goes by the numbers, so nothing is to be done here.", findings);
    find_order(files, findings);
}

}  // namespace mscomp
