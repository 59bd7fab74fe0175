// SPDX-License-Identifier: MIT
// What `cmake --install` leaves, used as others use it: from another folder, by CMake and by
// pkg-config, with none of our flags.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "install/shell.h"
#include "mscomp/base/atomic_file.h"

namespace mscomp {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

const std::string kSources = fs::path(MSCOMP_TESTS_DIR).parent_path().string();
const std::string kExample = kSources + "/docs/examples/extract_and_decode";
const std::string kFirstPlace = "before_the_move";

/// Installed into a folder of the test's own and moved from there to `prefix_`.
class Installed : public testing::Test {
  protected:
    Installed() {
        const auto* info = testing::UnitTest::GetInstance()->current_test_info();
        root_ = build_folder() + "/install_test/" + info->name();
        prefix_ = root_ + "/prefix";
        fs::remove_all(root_);
        fs::create_directories(root_);
        const ShellOutcome outcome =
            run(MSCOMP_CMAKE " --install '" + build_folder() + "' --prefix " + kFirstPlace);
        EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
        fs::rename(root_ + "/" + kFirstPlace, prefix_);
    }
    ~Installed() override {
        std::error_code ignored;
        if (!HasFailure()) fs::remove_all(root_, ignored);
    }

    ShellOutcome run(const std::string& command) const { return run_in(root_, command); }

    /// Configures a project of `lists` that looks for mscomp.
    ShellOutcome configure(const std::string& lists, const std::string& options = "") const {
        fs::create_directories(root_ + "/project");
        write_file(root_ + "/project/CMakeLists.txt",
                   "cmake_minimum_required(VERSION 3.25)\nproject(user LANGUAGES CXX)\n" + lists);
        return configure_folder(root_ + "/project", options);
    }
    ShellOutcome configure_folder(const std::string& folder, const std::string& options) const {
        return run(MSCOMP_CMAKE " -G '" MSCOMP_GENERATOR "' -S '" + folder +
                   "' -B built -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER='" MSCOMP_CXX
                   "' -DCMAKE_PREFIX_PATH='" +
                   prefix_ + "' " + options);
    }

    std::vector<fs::path> files() const {
        std::vector<fs::path> found;
        for (const auto& entry : fs::recursive_directory_iterator(prefix_)) {
            if (entry.is_regular_file()) found.push_back(entry.path());
        }
        return found;
    }
    /// The one file of that name.
    fs::path file(const std::string& name) const {
        for (const fs::path& path : files()) {
            if (path.filename() == name) return path;
        }
        ADD_FAILURE() << "no " << name << " is installed";
        return {};
    }
    std::string pkg_config() const {
        return "PKG_CONFIG_PATH='" + file("mscomp.pc").parent_path().string() + "' pkg-config ";
    }

    /// The example gives the shapes of a generated set back.
    void expect_example_works(const std::string& program) const {
        const ShellOutcome outcome =
            run("prefix/bin/acapfeat generate twist -o set --frames 4 --vertices 100 --quiet && " +
                program + " set");
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        static const std::regex kLine(R"(frame_\d+: comes back within (\S+))");
        int shapes = 0;
        for (const std::string& line : lines_of(outcome.out)) {
            std::smatch match;
            if (!std::regex_search(line, match, kLine)) continue;
            ++shapes;
            EXPECT_LT(std::stod(match[1]), 1e-4) << line;
        }
        EXPECT_EQ(shapes, 4) << outcome.out;
        const ShellOutcome refused = run(program + " nothing");
        EXPECT_EQ(refused.code, 2) << refused.err;
    }

    std::string root_, prefix_;
};

bool is_text(const fs::path& path) {
    const std::string extension = path.extension().string();
    return extension == ".cmake" || extension == ".pc";
}

/// Names of components, from the package itself.
std::set<std::string> components(const std::string& config) {
    std::smatch match;
    static const std::regex kList(R"(set\(mscomp_known_components ([^)]*)\))");
    EXPECT_TRUE(std::regex_search(config, match, kList)) << config;
    const std::string list = match[1];
    const std::regex space("[ ;]+");
    return {std::sregex_token_iterator(list.begin(), list.end(), space, -1),
            std::sregex_token_iterator()};
}

TEST_F(Installed, ExampleIsBuiltByFindPackageAndWorks) {
    const ShellOutcome configured = configure_folder(kExample, "");
    ASSERT_EQ(configured.code, 0) << configured.out << configured.err;
    const ShellOutcome built = run(MSCOMP_CMAKE " --build built --verbose");
    ASSERT_EQ(built.code, 0) << built.out << built.err;
    for (const char* flag : {"-Wall", "-Werror", "-fno-math-errno", "-march"}) {
        EXPECT_THAT(built.out, Not(HasSubstr(flag)));
    }
    expect_example_works("built/extract_and_decode");
}

// A program that is not ours trains, measures and decodes with what is installed.
TEST_F(Installed, ExampleTrainsMeasuresAndDecodes) {
    const ShellOutcome configured =
        configure_folder(kSources + "/docs/examples/train_and_decode", "");
    ASSERT_EQ(configured.code, 0) << configured.out << configured.err;
    const ShellOutcome built = run(MSCOMP_CMAKE " --build built");
    ASSERT_EQ(built.code, 0) << built.out << built.err;
    const ShellOutcome outcome = run(
        "rm -rf set arm.run && prefix/bin/acapfeat generate arm -o set --frames 8 --vertices 300 "
        "--quiet && prefix/bin/acapfeat extract set -o set.safetensors --quiet --force && "
        "built/train_and_decode set.safetensors arm.run end.obj");
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("40 epochs"));
    EXPECT_THAT(outcome.out, HasSubstr("E_rms on 4 unseen shapes"));
    EXPECT_THAT(outcome.out, HasSubstr("end.obj: component"));
    const ShellOutcome checked = run("prefix/bin/acapfeat check set/*.obj end.obj");
    EXPECT_EQ(checked.code, 0) << checked.out << checked.err;
}

