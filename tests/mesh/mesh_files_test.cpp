// SPDX-License-Identifier: MIT
// The tiny files and folders of tests/mesh/files against their table, expected.txt.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "base/thrown_message.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/acap/mesh/mesh_sequence.h"
#include "mscomp/base/error.h"

namespace mscomp {
namespace {

const std::string kFolder = std::string(MSCOMP_TESTS_DIR) + "/mesh/files/";

struct ExpectedFile {
    std::string name;     // of a folder with a slash at its end
    std::string outcome;  // "is", "fails" or "order"
    std::string details;
};
void PrintTo(const ExpectedFile& file, std::ostream* out) { *out << file.name; }

/// Meshes that lines refer to by name.
using NamedMeshes = std::map<std::string, std::string>;

std::vector<ExpectedFile> read_table(NamedMeshes& meshes) {
    std::ifstream table(kFolder + "expected.txt");
    std::vector<ExpectedFile> files;
    for (std::string line; std::getline(table, line);) {
        if (line.empty() || line.front() == '#') continue;
        std::istringstream words(line);
        ExpectedFile file;
        words >> file.name >> file.outcome >> std::ws;
        std::getline(words, file.details);
        if (file.name.find_first_of("./") == std::string::npos && file.name != "mesh") {
            meshes[file.name] = file.details;
        } else {
            files.push_back(file);
        }
    }
    return files;
}

std::vector<ExpectedFile> expected_files() {
    NamedMeshes meshes;
    std::vector<ExpectedFile> files = read_table(meshes);
    for (ExpectedFile& file : files) {
        const auto named = meshes.find(file.details);
        if (named != meshes.end()) file.details = named->second;
    }
    return files;
}

/// "a b c, d e f" as rows of three.
template <class Number>
std::vector<std::array<Number, 3>> rows_of(std::string text) {
    std::replace(text.begin(), text.end(), ',', ' ');
    std::istringstream words(text);
    std::vector<std::array<Number, 3>> rows;
    for (std::string a, b, c; words >> a >> b >> c;) {
        rows.push_back({static_cast<Number>(std::stold(a)), static_cast<Number>(std::stold(b)),
                        static_cast<Number>(std::stold(c))});
    }
    return rows;
}

std::string without_folder(std::string message) {
    for (std::size_t at = 0; (at = message.find(kFolder)) != std::string::npos;) {
        message.erase(at, kFolder.size());
    }
    return message;
}

class MeshFile : public testing::TestWithParam<ExpectedFile> {};

void expect_mesh(const std::string& path, const std::string& details) {
    const std::size_t faces = details.find("; f ");
    ASSERT_TRUE(details.starts_with("v ") && faces != std::string::npos) << details;
    const TriangleMesh mesh = read_mesh(path);
    EXPECT_EQ(mesh.vertices, rows_of<double>(details.substr(2, faces - 2)));
    EXPECT_EQ(mesh.faces, rows_of<int>(details.substr(faces + 4)));
}

void expect_sequence(const std::string& folder, const std::string& details) {
    const MeshSequence sequence = read_sequence(expand_inputs({folder}));
    std::ostringstream order;
    for (std::size_t i = 0; i < sequence.names.size(); ++i) {
        const std::vector<Point>& shape = sequence.shapes[i];
        EXPECT_EQ(shape.front(), (Point{0, 0, 0}));
        order << (i == 0 ? "" : " ") << sequence.names[i] << "=" << shape.back()[2];
    }
    EXPECT_EQ(order.str(), details);
    EXPECT_EQ(sequence.faces, (std::vector<Face>{{0, 1, 2}, {0, 2, 3}}));
}

TEST_P(MeshFile, IsWhatTheTableSays) {
    const auto& [name, outcome, details] = GetParam();
    const std::string path = kFolder + name;
    if (outcome == "is") {
        expect_mesh(path, details);
    } else if (outcome == "order") {
        expect_sequence(path.substr(0, path.size() - 1), details);
    } else if (name == "no_meshes/") {
        EXPECT_EQ(without_folder(thrown_message<UsageError>(
                      [&] { expand_inputs({path.substr(0, path.size() - 1)}); })),
                  details);
    } else {
        ASSERT_EQ(outcome, "fails");
        const std::string message = thrown_message<InputError>([&] {
            if (path.ends_with('/')) {
                read_sequence(expand_inputs({path.substr(0, path.size() - 1)}));
            } else {
                read_mesh(path);
            }
        });
        EXPECT_EQ(without_folder(message),
                  (name.ends_with('/') ? name.substr(0, name.size() - 1) : name) + details);
    }
}

INSTANTIATE_TEST_SUITE_P(Table, MeshFile, testing::ValuesIn(expected_files()),
                         [](const auto& tested) {
                             std::string name = tested.param.name;
                             for (char& c : name) {
                                 if (c == '.' || c == '/') c = '_';
                             }
                             return name;
                         });

TEST(MeshFiles, HaveOneLineEachInTheTable) {
    std::vector<std::string> listed, present;
    for (const ExpectedFile& file : expected_files()) listed.push_back(file.name);
    for (const auto& entry : std::filesystem::directory_iterator(kFolder)) {
        const std::string name = entry.path().filename().string();
        if (name != "expected.txt") present.push_back(name + (entry.is_directory() ? "/" : ""));
    }
    EXPECT_THAT(listed, testing::UnorderedElementsAreArray(present));
    EXPECT_GE(listed.size(), 60u);
}

}  // namespace
}  // namespace mscomp
