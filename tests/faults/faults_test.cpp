// SPDX-License-Identifier: MIT
// Every call of the system that a command makes fails once: what was there before stays whole, or
// what it writes is there whole. A sample of the calls here, all of them with scripts/faults.sh.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <iostream>
#include <limits>
#include <random>
#include <regex>
#include <set>

#include "base/temporary_folder.h"
#include "faults/faulty_run.h"
#include "faults/writing_commands.h"

namespace fs = std::filesystem;

namespace mscomp::faults {
namespace {

using Files = std::map<std::string, std::string>;

/// How many of the calls of a class fail, with one kind of fault: all of them for whoever has time.
long tries_per_kind() {
    const char* text = std::getenv("MSCOMP_FAULT_TRIES");
    return text == nullptr ? 1 : std::atol(text);
}

/// How often each command is killed at a moment that nothing but chance knows.
int kills_per_command() {
    const char* text = std::getenv("MSCOMP_FAULT_KILLS");
    return text == nullptr ? 3 : std::atoi(text);
}

struct Fault {
    const char *call, *kind;
};
constexpr Fault kFaults[] = {
    {"open", "EIO"},        {"open", "ENOSPC"},   {"mkdir", "EDQUOT"},  {"read", "EIO"},
    {"write", "ENOSPC"},    {"write", "EIO"},     {"write", "EDQUOT"},  {"write", "short"},
    {"write", "lost"},      {"write", "full"},    {"sync", "EIO"},      {"sync", "ENOSPC"},
    {"rename", "EIO"},      {"rename", "ENOSPC"}, {"link", "EIO"},      {"unlink", "EIO"},
    {"truncate", "ENOSPC"}, {"truncate", "EIO"},  {"map", "ENOMEM"},    {"close", "EIO"},
    {"stat", "EIO"},        {"lock", "EIO"},      {"memory", "ENOMEM"}, {"open", "kill"},
    {"write", "kill"},      {"sync", "kill"},     {"rename", "kill"},   {"link", "kill"},
    {"unlink", "kill"},     {"mkdir", "kill"},    {"print", "full"},    {"print", "gone"},
    {"print", "EIO"}};

/// What came of all tries with one command; `at_any_moment` of the kills were no call's, and of
/// these `too_early` came before it had written anything.
struct Count {
    int tries = 0, refused = 0, harmless = 0, killed = 0, at_any_moment = 0, too_early = 0;
};

std::map<std::string, Count>& table() {
    static std::map<std::string, Count> counts;
    return counts;
}

/// Inputs made once, and a folder in which one command after the other is tried.
class Bench {
  public:
    Bench() {
        fs::create_directory(inputs());
        // Paths are part of what a run remembers, so everything is made where it is tried.
        fs::create_directory(work());
        prepare_inputs(work());
        fs::copy(work(), inputs(), fs::copy_options::recursive);
    }

    std::string work() const { return folder_ / "work"; }

    /// The folder as it is before the command.
    void reset(const WritingCommand& command) {
        fs::remove_all(work());
        fs::copy(before(command), work(), fs::copy_options::recursive);
    }
    void prepare(const WritingCommand& command) {
        fs::remove_all(work());
        fs::copy(inputs(), work(), fs::copy_options::recursive);
        for (const Arguments& arguments : command.before) {
            const Outcome outcome = run(work(), arguments);
            ASSERT_EQ(outcome.code, 0) << outcome.err;
        }
        // Of the user: it has nothing to do with us.
        if (!command.before.empty() && fs::is_directory(work() + "/out")) {
            folder_.put("work/out/notes.txt", "mine");
        }
        fs::remove_all(before(command));
        fs::copy(work(), before(command), fs::copy_options::recursive);
    }

  private:
    std::string inputs() const { return folder_ / "inputs"; }
    std::string before(const WritingCommand& command) const {
        return folder_ / ("before-" + command.name);
    }

    TemporaryFolder folder_;
};

Bench& bench() {
    static Bench all;
    return all;
}

class Faults : public testing::TestWithParam<WritingCommand> {
  protected:
    void SetUp() override {
        bench().prepare(GetParam());
        before_ = files_below(bench().work());
        counts_ = calls_of(bench().work(), GetParam().arguments);
        after_ = files_below(bench().work());
        ASSERT_NE(before_, after_);
    }

