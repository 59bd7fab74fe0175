// SPDX-License-Identifier: MIT
// Megabytes a second of one core, parsing a mesh in memory: our readers and those of other
// libraries on the same text. What they give is compared before anything is timed.
#include <benchmark/benchmark.h>

#include <cmath>
#include <stdexcept>

#include "base/temporary_folder.h"
#include "mesh/generated_meshes.h"
#include "mesh/other_readers.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/acap/mesh/mesh_sequence.h"
#include "mscomp/acap/mesh/shape_source.h"

namespace mscomp {
namespace {

constexpr int kNineDigits = 3;  // what most programs write
constexpr int kSeventeenDigits = 4;

/// A bumpy sphere of 10 * 4^levels + 2 vertices.
GeneratedMesh bumpy_sphere(int levels) {
    GeneratedMesh mesh = of_triangles(shapes::icosphere(levels));
    for (Point& p : mesh.vertices) {
        const double size = 100 * (1 + 0.1 * std::sin(9 * p[0]) * std::cos(7 * p[1] + p[2]));
        for (double& x : p) x *= size;
    }
    return mesh;
}

/// Throws unless both have the same faces and vertices that agree to `tolerance`.
void compare(const TriangleMesh& expected, const OtherMesh& got, double tolerance) {
    if (got.vertices.size() != expected.vertices.size() ||
        got.faces.size() != expected.faces.size()) {
        throw std::runtime_error("another number of vertices or faces");
    }
    for (std::size_t i = 0; i < got.vertices.size(); ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
            const double x = expected.vertices[i][k];
            if (!(std::abs(x - got.vertices[i][k]) <= tolerance * std::abs(x))) {
                throw std::runtime_error("another coordinate");
            }
        }
    }
    for (std::size_t i = 0; i < got.faces.size(); ++i) {
        std::vector<int> face = got.faces[i];
        std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
        std::vector<int> wanted(expected.faces[i].begin(), expected.faces[i].end());
        std::rotate(wanted.begin(), std::min_element(wanted.begin(), wanted.end()), wanted.end());
        if (face != wanted) throw std::runtime_error("another face");
    }
}

OtherMesh as_other(const TriangleMesh& mesh) {
    OtherMesh result{mesh.vertices, {}};
    for (const Face& face : mesh.faces) result.faces.emplace_back(face.begin(), face.end());
    return result;
}

struct Input {
    std::string text;
    TriangleMesh mesh;  // as the text has it
};

Input obj_input(const benchmark::State& state) {
    const GeneratedMesh mesh = bumpy_sphere(static_cast<int>(state.range(0)));
    Input input{obj_text(mesh, static_cast<int>(state.range(1)), Corner::plain), {}};
    for (Point p : mesh.vertices) {
        for (double& x : p) {
            x = std::strtod(number_text(x, static_cast<int>(state.range(1))).c_str(), nullptr);
        }
        input.mesh.vertices.push_back(p);
    }
    for (const std::vector<int>& face : mesh.faces) {
        input.mesh.faces.push_back({face[0], face[1], face[2]});
    }
    return input;
}

/// Times `read(text)` after its result was compared with the mesh the text was made of.
template <class Read, class Compare>
void time_reader(benchmark::State& state, const Input& input, Read&& read, Compare&& check) {
    try {
        check(read(input.text));
    } catch (const std::exception& error) {
        state.SkipWithError(error.what());
        return;
    }
    for (auto _ : state) benchmark::DoNotOptimize(read(input.text));
    state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(input.text.size()));
    state.counters["vertices"] = static_cast<double>(input.mesh.vertices.size());
    state.counters["megabytes"] = static_cast<double>(input.text.size()) * 1e-6;
}

void obj_by_ours(benchmark::State& state) {
    const Input input = obj_input(state);
    time_reader(
        state, input, [](const std::string& text) { return parse_obj(text, "a.obj"); },
        [&](const TriangleMesh& mesh) { compare(input.mesh, as_other(mesh), 0); });
}

void obj_by_openmesh(benchmark::State& state) {
    const Input input = obj_input(state);
    time_reader(
        state, input, [](const std::string& text) { return parse_with_openmesh(text, ".obj"); },
        [&](const auto&) { compare(input.mesh, read_with_openmesh(input.text, ".obj"), 6e-8); });
}

