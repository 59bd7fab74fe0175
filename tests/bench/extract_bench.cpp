// SPDX-License-Identifier: MIT
// Extraction from OBJ files to a feature file against the loop that one writes first
// (plain_extraction.h), and its stages one by one. What both give is compared before anything is
// timed.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "acap/deformation_gradient.h"
#include "acap/polar.h"
#include "acap/shape_extraction.h"
#include "acap/turns/consistency.h"
#include "base/temporary_folder.h"
#include "mscomp/acap/alignment.h"
#include "mscomp/acap/feature_file.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/acap/mesh/shape_source.h"
#include "mscomp/base/parallel.h"
#include "mscomp/base/random.h"
#include "mscomp/generate/generate.h"
#include "plain_extraction.h"

namespace mscomp {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// A sequence on disk, and a folder for what is made of it; removed at the end.
struct Files {
    TemporaryFolder folder;
    std::vector<std::string> paths;
};

const Files& files_of(const std::string& name) {
    static std::map<std::string, Files> all;
    Files& files = all[name];
    if (!files.paths.empty()) return files;
    if (name == "horse") {
        files.paths = expand_inputs({MSCOMP_SHARED_DIR "/data/horse"});
        return files;
    }
    const GeneratedSequence generated = generate_arm(49, 0, 8431);
    for (std::size_t n = 0; n < generated.sequence.shapes.size(); ++n) {
        files.paths.push_back(files.folder / fmt::format("{:04}.obj", n));
        write_mesh(files.paths.back(), {generated.sequence.shapes[n], generated.sequence.faces});
    }
    return files;
}

FeatureSet extract(const Files& files, int threads) {
    set_thread_count(threads);
    const MeshFiles shapes(files.paths);
    const std::vector<Point> reference = shapes.shape(0);
    FeatureFileWriter file(files.folder / "ours.safetensors", feature_outline(shapes, reference));
    FeatureSet set = extract_features(shapes, reference, {}, file);
    file.finish(set);
    set_thread_count(0);
    return set;
}

// ------------------------------------------------------------------------------------------------
// The same result

Matrix3d exp_of(const float* r) {
    const Vector3d vector(r[0], r[1], r[2]);
    const double angle = vector.norm();
    if (!(angle > 0)) return Matrix3d::Identity();
    return Eigen::AngleAxisd(angle, vector / angle).toRotationMatrix();
}

double difference(const float* ours, const float* plain) {
    double largest = (exp_of(ours) - exp_of(plain)).cwiseAbs().maxCoeff();
    for (int k = 3; k < kFeatureDim; ++k) {
        const double error = std::abs(double{ours[k]} - double{plain[k]});
        if (!(error <= largest)) largest = error;
    }
    return largest;
}

/// Throws unless S and exp(r) agree to 1e-5 and no energy of ours is above the other.
void compare(const FeatureSet& ours, const std::vector<double>& plain_energies,
             const Files& files) {
    const FeatureSet file = read_features(files.folder / "ours.safetensors");
    const std::string bytes = TemporaryFolder::content(files.folder / "plain.f32");
    if (bytes.size() != file.features.size() * sizeof(float)) {
        throw std::runtime_error("another number of features");
    }
    std::vector<float> plain(file.features.size());
    std::memcpy(plain.data(), bytes.data(), bytes.size());
    for (std::size_t i = 0; i < plain.size(); i += kFeatureDim) {
        const double error = difference(file.features.data() + i, plain.data() + i);
        if (!(error <= 1e-5)) {
            const auto width = static_cast<std::size_t>(file.vertex_count()) * kFeatureDim;
            throw std::runtime_error(fmt::format("shape {}, vertex {}: features differ by {}",
                                                 i / width, i % width / kFeatureDim, error));
        }
    }
    for (std::size_t n = 0; n < plain_energies.size(); ++n) {
        const double energy = ours.consistency_energy[n];
        if (!(energy <= plain_energies[n] * (1 + 1e-6) + 1e-9)) {
            throw std::runtime_error(fmt::format("shape {}: energy {}, by the plain loop {}", n,
                                                 energy, plain_energies[n]));
        }
    }
}

// ------------------------------------------------------------------------------------------------
// From files to file

struct Seconds {
    double wall, processor;
};

Seconds seconds_of(const std::function<void()>& work) {
    const auto processor = [] {
        timespec now{};
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
        return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
    };
    const auto start = std::chrono::steady_clock::now();
    const double processor_start = processor();
    work();
    return {std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(),
            processor() - processor_start};
}

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// The three in turn, again and again; the counters are medians, the ratios those of each turn.
void files_to_file(benchmark::State& state, const std::string& name) {
    const Files& files = files_of(name);
    const std::string output = files.folder / "plain.f32";
    try {
        compare(extract(files, 1), plain::extract(files.paths, output), files);
    } catch (const std::exception& error) {
        state.SkipWithError(error.what());
        return;
    }
    std::map<std::string, std::vector<double>> numbers;
    for (auto _ : state) {
        const Seconds plain = seconds_of([&] { plain::extract(files.paths, output); });
        numbers["plain_seconds"].push_back(plain.wall);
        numbers["plain_cpu_seconds"].push_back(plain.processor);
        for (const int threads : {1, 2}) {
            const Seconds ours = seconds_of([&] { extract(files, threads); });
            const std::string what = fmt::format("{}_threads_", threads);
            numbers[what + "seconds"].push_back(ours.wall);
            numbers[what + "cpu_seconds"].push_back(ours.processor);
            numbers[what + "times_faster"].push_back(plain.wall / ours.wall);
            numbers[what + "times_less_cpu"].push_back(plain.processor / ours.processor);
        }
    }
    for (const auto& [what, values] : numbers) state.counters[what] = median(values);
    state.counters["shapes"] = static_cast<double>(files.paths.size());
}

// ------------------------------------------------------------------------------------------------
// Polar decomposition

/// As the ones of a deformed body: a rotation times a stretch by up to a half each way.
std::vector<Matrix3d> some_gradients() {
    const CounterRandom random(3, 1);
    std::uint64_t draw = 0;
    const auto next = [&] { return 2 * random.uniform(draw++) - 1; };
    std::vector<Matrix3d> gradients(4096);
    for (Matrix3d& gradient : gradients) {
        const Vector3d axis = Vector3d(next(), next(), next()).normalized();
        Matrix3d stretch = Matrix3d::Identity();
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j <= i; ++j) stretch(i, j) = stretch(j, i) = (i == j) + 0.25 * next();
        }
        gradient = Eigen::AngleAxisd(3.14 * next(), axis) * stretch;
    }
    return gradients;
}