    /// What is wrong with what a fault has led to; "" for nothing.
    std::string judge(const Fault& fault, const Outcome& outcome) const {
        const Files now = files_below(bench().work());
        const bool is_old = now == before_, is_new = now == after_;
        if (std::string(fault.kind) == "kill") {
            if (outcome.signal != SIGKILL) return "was not killed";
            const bool may_be_between = GetParam().goes_on || GetParam().is_pair;
            return is_old || is_new || may_be_between ? "" : "is mixed: " + difference(now);
        }
        if (outcome.signal != 0) return fmt::format("ended by signal {}", outcome.signal);
        if (outcome.code == 0)
            return is_new ? "" : "succeeded with other files: " + difference(now);
        // The OpenMP library ends the process itself, before there is anything to lose.
        const bool is_of_library = outcome.err.find("libgomp: Out of memory") != std::string::npos;
        if (outcome.code != 4 && !is_of_library) return fmt::format("exit code {}", outcome.code);
        // Lost output is no success, but the work is done.
        if (std::string(fault.call) == "print") {
            return is_new ? "" : "left other files: " + difference(now);
        }
        const bool has_file = std::string(fault.call) != "memory";
        if (has_file && !names_a_file(outcome.err)) return "names no file";
        return is_old || is_new || GetParam().goes_on ? "" : "is mixed: " + difference(now);
    }
    /// The same command, undisturbed: it ends as if nothing had been.
    std::string judge_next() const {
        const Outcome outcome = run(bench().work(), next_command());
        if (outcome.code != 0)
            return fmt::format("next: exit code {}: {}", outcome.code, outcome.err);
        const std::vector<std::string> left = temporaries_below(bench().work());
        if (!left.empty()) return "next: left " + left.front();
        const Files now = files_below(bench().work());
        return now == after_ ? "" : "next: other files: " + difference(now);
    }

    void try_all(const Fault& fault) {
        if (GetParam().needs_memory && std::string(fault.call) == "memory") return;
        const long calls = counts_[fault.call];
        const long tries = std::min(calls, tries_of(fault));
        for (long k = 0; k < tries; ++k) {
            // One of a sample is anywhere, but the same in each run.
            const std::size_t any = std::hash<std::string>{}(GetParam().name + fault.kind);
            const long at = tries == 1
                                ? 1 + static_cast<long>(any % static_cast<std::size_t>(calls))
                                : 1 + k * (calls - 1) / (tries - 1);
            try_one(fault, at);
        }
    }

    /// `delay` is a part of how long the command takes by itself.
    void kill_after(std::chrono::microseconds delay) {
        bench().reset(GetParam());
        const Outcome outcome = run_and_kill(bench().work(), GetParam().arguments, delay);
        const Files now = files_below(bench().work());
        Count& count = table()[GetParam().name];
        ++count.at_any_moment;
        count.too_early += now == before_ ? 1 : 0;
        std::string wrong;
        if (now != before_ && now != after_ && !GetParam().goes_on) {
            wrong = "is mixed: " + difference(now);
        }
        if (wrong.empty()) wrong = judge_next();
        EXPECT_EQ(wrong, "") << GetParam().name << " killed after " << delay.count() << " us";
    }

  private:
    /// Also of a sample all, where one call of many was what mattered: between two renames, and of
    /// one mesh among others; and many where a point of a sweep was saved.
    static long tries_of(const Fault& fault) {
        const std::string call = fault.call;
        if (call == "memory") return std::min(tries_per_kind(), 100L);
        if (call == "stat" && GetParam().arguments[1] == "sweep") {
            return std::max(tries_per_kind(), 60L);
        }
        const bool is_decisive = (call == "rename" && std::string(fault.kind) == "kill") ||
                                 (call == "stat" && GetParam().arguments[1] == "extract");
        return is_decisive ? std::numeric_limits<long>::max() : tries_per_kind();
    }
    /// Where the output of an earlier try may be there already the next one has to be allowed to
    /// replace it; without, it has to go without --force.
    Arguments next_command() const {
        Arguments arguments = GetParam().arguments;
        const bool is_done = files_below(bench().work()) == after_;
        const bool is_forced = arguments.back() == "--force";
        const bool is_resumable = GetParam().goes_on && arguments[1] != "sweep";
        if (is_resumable && !is_forced) {
            if (arguments.back() != "--resume") arguments.emplace_back("--resume");
        } else if (is_done && !is_forced && arguments[1] != "sweep") {
            arguments.emplace_back("--force");
        }
        return arguments;
    }

