// SPDX-License-Identifier: MIT
#include "cli/program.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <limits>
#include <new>
#include <stdexcept>
#include <thread>
#include <vector>

#include "base/temporary_folder.h"
#include "cli/say.h"
#include "cli/signals.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/base/interruption.h"
#include "mscomp/base/nearest_name.h"
#include "mscomp/base/parallel.h"

namespace mscomp {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

struct Outcome {
    int code = -1;
    std::string out, err;
};

Outcome run(const std::function<void()>& body, std::vector<const char*> arguments) {
    CLI::App app("A program for tests", "acapfeat");
    setup_program(app);
    CommonOptions options;
    CLI::App* command = app.add_subcommand("work", "Do it");
    add_quiet(*command, options);
    add_threads(*command, options);
    set_example(*command, "acapfeat work --quiet");
    command->callback(body);
    arguments.insert(arguments.begin(), "acapfeat");
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    Outcome outcome;
    outcome.code = run_program(app, static_cast<int>(arguments.size()), arguments.data());
    outcome.out = testing::internal::GetCapturedStdout();
    outcome.err = testing::internal::GetCapturedStderr();
    return outcome;
}

Outcome run_throwing(const std::function<void()>& body) { return run(body, {"work"}); }

TEST(Program, SuccessIsZeroAndSilent) {
    const Outcome outcome = run([] {}, {"work"});
    EXPECT_EQ(outcome.code, 0);
    EXPECT_EQ(outcome.out + outcome.err, "");
}

TEST(Program, EveryErrorHasItsExitCodeAndItsMessage) {
    const Outcome input = run_throwing([] { throw InputError({"a.obj", 3, 2}, "odd"); });
    EXPECT_EQ(input.code, 3);
    EXPECT_EQ(input.err, "acapfeat: error: a.obj:3:2: odd\n");
    EXPECT_EQ(run_throwing([] { throw UsageError("no"); }).code, 2);
    EXPECT_EQ(run_throwing([] { throw ConfigError({"c"}, "k", "no"); }).code, 2);
    EXPECT_EQ(run_throwing([] { throw MeshError("no"); }).code, 3);
    EXPECT_EQ(run_throwing([] { throw IoError("f", "no"); }).code, 4);
    EXPECT_EQ(run_throwing([] { throw NumericalError("no"); }).code, 5);
    EXPECT_EQ(run_throwing([] { throw CheckpointError("f", "no"); }).code, 6);
    EXPECT_EQ(run_throwing([] { throw Interrupted(SIGINT, "no"); }).code, 130);
    EXPECT_EQ(run_throwing([] { throw Interrupted(SIGTERM, "no"); }).code, 143);
}

// Text that was put together past the placeholders of messages, tables and JSON too.
TEST(Program, WhatIsPrintedAsItIsCannotSteerATerminal) {
    const std::string hostile =
        "a\x1b[2J\tb\r\nc\xc2\x9b"
        "1m\xe2\x80\xae\xff\n";
    const Outcome outcome = run_throwing([&] {
        print_lines(hostile);
        say_lines(hostile);
    });
    EXPECT_EQ(outcome.out, "a?[2J?b?\nc?1m??\n");
    EXPECT_EQ(outcome.err, outcome.out);
}

TEST(Program, WhatNobodyForesawIsABug) {
    const Outcome outcome = run_throwing([] { throw std::logic_error("index"); });
    EXPECT_EQ(outcome.code, 1);
    EXPECT_THAT(outcome.err, HasSubstr("this is a bug, please report it: index"));
    EXPECT_EQ(run_throwing([] { throw 5; }).code, 1);
    const Outcome memory = run_throwing([] { throw std::bad_alloc(); });
    EXPECT_EQ(memory.code, 4);
    EXPECT_THAT(memory.err, HasSubstr("not enough memory"));
}

/// As a destructor that takes memory ends a program, where the compiler calls terminate() itself:
/// nothing says any more what was thrown.
[[noreturn]] void end_without_memory() {
    volatile std::size_t size = std::numeric_limits<std::ptrdiff_t>::max();
    try {
        ::operator delete(::operator new(size));
    } catch (const std::bad_alloc&) {
        size = 0;
    }
    std::terminate();
}

TEST(ProgramDeathTest, MissingMemoryIsFourWhereverItIsMissing) {
#ifdef MSCOMP_SANITIZED
    GTEST_SKIP() << "a sanitizer ends the program itself where memory is missing";
#endif
    ::setenv("GOMP_SPINCOUNT", "20000", 1);
    ::setenv("OPENBLAS_NUM_THREADS", "1", 1);  // else the program would start itself anew
    std::string name = "acapfeat", command = "work";
    std::vector<char*> words{name.data(), command.data(), nullptr};
    const auto work = [](CLI::App& app) {
        CLI::App* own = app.add_subcommand("work", "Do it");
        set_example(*own, "acapfeat work");
        own->callback([] { end_without_memory(); });
    };
    EXPECT_EXIT(run_main({"acapfeat", "A program for tests", {work}}, 2, words.data()),
                testing::ExitedWithCode(4), "not enough memory");
}

TEST(Program, HelpAndVersionAreAnswers) {
    const Outcome help = run([] { FAIL(); }, {"work", "--help"});
    EXPECT_EQ(help.code, 0);
    EXPECT_THAT(help.out, testing::EndsWith("Example:\n  acapfeat work --quiet\n"));
    EXPECT_EQ(run([] { FAIL(); }, {"--help"}).code, 0);
    const Outcome version = run([] { FAIL(); }, {"--version"});
    EXPECT_EQ(version.code, 0);
    EXPECT_THAT(version.out, StartsWith("acapfeat "));
}

TEST(Program, AWrongCommandLineIsTwoAndNamesTheHelp) {
    const Outcome unknown = run([] { FAIL(); }, {"work", "--loud"});
    EXPECT_EQ(unknown.code, 2);
    EXPECT_THAT(unknown.err, HasSubstr("--loud"));
    EXPECT_THAT(unknown.err, HasSubstr("See acapfeat work --help"));
    EXPECT_EQ(run([] { FAIL(); }, {}).code, 2);
    const Outcome misspelt = run([] { FAIL(); }, {"wrok"});
    EXPECT_EQ(misspelt.code, 2);
    EXPECT_THAT(misspelt.err, HasSubstr("no command 'wrok'; the nearest one is 'work'"));
    for (const char* count : {"-1", "two", "1025", "3x", ""}) {
        const Outcome wrong = run([] { FAIL(); }, {"work", "--threads", count});
        EXPECT_EQ(wrong.code, 2);
        EXPECT_THAT(wrong.err, HasSubstr("wanted 0 to 1024"));
    }
}

TEST(Program, ThreadsAreSetBeforeTheCommandRuns) {
    int threads = 0;
    EXPECT_EQ(run([&threads] { threads = thread_count(); }, {"work", "--threads", "3"}).code, 0);
    EXPECT_EQ(threads, 3);
    set_thread_count(0);
}

TEST(Program, TheFirstSignalIsAFlagThatCommandsLookAt) {
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR2, SIGXCPU}) {
        const Outcome outcome = run_throwing([signal] {
            EXPECT_FALSE(interrupted());
            throw_if_interrupted("not yet");
            std::raise(signal);
            EXPECT_TRUE(interrupted());
            EXPECT_EQ(requested_stop(), signal);
            throw_if_interrupted("saved; go on with --resume");
            FAIL();
        });
        EXPECT_EQ(outcome.code, 128 + signal);
        EXPECT_THAT(outcome.err, HasSubstr("saved; go on with --resume"));
    }
}

