// SPDX-License-Identifier: MIT
// What a tiny file can cost: less than 64 MB and a second, whatever it claims to hold.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <malloc.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/error.h"

namespace mscomp {
namespace {

#ifdef MSCOMP_SANITIZED
constexpr bool kSanitized = true;  // their shadow memory breaks any limit
#else
constexpr bool kSanitized = false;
#endif

constexpr std::size_t kMemory = std::size_t{64} << 20;
// Large blocks go back to the system: what other tests have freed is no memory to spare.
[[maybe_unused]] const int kLargeBlocksGoBack = ::mallopt(M_MMAP_THRESHOLD, 1 << 20);

std::size_t address_space() {
    std::size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    return pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

enum Outcome { fine = 0, too_slow = 10, unexpected_error = 11, no_limit = 12 };

/// Runs `work` in a child process that may use 64 MB more than now and `seconds` of processor time.
template <class Work>
int outcome_under_limits(Work&& work, double seconds = 1) {
    const pid_t child = ::fork();
    if (child == 0) {
        const rlimit memory{address_space() + kMemory, address_space() + kMemory};
        if (!kSanitized && ::setrlimit(RLIMIT_AS, &memory) != 0) ::_exit(no_limit);
        const std::clock_t start = std::clock();
        try {
            work();
        } catch (...) {
            ::_exit(unexpected_error);
        }
        const double taken = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
        ::_exit(taken < seconds || kSanitized ? fine : too_slow);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

void read_or_refuse(const std::string& path) {
    try {
        read_mesh(path);
    } catch (const InputError&) {
    }
}
template <class Parse>
void expect_refused(Parse&& parse, const std::string& bytes) {
    try {
        parse(bytes);
    } catch (const InputError&) {
        return;
    }
    throw std::logic_error("accepted");
}

// The limits would be noticed: an allocation beyond them fails in the child.
TEST(HostileFiles, LimitsAreInForce) {
    if (kSanitized) GTEST_SKIP() << "no limit of memory under a sanitizer";
    EXPECT_EQ(outcome_under_limits([] { std::string(kMemory, 'x').front(); }), unexpected_error);
    EXPECT_EQ(outcome_under_limits([] { std::string(kMemory / 4, 'x').front(); }), fine);
    const auto take_40_milliseconds = [] {
        for (const std::clock_t start = std::clock();
             std::clock() - start < 0.04 * CLOCKS_PER_SEC;) {
        }
    };
    EXPECT_EQ(outcome_under_limits(take_40_milliseconds, 0.02), too_slow);
    EXPECT_EQ(outcome_under_limits(take_40_milliseconds), fine);
}

TEST(HostileFiles, NoTinyFileTakesASecondOrMuchMemory) {
    const int outcome = outcome_under_limits([] {
        for (const auto& entry : std::filesystem::recursive_directory_iterator(
                 std::string(MSCOMP_TESTS_DIR) + "/mesh/files")) {
            if (entry.is_regular_file()) read_or_refuse(entry.path().string());
        }
    });
    EXPECT_EQ(outcome, fine);
}

class HostileCount : public testing::TestWithParam<std::string> {};

TEST_P(HostileCount, IsRefusedInAPly) {
    const auto ply = [](const std::string& format, const std::string& vertices,
                        const std::string& faces, const std::string& length) {
        return "ply\nformat " + format + " 1.0\nelement vertex " + vertices +
               "\nproperty float x\nproperty float y\nproperty float z\nelement face " + faces +
               "\nproperty list " + length + " int vertex_indices\nend_header\n";
    };
    const auto parse = [](const std::string& bytes) { parse_ply(bytes, "a.ply"); };
    const std::string count = GetParam();
    const std::string data(200, '\0');
    const int outcome = outcome_under_limits([&] {
        for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
            expect_refused(parse, ply(format, count, "2", "uchar") + data);
            expect_refused(parse, ply(format, "4", count, "uchar") + data);
            expect_refused(parse, ply(format, count, count, "int") + data);
        }
        // A list that claims as many values, in a text file.
        expect_refused(
            parse, ply("ascii", "3", "1", "uint") + "0 0 0\n1 0 0\n0 1 0\n" + count + " 0 1 2\n");
    });
    EXPECT_EQ(outcome, fine);
}

TEST_P(HostileCount, IsRefusedInAnOff) {
    const auto parse = [](const std::string& bytes) { parse_off(bytes, "a.off"); };
    const std::string count = GetParam();
    const std::string points = "0 0 0\n1 0 0\n0 1 0\n";
    const int outcome = outcome_under_limits([&] {
        expect_refused(parse, "OFF\n" + count + " 1 0\n" + points + "3 0 1 2\n");
        expect_refused(parse, "OFF\n3 " + count + " 0\n" + points + "3 0 1 2\n");
        expect_refused(parse, "OFF\n" + count + " " + count + " 0\n" + points + "3 0 1 2\n");
        expect_refused(parse, "OFF\n3 1 0\n" + points + count + " 0 1 2\n");
        expect_refused(parse, "OFF\n3 1 0\n" + points + "3 0 1 " + count + "\n");
    });
    EXPECT_EQ(outcome, fine);
}

TEST_P(HostileCount, IsRefusedAsAnIndexInAnObj) {
    const auto parse = [](const std::string& bytes) { parse_obj(bytes, "a.obj"); };
    const std::string count = GetParam();
    const std::string points = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    const int outcome = outcome_under_limits([&] {
        expect_refused(parse, points + "f 1 2 " + count + "\n");
        expect_refused(parse, "f 1 2 " + count + "\n" + points);
    });
    EXPECT_EQ(outcome, fine);
}

INSTANTIATE_TEST_SUITE_P(Counts, HostileCount,
                         testing::Values("1000000", "2147483647", "2147483648", "4294967299",
                                         "768614336404564651",   // times 24 bytes: 8 modulo 2^64
                                         "4611686018427387905",  // times 12 bytes: 12 modulo 2^64
                                         "9000000000000000000", "9223372036854775807",
                                         "18446744073709551615", "18446744073709551620", "-7",
                                         "-9223372036854775808"));

}  // namespace
}  // namespace mscomp