TEST_F(Installed, EveryExampleIsBuiltFromItsInstalledSources) {
    int examples = 0;
    for (const auto& entry : fs::directory_iterator(prefix_ + "/share/doc/mscomp/examples")) {
        ++examples;
        fs::remove_all(root_ + "/built");
        const ShellOutcome configured = configure_folder(entry.path().string(), "");
        ASSERT_EQ(configured.code, 0) << configured.out << configured.err;
        const ShellOutcome built = run(MSCOMP_CMAKE " --build built");
        EXPECT_EQ(built.code, 0) << built.out << built.err;
    }
    EXPECT_GE(examples, 2);
}

TEST_F(Installed, ExampleIsBuiltByPkgConfigAndWorks) {
    if (!is_installed("pkg-config")) GTEST_SKIP() << "no pkg-config";
    const ShellOutcome built = run(MSCOMP_CXX " '" + kExample + "/main.cpp' $(" + pkg_config() +
                                   "--cflags --libs mscomp) -o extract_and_decode");
    ASSERT_EQ(built.code, 0) << built.out << built.err;
    EXPECT_EQ(run(pkg_config() + "--modversion mscomp").out, MSCOMP_VERSION "\n");
    expect_example_works("./extract_and_decode");
}

TEST_F(Installed, FilesNameNoPlaceOfTheBuild) {
    int texts = 0;
    for (const fs::path& path : files()) {
        const std::string content = read_file(path.string());
        texts += is_text(path) ? 1 : 0;
#ifndef NDEBUG
        if (!is_text(path)) continue;  // asserts and debug information name sources
#endif
        EXPECT_EQ(content.find(kSources), std::string::npos) << path;
        EXPECT_EQ(content.find(kFirstPlace), std::string::npos) << path;
        if (!is_text(path)) continue;
        static const std::regex kAbsolute(R"((^|[\s";:=I])/(usr|opt|home|lib|tmp)\b)");
        std::smatch match;
        // The version file compares sizes of pointers only; the export looks for "/" itself.
        EXPECT_FALSE(std::regex_search(content, match, kAbsolute)) << path << ": " << match[0];
    }
    EXPECT_GE(texts, 4);
}

TEST_F(Installed, PackageHandsOnNoFlagsOfOurs) {
    for (const fs::path& path : files()) {
        if (!is_text(path)) continue;
        const std::string content = read_file(path.string());
        for (const char* flag : {"-W", "-march", "-fno-", "-O2", "-fsanitize", "mscomp_options"}) {
            EXPECT_THAT(content, Not(HasSubstr(flag))) << path;
        }
    }
}

TEST_F(Installed, EveryModuleIsAComponentWithAnArchive) {
    const std::set<std::string> names = components(read_file(file("mscompConfig.cmake").string()));
    EXPECT_THAT(names, testing::IsSupersetOf({"base", "mesh", "acap", "nn"}));
    std::set<std::string> archives;
    for (const fs::path& path : files()) {
        if (path.extension() != ".a") continue;
        archives.insert(path.stem().string().substr(std::string("libmscomp_").size()));
    }
    EXPECT_EQ(archives, names);
}

TEST_F(Installed, ArchivesCanGoIntoASharedLibrary) {
    const std::string folder = file("libmscomp_base.a").parent_path().string();
    const ShellOutcome linked = run(MSCOMP_CXX " -shared -o all.so -Wl,--whole-archive '" + folder +
                                    "'/libmscomp_*.a -Wl,--no-whole-archive");
    EXPECT_EQ(linked.code, 0) << linked.err;
}

