// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "base/temporary_folder.h"
#include "mscomp/base/atomic_file.h"

namespace mscomp {

struct Outcome {
    int code = -1;
    std::string out, err;
};

inline Outcome shell(const std::string& folder, const std::string& command) {
    const std::string line =
        "cd '" + folder + "' && ( " + command + " ) >'" + folder + ".out' 2>'" + folder + ".err'";
    const int status = std::system(line.c_str());
    EXPECT_TRUE(WIFEXITED(status)) << line;
    return {WEXITSTATUS(status), read_file(folder + ".out"), read_file(folder + ".err")};
}

/// A feature file of eight small arms, made once.
inline const std::string& arm_features() {
    static const TemporaryFolder folder;
    static const std::string file = [] {
        const std::string where = folder / "arm";
        std::filesystem::create_directories(where);
        const std::string bin = std::string(MSCOMP_BIN_DIR) + "/acapfeat ";
        const Outcome made = shell(where, bin + "generate arm -o m --frames 8 --vertices 300 && " +
                                              bin + "extract m -o f.safetensors --quiet");
        EXPECT_EQ(made.code, 0) << made.err;
        return where + "/f.safetensors";
    }();
    return file;
}

using Row = std::map<std::string, std::string>;

/// Cells by the names of their columns; none of ours has a comma in it.
inline std::vector<Row> rows_of(const std::string& csv) {
    const auto cells = [](const std::string& line) {
        std::vector<std::string> all(1);
        for (const char c : line) {
            if (c == ',') {
                all.emplace_back();
            } else {
                all.back() += c;
            }
        }
        return all;
    };
    std::istringstream lines(csv);
    std::string line;
    std::getline(lines, line);
    const std::vector<std::string> names = cells(line);
    std::vector<Row> rows;
    while (std::getline(lines, line)) {
        const std::vector<std::string> values = cells(line);
        EXPECT_EQ(values.size(), names.size()) << line;
        Row& row = rows.emplace_back();
        for (std::size_t i = 0; i < values.size(); ++i) row[names[i]] = values[i];
    }
    return rows;
}

/// Rows without what depends on the machine.
inline std::vector<Row> results(const std::string& csv) {
    std::vector<Row> rows = rows_of(csv);
    for (Row& row : rows) EXPECT_EQ(row.erase("training_seconds"), 1u);
    return rows;
}

inline std::vector<std::string> column(const std::vector<Row>& rows, const std::string& name) {
    std::vector<std::string> values;
    for (const Row& row : rows) values.push_back(row.at(name));
    return values;
}

inline std::size_t count(const std::string& text, const std::string& part) {
    std::size_t found = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
        ++found;
    }
    return found;
}

class SweepFixture : public testing::Test {
  protected:
    SweepFixture() {
        std::filesystem::create_directories(folder_);
        std::filesystem::create_symlink(arm_features(), path("arm.safetensors"));
        write_file(path("grid.yaml"), kBase + kGrid);
    }

    std::string path(const std::string& name) const { return folder_ + "/" + name; }
    std::string file(const std::string& name) const { return read_file(path(name)); }
    Outcome mscomp(const std::string& arguments) const {
        return shell(folder_, std::string(MSCOMP_BIN_DIR) + "/mscomp " + arguments);
    }
    void expect_ok(const std::string& arguments) const {
        const Outcome outcome = mscomp(arguments);
        EXPECT_EQ(outcome.code, 0) << arguments << "\n" << outcome.err;
    }
    auto time_of(const std::string& name) const {
        return std::filesystem::last_write_time(path(name));
    }

    static inline const std::string kBase =
        "base:\n"
        "  model: {kind: stacked-attention, levels: [{components: 2, sparsity_range: 0.3}]}\n"
        "  data: {features: arm.safetensors, split: {train: every, step: 2}}\n"
        "  train: {epochs: 3, batch: 3}\n";
    static inline const std::string kGrid =
        "points:\n"
        "  grid:\n"
        "    model.levels[0].components: [2, 4]\n"
        "    loss.sparsity: [10, 1000]\n"
        "measure: {fit: features}\n"
        "plot: {x: loss.sparsity, group: \"model.levels[0].components\", log_x: true}\n";
    TemporaryFolder temporary_;
    std::string folder_ = temporary_ / "work";
};

}  // namespace mscomp