PolarDecomposition polar_by_jacobi_svd(const Matrix3d& gradient) {
    const Eigen::JacobiSVD<Matrix3d> svd(gradient, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Matrix3d u = svd.matrixU();
    const bool mirrored = u.determinant() * svd.matrixV().determinant() < 0;
    if (mirrored) u.col(2) *= -1;
    PolarDecomposition result{u * svd.matrixV().transpose(), {}, mirrored};
    const Matrix3d stretch = result.rotation.transpose() * gradient;
    result.stretch = 0.5 * (stretch + stretch.transpose());
    return result;
}

using Decompose = void (*)(std::span<const Matrix3d>, std::span<PolarDecomposition>);

void all_by_jacobi_svd(std::span<const Matrix3d> gradients, std::span<PolarDecomposition> results) {
    for (std::size_t i = 0; i < results.size(); ++i) results[i] = polar_by_jacobi_svd(gradients[i]);
}

void all_one_by_one(std::span<const Matrix3d> gradients, std::span<PolarDecomposition> results) {
    for (std::size_t i = 0; i < results.size(); ++i) results[i] = polar_decomposition(gradients[i]);
}

void polar(benchmark::State& state, Decompose decompose) {
    const std::vector<Matrix3d> gradients = some_gradients();
    std::vector<PolarDecomposition> results(gradients.size());
    decompose(gradients, results);
    double largest = 0;
    for (std::size_t i = 0; i < gradients.size(); ++i) {
        const PolarDecomposition wanted = polar_by_jacobi_svd(gradients[i]);
        largest = std::max({largest, (results[i].rotation - wanted.rotation).cwiseAbs().maxCoeff(),
                            (results[i].stretch - wanted.stretch).cwiseAbs().maxCoeff()});
    }
    if (!(largest <= 1e-13)) return state.SkipWithError("not the result of the SVD");
    for (auto _ : state) {
        decompose(gradients, results);
        benchmark::DoNotOptimize(results.data());
        benchmark::ClobberMemory();
    }
    state.counters["difference"] = largest;
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(gradients.size()));
}

BENCHMARK_CAPTURE(polar, jacobi_svd, all_by_jacobi_svd);
BENCHMARK_CAPTURE(polar, one_by_one, all_one_by_one);
BENCHMARK_CAPTURE(polar, several_at_a_time, polar_decompositions);

// ------------------------------------------------------------------------------------------------
// The stages one by one, on one thread and in memory: items are vertices

struct Stages {
    explicit Stages(const Files& input)
        : files(input.paths),
          gradients({files.shape(0), files.faces()}, EdgeWeights::cotangent),
          graph(consistency_graph(gradients.rings(),
                                  std::vector<double>(static_cast<std::size_t>(vertices()), 0.0))) {
        for (int n = 0; n < files.shape_count(); ++n) {
            shapes.push_back(files.shape(n));
            aligned.push_back(align(shapes.back()));
            rows.push_back(extract_shape(gradients, aligned.back()).features);
        }
    }
    int vertices() const { return files.vertex_count(); }
    std::vector<Point> align(const std::vector<Point>& shape) const {
        return moved(shape, best_rigid_motion(shape, shapes.front()));
    }

    MeshFiles files;
    DeformationGradients gradients;
    ConsistencyGraph graph;
    std::vector<std::vector<Point>> shapes, aligned;
    std::vector<std::vector<float>> rows;  // with principal logarithms
};