// Its headers compile, and every function in it has what it calls, with nothing else linked.
TEST_F(Installed, EveryComponentIsWholeByItself) {
    const std::string config = read_file(file("mscompConfig.cmake").string());
    const std::set<std::string> names = components(config);
    const fs::path include = file("error.h").parent_path().parent_path().parent_path();
    std::map<std::string, std::string> sources;
    for (const auto& entry : fs::recursive_directory_iterator(include / "mscomp")) {
        if (!entry.is_regular_file()) continue;
        const fs::path header = fs::relative(entry.path(), include);
        // A folder within a module that is none itself belongs to that module.
        fs::path folder = header.parent_path();
        while (!names.contains(folder.filename().string()) && folder.has_parent_path()) {
            folder = folder.parent_path();
        }
        EXPECT_TRUE(names.contains(folder.filename().string())) << header << " is of no component";
        sources[folder.filename().string()] += "#include <" + header.string() + ">\n";
    }
    std::string lists;
    for (const auto& [name, source] : sources) {
        fs::create_directories(root_ + "/project");
        write_file(root_ + "/project/" + name + ".cpp", source);
        const std::string target = "use_" + name;
        lists += "find_package(mscomp REQUIRED COMPONENTS " + name + ")\nadd_library(" + target +
                 " SHARED " + name + ".cpp)\ntarget_link_libraries(" + target +
                 " PRIVATE $<LINK_LIBRARY:WHOLE_ARCHIVE,mscomp::" + name + ">)\n" +
                 "target_link_options(" + target + " PRIVATE -Wl,--no-undefined)\n";
    }
    const ShellOutcome configured = configure(lists);
    ASSERT_EQ(configured.code, 0) << configured.out << configured.err;
    const ShellOutcome built = run(MSCOMP_CMAKE " --build built");
    EXPECT_EQ(built.code, 0) << built.out << built.err;
}

TEST_F(Installed, UnknownComponentIsNamedWithThoseThereAre) {
    const ShellOutcome outcome =
        configure("find_package(mscomp REQUIRED COMPONENTS acap nonsense)\n");
    EXPECT_NE(outcome.code, 0);
    EXPECT_THAT(outcome.err, HasSubstr("no component 'nonsense'"));
    EXPECT_THAT(outcome.err, HasSubstr("acap, base, "));

    const ShellOutcome optional = configure(
        "find_package(mscomp REQUIRED COMPONENTS acap OPTIONAL_COMPONENTS nonsense)\n"
        "if(mscomp_nonsense_FOUND OR NOT mscomp_acap_FOUND)\n"
        "    message(FATAL_ERROR \"wrong\")\nendif()\n");
    EXPECT_EQ(optional.code, 0) << optional.err;
}

TEST_F(Installed, ComponentsLookForWhatTheyAreLinkedWithOnly) {
    const std::string no_ceres = "-DCMAKE_DISABLE_FIND_PACKAGE_Ceres=ON";
    const ShellOutcome without =
        configure("find_package(mscomp REQUIRED COMPONENTS geodesic)\n", no_ceres);
    EXPECT_EQ(without.code, 0) << without.err;
    const ShellOutcome with =
        configure("find_package(mscomp REQUIRED COMPONENTS acap)\n", no_ceres);
    EXPECT_NE(with.code, 0);
    EXPECT_THAT(with.err, HasSubstr("Ceres"));
}

TEST_F(Installed, AnotherMinorVersionIsAnotherLibrary) {
    EXPECT_EQ(configure("find_package(mscomp 0.1 REQUIRED COMPONENTS base)\n").code, 0);
    for (const std::string other : {"0.0", "0.99"}) {
        const ShellOutcome refused =
            configure("find_package(mscomp " + other + " REQUIRED COMPONENTS base)\n");
        EXPECT_NE(refused.code, 0) << other;
        EXPECT_THAT(refused.err, HasSubstr("version \"" + other + "\""));
    }
}

TEST_F(Installed, ProgramsPagesAndCompletionsAreThere) {
    EXPECT_EQ(run("prefix/bin/mscomp --version").out, "mscomp " MSCOMP_VERSION "\n");
    EXPECT_EQ(run("prefix/bin/acapfeat --version").out, "acapfeat " MSCOMP_VERSION "\n");
    for (const char* name :
         {"share/man/man1/mscomp.1", "share/man/man1/mscomp-train.1",
          "share/man/man1/acapfeat-extract.1", "share/bash-completion/completions/mscomp",
          "share/bash-completion/completions/acapfeat", "share/zsh/site-functions/_mscomp",
          "share/fish/vendor_completions.d/acapfeat.fish", "share/doc/mscomp/copyright",
          "share/doc/mscomp/examples/extract_and_decode/main.cpp"}) {
        EXPECT_TRUE(fs::exists(prefix_ + "/" + name)) << name;
    }
}

}  // namespace
}  // namespace mscomp