#ifdef MSCOMP_WITH_TINYOBJLOADER
void obj_by_tinyobjloader(benchmark::State& state) {
    const Input input = obj_input(state);
    time_reader(
        state, input, [](const std::string& text) { return parse_with_tinyobjloader(text); },
        [&](const auto&) { compare(input.mesh, read_with_tinyobjloader(input.text), 2e-15); });
}
#endif

void off_by_ours(benchmark::State& state) {
    Input input = obj_input(state);
    input.text =
        off_text(bumpy_sphere(static_cast<int>(state.range(0))), static_cast<int>(state.range(1)));
    time_reader(
        state, input, [](const std::string& text) { return parse_off(text, "a.off"); },
        [&](const TriangleMesh& mesh) { compare(input.mesh, as_other(mesh), 0); });
}

void ply_text_by_ours(benchmark::State& state) {
    Input input = obj_input(state);
    input.text =
        ply_text(bumpy_sphere(static_cast<int>(state.range(0))), static_cast<int>(state.range(1)));
    time_reader(
        state, input, [](const std::string& text) { return parse_ply(text, "a.ply"); },
        [&](const TriangleMesh& mesh) { compare(input.mesh, as_other(mesh), 0); });
}

void ply_bytes_by_ours(benchmark::State& state) {
    Input input = obj_input(state);
    const GeneratedMesh mesh = bumpy_sphere(static_cast<int>(state.range(0)));
    input.text = ply_bytes(mesh, state.range(1) != 0);
    input.mesh.vertices = mesh.vertices;
    time_reader(
        state, input, [](const std::string& bytes) { return parse_ply(bytes, "a.ply"); },
        [&](const TriangleMesh& read) { compare(input.mesh, as_other(read), 0); });
}

/// From the file system (in its cache), compared with the faces of the first file; with 1, those
/// come in another order.
void file_of_a_sequence(benchmark::State& state) {
    GeneratedMesh mesh = bumpy_sphere(static_cast<int>(state.range(0)));
    const TemporaryFolder folder;
    std::vector<std::string> paths{folder.put("0.obj", obj_text(mesh, kNineDigits, Corner::plain))};
    if (state.range(1) != 0) {
        Polygons shuffled;
        for (const int i : CounterRandom(3, 0).permutation(static_cast<int>(mesh.faces.size()))) {
            shuffled.push_back(mesh.faces[static_cast<std::size_t>(i)]);
            std::rotate(shuffled.back().begin(), shuffled.back().begin() + i % 3,
                        shuffled.back().end());
        }
        mesh.faces = shuffled;
    }
    const std::string text = obj_text(mesh, kNineDigits, Corner::plain);
    paths.push_back(folder.put("1.obj", text));
    const MeshFiles files(paths);
    if (files.shape(1) != files.shape(0)) return state.SkipWithError("another shape");
    for (auto _ : state) benchmark::DoNotOptimize(files.shape(1));
    state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(text.size()));
    state.counters["faces"] = static_cast<double>(mesh.faces.size());
}

void texts(benchmark::internal::Benchmark* bench) {
    bench->ArgNames({"subdivisions", "spelling"})
        ->ArgsProduct({{5, 7}, {kNineDigits, kSeventeenDigits}})
        ->Unit(benchmark::kMillisecond);
}

BENCHMARK(obj_by_ours)->Apply(texts);
BENCHMARK(obj_by_openmesh)->Apply(texts);
#ifdef MSCOMP_WITH_TINYOBJLOADER
BENCHMARK(obj_by_tinyobjloader)->Apply(texts);
#endif
BENCHMARK(off_by_ours)->Apply(texts);
BENCHMARK(ply_text_by_ours)->Apply(texts);
BENCHMARK(ply_bytes_by_ours)
    ->ArgNames({"subdivisions", "big_endian"})
    ->ArgsProduct({{5, 7}, {0, 1}})
    ->Unit(benchmark::kMillisecond);
BENCHMARK(file_of_a_sequence)
    ->ArgNames({"subdivisions", "other_face_order"})
    ->ArgsProduct({{5, 8}, {0, 1}})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace mscomp

BENCHMARK_MAIN();
