// SPDX-License-Identifier: MIT
#include "mscomp/run/split.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <sstream>
#include <string_view>

#include "mscomp/base/error.h"
#include "mscomp/base/file_kind.h"
#include "mscomp/base/index.h"
#include "mscomp/base/path_from.h"
#include "mscomp/base/random.h"

namespace mscomp {
namespace {

std::string_view trimmed(std::string_view text) {
    const char* const blanks = " \t\r";
    const std::size_t first = text.find_first_not_of(blanks);
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

std::vector<int> read_indices(const std::string& path, int shape_count) {
    std::vector<int> indices;
    std::vector<std::int64_t> line_of(at(shape_count), 0);
    std::istringstream lines(read_text_file(path, "a list of shape indices"));
    std::string line;
    for (std::int64_t number = 1; std::getline(lines, line); ++number) {
        const std::string_view text = trimmed(line);
        if (text.empty()) continue;
        int index = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), index);
        if (error != std::errc{} || end != text.data() + text.size() || index < 0 ||
            index >= shape_count) {
            throw InputError({path, number},
                             fmt::format("got \"{}\", wanted one shape index from 0 to {}", text,
                                         shape_count - 1));
        }
        std::int64_t& first_line = line_of[at(index)];
        if (first_line > 0) {
            throw InputError({path, number},
                             fmt::format("shape {} stands in line {} already", index, first_line));
        }
        first_line = number;
        indices.push_back(index);
    }
    if (indices.empty()) throw InputError({path}, "no shape index in it; wanted at least one");
    return indices;
}

std::vector<int> training_shapes(const SplitConfig& config, int shape_count,
                                 const std::string& config_folder) {
    std::vector<int> train;
    switch (config.train) {
        case SplitKind::all:
        case SplitKind::every: {
            const int step = config.train == SplitKind::all ? 1 : config.step;
            for (int i = 0; i < shape_count; ++i) {
                if (i % step == 0) train.push_back(i);
            }
            break;
        }
        case SplitKind::random:
            if (config.count > shape_count) {
                throw UsageError(fmt::format("data.split.count: got {}, but there are {} shapes",
                                             config.count, shape_count));
            }
            train = CounterRandom(config.seed, 0).permutation(shape_count);
            train.resize(at(config.count));
            break;
        case SplitKind::file:
            train = read_indices(path_from(config_folder, config.path), shape_count);
            break;
    }
    std::sort(train.begin(), train.end());
    return train;
}

}  // namespace

Split resolve_split(const SplitConfig& config, int shape_count, const std::string& config_folder) {
    Split split;
    split.train = training_shapes(config, shape_count, config_folder);
    auto next = split.train.begin();
    for (int i = 0; i < shape_count; ++i) {
        if (next != split.train.end() && *next == i) {
            ++next;
        } else {
            split.test.push_back(i);
        }
    }
    return split;
}

}  // namespace mscomp
