// SPDX-License-Identifier: MIT
// docs/messages.md and what the programs say.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string>
#include <vector>

#include "base/temporary_folder.h"
#include "docs/message_table.h"
#include "mscomp/base/atomic_file.h"

namespace mscomp {
namespace {

const std::string kRoot = std::string(MSCOMP_TESTS_DIR) + "/..";

std::vector<DocumentedMessage> page() {
    return documented_messages(read_file(kRoot + "/docs/messages.md"));
}

const std::string kVertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
const std::string kFaces = "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

class MessagesPage : public testing::Test {
  protected:
    MessagesPage() {
        folder_.put("a.obj", kVertices + kFaces);
        folder_.put("b.obj", "v 0 0 0\nv 2 0 0\nv 0 1 0\nv 0 0 1\n" + kFaces);
        folder_.put("set/a.obj", kVertices + kFaces);
        folder_.put("nan.obj", "v 0 nan 0\n" + kVertices + kFaces);
        folder_.put("comma.obj", "v 0,5 1 0\n" + kVertices + kFaces);
        folder_.put("short.obj", "v 0 1\n" + kVertices + kFaces);
        folder_.put("index.obj", kVertices + "f 1 2 9\n");
        folder_.put("word.obj", "# x\nhello\n");
        folder_.put("points.obj", kVertices);
        folder_.put("more.obj", kVertices + "v 1 1 1\n" + kFaces);
        folder_.put("other.obj", kVertices + "f 1 2 3\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
        folder_.put("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
        folder_.put("empty.obj", "");
        folder_.put("mesh.stl", "solid\n");
        folder_.put("a.ply", "plx\n");
        folder_.put("a.off", "OFF\n3 900 0\n0 0 0\n");
        folder_.put("a.npy", "no array");
        folder_.put("a.npz", "no archive");
        folder_.put("a.safetensors", "text");
        folder_.put("handles.json", R"({"handles": [{"vertex": 9, "position": [0, 0, 0]}]})");
        folder_.put("LOGRNEW_x.txt", "1 2 3\n");
        folder_.put("S_x.txt", "1 2 3\n");
        folder_.put("key.yaml", "train:\n  epoch: 3\n");
        folder_.put("twice.yaml", "train:\n  epochs: 3\n  epochs: 4\n");
    }

    /// What a command in the folder prints on standard error, where it has to fail with `code`.
    std::string complaint(const std::string& command, int code) const {
        const std::string line =
            "cd '" + folder_.path() + "' && " + MSCOMP_BIN_DIR + "/" + command + " >out 2>err";
        const int status = std::system(line.c_str());
        EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == code) << command;
        return read_file(folder_ / "err");
    }

    TemporaryFolder folder_;
};

struct WrongCommand {
    std::string command;
    int code;
};

const std::vector<WrongCommand> kWrongCommands{
    {"acapfeat", 2},
    {"acapfeat extract a.obj", 2},
    {"acapfeat extract a.obj -o f --weight x", 2},
    {"acapfeat extract a.obj -o f --weights x", 2},
    {"acapfeat extract a.obj -o f --threads -1", 2},
    {"acapfeat extract a.obj -o b.obj", 2},
    {"acapfeat extract a.obj -o set", 2},
    {"acapfeat extract nowhere -o f", 2},
    {"acapfeat extract 'nowhere*.obj' -o f", 2},
    {"acapfeat extract a.obj ./a.obj -o f", 2},
    {"acapfeat extract -o f", 2},
    {"acapfeat extract a.obj -o f --reference 5", 2},
    {"acapfeat extract nan.obj -o f", 3},
    {"acapfeat extract comma.obj -o f", 3},
    {"acapfeat extract short.obj -o f", 3},
    {"acapfeat extract index.obj -o f", 3},
    {"acapfeat extract word.obj -o f", 3},
    {"acapfeat extract points.obj -o f", 3},
    {"acapfeat extract a.obj more.obj -o f", 3},
    {"acapfeat extract a.obj other.obj -o f", 3},
    {"acapfeat extract flat.obj -o f", 3},
    {"acapfeat extract empty.obj -o f", 3},
    {"acapfeat extract mesh.stl -o f", 3},
    {"acapfeat extract a.ply -o f", 3},
    {"acapfeat extract a.off -o f", 3},
    {"acapfeat extract --list nowhere.txt -o f", 4},
    {"acapfeat check a.obj nan.obj", 3},
    {"acapfeat info a.safetensors", 3},
    {"acapfeat info nowhere.safetensors", 4},
    {"acapfeat reconstruct a.safetensors -o set", 2},
    {"acapfeat reconstruct a.safetensors -o d --solver poisson --handles handles.json", 2},
    {"acapfeat generate arm -o d --turns 2", 2},
    {"acapfeat generate arm -o d --frames 1", 2},
    {"acapfeat generate twist -o d --turns 900", 2},
    {"acapfeat generate twist -o d --tilt 100", 2},
    {"acapfeat convert set f.xyz", 2},
    {"acapfeat convert set f.safetensors", 2},
    {"acapfeat convert a.npy d", 3},
    {"acapfeat convert a.npz d", 3},
    {"acapfeat convert S_x.txt f.safetensors", 2},
    {"acapfeat convert LOGRNEW_x.txt f.safetensors --reference a.obj", 3},
    {"mscomp init x", 2},
    {"mscomp train key.yaml", 2},
    {"mscomp train twice.yaml", 2},
    {"mscomp train key.yaml --set train", 2},
    {"mscomp train nowhere.yaml", 4},
    {"mscomp info a.safetensors", 6}};

// Every wrong command prints a message that the page has under the exit code.
TEST_F(MessagesPage, HasWhatWrongCommandsPrint) {
    const std::vector<DocumentedMessage> messages = page();
    for (const auto& [command, code] : kWrongCommands) {
        const std::string printed = complaint(command, code);
        EXPECT_NE(printed.find(": error: "), std::string::npos) << command << "\n" << printed;
        const std::string bracketed = "(" + std::to_string(code) + ")";
        const bool is_there = std::ranges::any_of(messages, [&](const DocumentedMessage& message) {
            return message.section.find(bracketed) != std::string::npos &&
                   matches(message, printed);
        });
        EXPECT_TRUE(is_there) << "docs/messages.md lacks under " << bracketed << ": " << printed;
    }
}

// Words that hardly anything but a message has.
bool looks_like_a_message(const std::string& text) {
    constexpr std::array<const char*, 12> kWords{
        "wanted", "expected",    "cannot", "truncated", "damaged",  "nothing was",
        "has no", "interrupted", "is not", "are not",   "excludes", "already"};
    return std::ranges::any_of(
        kWords, [&](const char* word) { return text.find(word) != std::string::npos; });
}

// The findings of check and their advice have a page of their own.
bool is_finding(const std::string& file) { return file.find("/acap/check") != std::string::npos; }

TEST(MessagesOfTheSources, AreOnThePage) {
    const std::vector<DocumentedMessage> messages = page();
    int checked = 0;
    for (const SourceLiteral& literal : source_literals(kRoot + "/src")) {
        if (!looks_like_a_message(literal.text) || is_finding(literal.file)) continue;
        std::string_view core = longest(literal.parts);
        for (const std::string_view before : {"acapfeat: warning: ", "acapfeat: note: "}) {
            if (core.starts_with(before)) core.remove_prefix(before.size());
        }
        if (core.size() < 8) continue;
        ++checked;
        const bool is_there = std::ranges::any_of(messages, [&](const DocumentedMessage& message) {
            return std::ranges::any_of(message.literal, [&](const std::string& part) {
                return part.find(core) != std::string::npos;
            });
        });
        EXPECT_TRUE(is_there) << "docs/messages.md lacks \"" << literal.text << "\" of "
                              << literal.file;
    }
    EXPECT_GT(checked, 150);
}

// Messages of the parser of command lines, whose sources are not ours.
bool is_of_the_parser(const DocumentedMessage& message) {
    constexpr std::array<std::string_view, 6> kParts{
        "A subcommand is required", " is required", "not expected: ", " not in ", " not in range",
        "Could not convert: "};
    return message.text == "--solver excludes --handles" ||
           std::ranges::any_of(kParts, [&](std::string_view part) {
               return message.text.find(part) != std::string::npos;
           });
}

/// How much of a part is made of pieces of literals.
std::size_t covered(std::string_view part, const std::vector<SourceLiteral>& literals) {
    std::vector<char> is_covered(part.size(), 0);
    for (const SourceLiteral& literal : literals) {
        for (const std::string& whole : literal.parts) {
            const std::string_view piece = trimmed(whole);
            if (piece.size() < 6) continue;
            const std::size_t at = part.find(piece);
            if (at != std::string_view::npos)
                std::fill_n(is_covered.begin() + static_cast<std::ptrdiff_t>(at), piece.size(), 1);
            if (piece.find(part) != std::string_view::npos) return part.size();
        }
    }
    return static_cast<std::size_t>(std::ranges::count(is_covered, 1));
}

// A message that nothing prints any more goes.
TEST(MessagesPageItself, HasNothingThatNoSourceHas) {
    const std::vector<SourceLiteral> literals = source_literals(kRoot + "/src");
    for (const DocumentedMessage& message : page()) {
        if (is_of_the_parser(message)) continue;
        const std::string_view part = longest(message.literal);
        EXPECT_GE(5 * covered(part, literals), 3 * part.size())
            << "no source has \"" << message.text << "\"";
    }
}

}  // namespace
}  // namespace mscomp
