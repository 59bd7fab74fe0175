// SPDX-License-Identifier: MIT
// Every input that fuzzing kept, through the same targets, without libFuzzer.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <ostream>
#include <stdexcept>

#include "base/temporary_folder.h"
#include "fuzz/promises.h"
#include "fuzz/targets.h"

namespace mscomp::fuzz {

void PrintTo(const Target& target, std::ostream* out) { *out << target.name; }

namespace {

class FuzzCorpus : public testing::TestWithParam<Target> {};

std::vector<std::string> corpus(const std::string& name) {
    const std::string folder = std::string(MSCOMP_TESTS_DIR) + "/fuzz/corpus/" + name;
    std::vector<std::string> paths;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        paths.push_back(entry.path().string());
    }
    std::sort(paths.begin(), paths.end());
    return paths;
}

TEST_P(FuzzCorpus, KeepsEveryPromise) {
    std::vector<std::string> paths;
    ASSERT_NO_THROW(paths = corpus(GetParam().name)) << "no corpus for " << GetParam().name;
    ASSERT_FALSE(paths.empty()) << "the corpus for " << GetParam().name << " is empty";
    for (const std::string& path : paths) {
        SCOPED_TRACE(path);
        const std::string input = TemporaryFolder::content(path);
        // A copy of just this size on the heap, so that a sanitizer sees a byte too far.
        const std::vector<std::uint8_t> bytes(input.begin(), input.end());
        EXPECT_NO_THROW(run_target(GetParam(), bytes.data(), bytes.size()));
    }
}

INSTANTIATE_TEST_SUITE_P(All, FuzzCorpus, testing::ValuesIn(kTargets),
                         [](const auto& target) { return std::string(target.param.name); });

// What a reader must not do is noticed.
TEST(FuzzPromises, AnErrorOfAnotherKindIsAFinding) {
    const auto run = [](void (*check)(std::span<const std::byte>)) {
        run_target({"planted", check}, nullptr, 0);
    };
    const auto refuse = [](const char* path, const char* message) {
        unless_refused("input", [&]() -> int { throw InputError({path}, message); });
    };
    EXPECT_NO_THROW(refuse("input", "is none"));
    EXPECT_THROW(refuse("other", "is none"), BrokenPromise);
    EXPECT_THROW(run([](auto) { throw std::bad_alloc(); }), std::bad_alloc);
    EXPECT_THROW(
        run([](auto) { unless_refused("input", []() -> int { throw std::out_of_range("at"); }); }),
        std::out_of_range);
}

}  // namespace
}  // namespace mscomp::fuzz