    void try_one(const Fault& fault, long at) {
        bench().reset(GetParam());
        const std::string text = fmt::format("{}:{}:{}", fault.call, fault.kind, at);
        std::string report;
        const Outcome outcome = run_with_fault(bench().work(), GetParam().arguments, text, report);
        if (report.empty() && std::string(fault.kind) != "full")
            return;  // made fewer calls this time
        std::string wrong = judge(fault, outcome);
        Count& count = table()[GetParam().name];
        ++count.tries;
        count.killed += outcome.signal == SIGKILL ? 1 : 0;
        count.refused += outcome.signal == 0 && outcome.code != 0 ? 1 : 0;
        count.harmless += outcome.code == 0 ? 1 : 0;
        if (wrong.empty()) wrong = judge_next();
        EXPECT_EQ(wrong, "") << GetParam().name << " " << text << " " << report << outcome.err;
    }

    std::string difference(const Files& now) const {
        std::string text;
        std::set<std::string> names;
        for (const Files* files : {&before_, &after_, &now}) {
            for (const auto& [name, content] : *files) names.insert(name);
        }
        for (const std::string& name : names) {
            const auto of = [&](const Files& files) {
                const auto found = files.find(name);
                return found == files.end() ? std::string("none") : found->second;
            };
            if (of(now) == of(after_) && of(now) == of(before_)) continue;
            text += fmt::format("{} is {}; ", name,
                                of(now) == of(after_)    ? "new"
                                : of(now) == of(before_) ? "old"
                                                         : "neither");
        }
        return text;
    }
    /// By a name that nothing else in a message looks like: not "Input/output", "without", "many".
    static bool names_a_file(const std::string& err) {
        static const std::regex name(
            "(^|[^a-z])((features|many|config|fit|sweep)\\.[a-z]|(out|meshes|trained)[./:'-]|"
            "(out|trained)( (is|has|was|holds)|$)|work: )");
        return std::regex_search(std::regex_replace(err, std::regex("Input/output error"), ""),
                                 name);
    }

    Files before_, after_;
    std::map<std::string, long> counts_;
};

TEST_P(Faults, LeaveTheOldOrTheNewAndNothingElse) {
    for (const Fault& fault : kFaults) try_all(fault);
}

INSTANTIATE_TEST_SUITE_P(Every, Faults, testing::ValuesIn(writing_commands()),
                         [](const auto& command) { return command.param.name; });

class Kills : public Faults {};

// Half of the moments lie in the first third, where little is there to go on from.
TEST_P(Kills, AtAnyMomentAreMendedByTheNextStart) {
    using namespace std::chrono;
    bench().reset(GetParam());
    const auto begin = steady_clock::now();
    ASSERT_EQ(run(bench().work(), GetParam().arguments).code, 0);
    const auto whole = duration_cast<microseconds>(steady_clock::now() - begin);
    std::mt19937 random(1);
    for (int k = 0; k < kills_per_command(); ++k) {
        const double end = k % 2 == 0 ? 1.0 / 3 : 1.0;
        const double part = std::uniform_real_distribution(0.0, end)(random);
        kill_after(duration_cast<microseconds>(part * whole));
    }
}

std::vector<WritingCommand> long_commands() {
    std::vector<WritingCommand> all = writing_commands();
    std::erase_if(all, [](const WritingCommand& command) {
        const std::string& verb = command.arguments[1];
        return verb != "train" && verb != "sweep" && verb != "extract" &&
               verb != "export-components" && verb != "refine";
    });
    return all;
}

INSTANTIATE_TEST_SUITE_P(Every, Kills, testing::ValuesIn(long_commands()),
                         [](const auto& command) { return command.param.name; });

/// Prints what was tried, as docs/testing.md has it.
class Table : public testing::Environment {
  public:
    void TearDown() override {
        for (const auto& [name, count] : table()) {
            std::cout << fmt::format("| {} | {} | {} | {} | {} | {} | {} |\n", name, count.tries,
                                     count.refused, count.harmless, count.killed,
                                     count.at_any_moment, count.too_early);
        }
    }
};
const testing::Environment* const kTable = testing::AddGlobalTestEnvironment(new Table);

}  // namespace
}  // namespace mscomp::faults
