// SPDX-License-Identifier: MIT
// What the pages promise about files, tests and figures that can be looked up.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "base/temporary_folder.h"
#include "mscomp/base/atomic_file.h"

namespace mscomp {
namespace {

namespace fs = std::filesystem;

const fs::path kRootFolder = fs::path(MSCOMP_TESTS_DIR).parent_path();

std::vector<fs::path> pages() {
    std::vector<fs::path> found{kRootFolder / "README.md", kRootFolder / "CHANGELOG.md"};
    for (const auto& entry : fs::recursive_directory_iterator(kRootFolder / "docs")) {
        if (entry.path().extension() == ".md") found.push_back(entry.path());
    }
    return found;
}

std::vector<std::smatch> all_matches(const std::string& text, const std::regex& expression) {
    return {std::sregex_iterator(text.begin(), text.end(), expression), std::sregex_iterator()};
}

/// The names by which headings can be linked to.
std::set<std::string> anchors(const fs::path& page) {
    std::set<std::string> names;
    const std::string text = read_file(page.string());
    static const std::regex kHeading("(^|\n)#+ ([^\n]*)");
    for (const std::smatch& heading : all_matches(text, kHeading)) {
        std::string name;
        for (const char c : heading[2].str()) {
            const auto code = static_cast<unsigned char>(c);
            if (std::isalnum(code) != 0 || c == '-' || c == '_') {
                name += static_cast<char>(std::tolower(code));
            } else if (c == ' ') {
                name += '-';
            }
        }
        names.insert(name);
    }
    return names;
}

TEST(Pages, LinkToFilesAndHeadingsThatExist) {
    static const std::regex kLink(R"(\]\(([^)#\s]*)(#([^)\s]+))?\))");
    for (const fs::path& page : pages()) {
        const std::string text = read_file(page.string());
        for (const std::smatch& link : all_matches(text, kLink)) {
            const std::string target = link[1];
            if (target.find("://") != std::string::npos) continue;
            const fs::path file = target.empty() ? page : page.parent_path() / target;
            EXPECT_TRUE(fs::exists(file)) << page << " links to " << target;
            if (!link[3].matched || !fs::exists(file)) continue;
            EXPECT_TRUE(anchors(file).contains(link[3])) << page << " links to " << link[0];
        }
    }
}

/// "Suite.Name" of every test in the sources, and every suite alone.
std::set<std::string> tests_in_sources() {
    static const std::regex kTest(R"(TEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\))");
    std::set<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(kRootFolder / "tests")) {
        if (entry.path().extension() != ".cpp") continue;
        const std::string text = read_file(entry.path().string());
        for (const std::smatch& test : all_matches(text, kTest)) {
            names.insert(test[1].str());
            names.insert(test[1].str() + "." + test[2].str());
        }
    }
    return names;
}

TEST(Claims, NameTestsThatExist) {
    static const std::regex kName(R"(`(?!Suite\.)([A-Z]\w*)\.(\*|[A-Z]\w*)`)");
    const std::set<std::string> tests = tests_in_sources();
    const std::string text = read_file((kRootFolder / "docs/claims.md").string());
    const std::vector<std::smatch> claimed = all_matches(text, kName);
    EXPECT_GT(claimed.size(), 100U);
    for (const std::smatch& name : claimed) {
        const std::string wanted =
            name[2] == "*" ? name[1].str() : name[1].str() + "." + name[2].str();
        EXPECT_TRUE(tests.contains(wanted)) << "docs/claims.md names " << name[0];
    }
}

/// The first block of the page between ```python and ```.
std::string python_of(const std::string& page) {
    const std::string fence = "```python\n";
    const std::size_t begin = page.find(fence) + fence.size();
    return page.substr(begin, page.find("```", begin) - begin);
}

/// The number behind `label`.
double number_after(const std::string& text, const std::string& label) {
    const std::size_t at = text.find(label);
    EXPECT_NE(at, std::string::npos) << label << "\n" << text;
    return at == std::string::npos ? NAN : std::strtod(text.c_str() + at + label.size(), nullptr);
}

class EquationsPage : public testing::Test {
  protected:
    int run(const std::string& command) const {
        const std::string line = "cd '" + folder_.path() +
                                 "' && PATH=" MSCOMP_BIN_DIR ":$PATH && " + command + " >out 2>err";
        const int status = std::system(line.c_str());
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }

    TemporaryFolder folder_;
};

// The papers' equations, followed in another language, give the numbers in the file.
TEST_F(EquationsPage, ExampleAgreesWithTheFileToRounding) {
    if (run("/usr/bin/python3 -c 'import numpy'") != 0) GTEST_SKIP() << "no numpy";
    const std::string page = read_file((kRootFolder / "docs/from-equations-to-file.md").string());
    for (const std::string& command :
         {std::string("acapfeat generate twist -o bar --turns 0.75 --frames 6 --vertices 100 "
                      "--thickness 1"),
          std::string("acapfeat extract bar -o bar.safetensors --no-align")}) {
        ASSERT_THAT(page, testing::HasSubstr("\n    " + command + "\n"));
        ASSERT_EQ(run(command), 0) << read_file(folder_ / "err");
    }
    folder_.put("follow.py", python_of(page));
    ASSERT_EQ(run("/usr/bin/python3 follow.py"), 0) << read_file(folder_ / "err");
    const std::string out = read_file(folder_ / "out");
    EXPECT_LE(number_after(out, "largest difference of the nine numbers "), 1e-6) << out;
    EXPECT_LE(number_after(out, "largest difference of exp(r) S from T  "), 1e-6) << out;
    const double energy = number_after(out, "energy ");
    EXPECT_NEAR(energy, number_after(out, "in the file "), 1e-5 * energy) << out;
    EXPECT_THAT(page, testing::HasSubstr("principal angle 112.80 degrees, t = -1"));
    EXPECT_THAT(out, testing::HasSubstr("principal angle 112.80 degrees, t = -1")) << out;
}

}  // namespace
}  // namespace mscomp