const Stages& stages_of(const std::string& name) {
    static std::map<std::string, Stages> all;
    return all.try_emplace(name, files_of(name)).first->second;
}

template <class Work>
void stage(benchmark::State& state, const Stages& stages, Work&& work) {
    set_thread_count(1);
    for (auto _ : state) {
        for (int n = 0; n < stages.files.shape_count(); ++n) {
            benchmark::DoNotOptimize(work(stages, n));
        }
    }
    set_thread_count(0);
    state.SetItemsProcessed(state.iterations() * stages.vertices() * stages.files.shape_count());
}

std::vector<Matrix3d> gradients_only(const Stages& stages, std::size_t n) {
    return stages.gradients.compute(stages.aligned[n]).gradients;
}

/// Least squares per vertex and shape, from nothing but the two meshes and the weights.
std::vector<Matrix3d> plain_gradients(const Stages& stages, std::size_t n) {
    const std::vector<Point>& before = stages.shapes.front();
    const std::vector<Point>& after = stages.aligned[n];
    const OneRings& rings = stages.gradients.rings();
    const auto& faces = stages.files.faces();
    const RingNormals normals_before =
        ring_normals(before, faces, stages.gradients.mesh().faces_around(), rings);
    const RingNormals normals_after =
        ring_normals(after, faces, stages.gradients.mesh().faces_around(), rings);
    std::vector<Matrix3d> result(before.size());
    for (std::size_t i = 0; i < before.size(); ++i) {
        const Vector3d n_before = normals_before.height[i] * normals_before.normal[i];
        Matrix3d moment = n_before * n_before.transpose();
        Matrix3d image = normals_after.height[i] * normals_after.normal[i] * n_before.transpose();
        for (int at = rings.offsets[i]; at < rings.offsets[i + 1]; ++at) {
            const auto k = static_cast<std::size_t>(at);
            const auto j = static_cast<std::size_t>(rings.neighbors[k]);
            const Vector3d e = as_vector(before[j]) - as_vector(before[i]);
            const Vector3d f = as_vector(after[j]) - as_vector(after[i]);
            moment += stages.gradients.weights()[k] * e * e.transpose();
            image += stages.gradients.weights()[k] * f * e.transpose();
        }
        result[i] = image * moment.inverse();
    }
    return result;
}

void gradients_by_plain_loop(benchmark::State& state, const std::string& name) {
    const Stages& stages = stages_of(name);
    for (std::size_t n = 0; n < stages.shapes.size(); ++n) {
        const std::vector<Matrix3d> wanted = plain_gradients(stages, n);
        const std::vector<Matrix3d> ours = gradients_only(stages, n);
        for (std::size_t i = 0; i < ours.size(); ++i) {
            const double error = (ours[i] - wanted[i]).cwiseAbs().maxCoeff();
            if (!(error <= 1e-9 * (1 + wanted[i].cwiseAbs().maxCoeff()))) {
                return state.SkipWithError("other gradients");
            }
        }
    }
    stage(state, stages,
          [](const Stages& s, int n) { return plain_gradients(s, static_cast<std::size_t>(n)); });
}

void register_stages(const std::string& name) {
    const auto add = [&](const char* what, auto work) {
        benchmark::RegisterBenchmark(
            fmt::format("{}/{}", what, name).c_str(),
            [name, work](benchmark::State& state) { stage(state, stages_of(name), work); })
            ->Unit(benchmark::kMillisecond);
    };
    benchmark::RegisterBenchmark(("gradients_by_plain_loop/" + name).c_str(),
                                 gradients_by_plain_loop, name)
        ->Unit(benchmark::kMillisecond);
    add("gradients", [](const Stages& stages, int n) {
        return gradients_only(stages, static_cast<std::size_t>(n));
    });
    add("reading", [](const Stages& stages, int n) { return stages.files.shape(n); });
    add("alignment", [](const Stages& stages, int n) {
        return stages.align(stages.shapes[static_cast<std::size_t>(n)]);
    });
    add("alignment_to_features", [](const Stages& stages, int n) {
        const auto& shape = stages.shapes[static_cast<std::size_t>(n)];
        return extract_shape(stages.gradients, stages.align(shape)).features;
    });
    add("consistency", [](const Stages& stages, int n) {
        std::vector<Vector3d> r = rotation_vectors_of(stages.rows[static_cast<std::size_t>(n)]);
        return make_consistent(stages.graph, r).energy;
    });
}

}  // namespace
}  // namespace mscomp

int main(int argc, char** argv) {
    using namespace mscomp;
    std::vector<std::string> names{"arm"};
    if (std::filesystem::exists(MSCOMP_SHARED_DIR "/data/horse")) names.push_back("horse");
    for (const std::string& name : names) {
        benchmark::RegisterBenchmark(("files_to_file/" + name).c_str(), files_to_file, name)
            ->Iterations(7)
            ->Unit(benchmark::kMillisecond)
            ->UseRealTime();
    }
    for (const std::string& name : names) register_stages(name);
    benchmark::Initialize(&argc, argv);
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}
