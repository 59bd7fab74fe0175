// SPDX-License-Identifier: MIT
// Extraction of more than memory shall hold, and its interruption.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <thread>

#include "base/temporary_folder.h"
#include "mscomp/acap/feature_file.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "shapes.h"

namespace mscomp {
namespace {

using testing::ElementsAre;

constexpr int kFrames = 2400;

/// A sphere that a wave runs over.
TriangleMesh frame(const TriangleMesh& sphere, int number) {
    TriangleMesh mesh = sphere;
    for (Point& p : mesh.vertices) {
        const double scale = 1 + 0.2 * std::sin(4 * p[2] + 0.05 * number);
        for (double& coordinate : p) coordinate *= scale;
    }
    return mesh;
}

/// Frames of 2562 vertices, which make features of 295 MB, in a folder "in". Only one in twenty is
/// a file of its own, the others are links.
void write_frames(const TemporaryFolder& folder) {
    const TriangleMesh sphere = shapes::icosphere(4);
    std::filesystem::create_directories(folder / "in");
    const auto name = [&](int number) {
        return folder / ("in/frame_" + std::to_string(number) + ".ply");
    };
    for (int number = 0; number < kFrames; ++number) {
        const int original = number % (kFrames / 20);
        if (number == original) {
            write_ply(name(number), frame(sphere, number));
        } else {
            std::filesystem::create_hard_link(name(original), name(number));
        }
    }
}

/// The program in a process of its own, in `folder`.
class Extraction {
  public:
    explicit Extraction(const TemporaryFolder& folder) : id_(::fork()) {
        if (id_ != 0) return;
        const int nowhere = ::open("/dev/null", O_RDWR);
        ::dup2(nowhere, STDOUT_FILENO);
        ::dup2(nowhere, STDERR_FILENO);
        const std::string program = std::string(MSCOMP_BIN_DIR) + "/acapfeat";
        if (::chdir(folder.path().c_str()) != 0) ::_exit(99);
        ::execl(program.c_str(), "acapfeat", "extract", "in", "-o", "f.safetensors", "--threads",
                "2", nullptr);
        ::_exit(99);
    }
    void send(int signal) const { ::kill(id_, signal); }
    /// Waits for the end. Its exit code and the most memory it ever had.
    std::pair<int, std::int64_t> end() const {
        int status = 0;
        rusage usage{};
        EXPECT_EQ(::wait4(id_, &status, 0, &usage), id_);
        EXPECT_TRUE(WIFEXITED(status));
        return {WEXITSTATUS(status), usage.ru_maxrss * std::int64_t{1024}};
    }

  private:
    pid_t id_;
};

TEST(AcapfeatStreaming, MemoryDoesNotGrowWithTheNumberOfShapes) {
    const TemporaryFolder folder;
    write_frames(folder);
    const auto [code, peak] = Extraction(folder).end();
    EXPECT_EQ(code, 0);
    const auto size =
        static_cast<std::int64_t>(std::filesystem::file_size(folder / "f.safetensors"));
    EXPECT_GT(size, 290'000'000);
    EXPECT_LT(peak, size / 4);
    const FeatureFile file(folder / "f.safetensors");
    EXPECT_EQ(file.shape_count(), kFrames);
    EXPECT_EQ(file.vertex_count(), 2562);
}

TEST(AcapfeatStreaming, InterruptedAtAnyTimeItLeavesNothing) {
    const TemporaryFolder folder;
    write_frames(folder);
    for (const int milliseconds : {0, 300, 1500}) {
        for (const int signal : {SIGINT, SIGTERM}) {
            const Extraction extraction(folder);
            while (folder.names().size() < 2) {  // until the temporary file is there
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
            extraction.send(signal);
            EXPECT_EQ(extraction.end().first, 128 + signal);
            EXPECT_THAT(folder.names(), ElementsAre("in"));
        }
    }
}

}  // namespace
}  // namespace mscomp