TEST(Program, ASaveIsAskedForWithoutStopping) {
    const Outcome outcome = run_throwing([] {
        EXPECT_FALSE(take_save_request());
        std::raise(SIGUSR1);
        EXPECT_FALSE(interrupted());
        EXPECT_TRUE(take_save_request());
        EXPECT_FALSE(take_save_request());
    });
    EXPECT_EQ(outcome.code, 0);
}

// nohup(1) has it ignored.
TEST(Program, AnIgnoredHangUpStaysIgnored) {
    std::signal(SIGHUP, SIG_IGN);
    const Outcome outcome = run_throwing([] {
        std::raise(SIGHUP);
        EXPECT_FALSE(interrupted());
    });
    EXPECT_EQ(outcome.code, 0);
    std::signal(SIGHUP, SIG_DFL);
}

// The system repeats it every second of processor time.
TEST(Program, ALimitOfProcessorTimeIsOneWishHoweverOftenItIsSaid) {
    const Outcome outcome = run_throwing([] {
        std::raise(SIGXCPU);
        std::this_thread::sleep_for(std::chrono::milliseconds(1100));
        std::raise(SIGXCPU);
        throw_if_interrupted("saved");
    });
    EXPECT_EQ(outcome.code, 128 + SIGXCPU);
}

// timeout(1) and job systems signal twice in a row; only a later one is a second wish.
TEST(InterruptDeathTest, TheSecondSignalEndsTheProcess) {
    const auto twice = [] {
        watch_interrupts();
        std::raise(SIGINT);
        std::raise(SIGINT);
        std::this_thread::sleep_for(std::chrono::milliseconds(1100));
        std::raise(SIGTERM);
    };
    EXPECT_EXIT(twice(), testing::ExitedWithCode(143), "once more to stop at once");
}

TEST(InterruptDeathTest, TheSecondSignalLeavesNoTemporaryFile) {
    const TemporaryFolder folder;
    const auto twice = [&folder] {
        watch_interrupts();
        AtomicFile file(folder / "a");
        file.write("x");
        if (folder.names().size() != 1) std::abort();
        std::raise(SIGINT);
        std::this_thread::sleep_for(std::chrono::milliseconds(1100));
        std::raise(SIGINT);
    };
    EXPECT_EXIT(twice(), testing::ExitedWithCode(130), "");
    EXPECT_THAT(folder.names(), testing::IsEmpty());
}

TEST(EditDistance, IsZeroOnlyForEqualTextsAndSymmetric) {
    EXPECT_EQ(edit_distance("epochs", "epochs"), 0u);
    EXPECT_EQ(edit_distance("", "abc"), 3u);
    EXPECT_EQ(edit_distance("abc", ""), 3u);
    EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);
    EXPECT_EQ(edit_distance("sitting", "kitten"), 3u);
    EXPECT_EQ(edit_distance("ab", "ba"), 2u);
}

TEST(NearestName, IsTheFirstOfTheClosest) {
    EXPECT_EQ(nearest_name("horze", {"house", "horse", "hose"}), "horse");
    EXPECT_EQ(nearest_name("x", {"b", "a"}), "b");
    EXPECT_EQ(nearest_name("x", {}), "");
}

}  // namespace
}  // namespace mscomp
