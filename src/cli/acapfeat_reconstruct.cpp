// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <filesystem>
#include <memory>
#include <optional>

#include "acapfeat_commands.h"
#include "mscomp/acap/feature_file.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/acap/reconstruct.h"
#include "mscomp/base/error.h"
#include "mscomp/cli/interrupt.h"
#include "mscomp/cli/outputs.h"
#include "mscomp/cli/progress.h"
#include "mscomp/cli/shape_files.h"

namespace mscomp {
namespace {

void require_solver(const std::string& solver) {
    if (solver == "poisson") return;
    if (solver == "lossless") {
        throw UsageError("--solver lossless is not available in this version; use poisson");
    }
    throw UsageError(fmt::format("--solver: got {}, wanted poisson", solver));
}

// Undoes the alignment of extraction: input = rotation^T (aligned - translation).
std::vector<Point> unaligned(std::vector<Point> positions, const std::array<double, 9>& rotation,
                             const std::array<double, 3>& translation) {
    for (Point& position : positions) {
        const Point moved = position;
        for (std::size_t column = 0; column < 3; ++column) {
            position[column] = 0;
            for (std::size_t row = 0; row < 3; ++row) {
                position[column] += rotation[3 * row + column] * (moved[row] - translation[row]);
            }
        }
    }
    return positions;
}

}  // namespace

void setup_reconstruct(CLI::App& app) {
    const auto options = std::make_shared<ReconstructCommand>();
    CLI::App* command = app.add_subcommand("reconstruct", "Meshes from ACAP features");
    command->add_option("FEATURES", options->features, "Feature file")->required();
    command->add_option("-o,--output", options->output, "Folder to write the meshes to")
        ->required();
    command->add_option("--solver", options->solver, "How positions are found: poisson")
        ->capture_default_str();
    command
        ->add_option("--frames", options->frames,
                     "A:B for shapes A to B-1, counted from 0; either may be left out")
        ->capture_default_str();
    command->add_option("--format", options->format, "Format of the meshes")
        ->check(CLI::IsMember({"obj", "ply"}))
        ->capture_default_str();
    command->add_flag("--aligned", options->keep_aligned,
                      "Leave shapes aligned to the reference instead of where the input stood");
    add_force(*command, options->common);
    add_quiet(*command, options->common);
    add_threads(*command, options->common);
    set_example(*command, "acapfeat reconstruct swing.safetensors -o meshes --frames 0:10");
    command->callback([options] { run_reconstruct(*options); });
}

void run_reconstruct(const ReconstructCommand& options) {
    require_solver(options.solver);
    require_free_folder(options.output, options.common.force);
    const FeatureSet set = read_features(options.features);
    const ShapeRange range = parse_shape_range(options.frames, set.shape_count());
    const std::vector<std::string> names = shape_file_names(set.names);
    const PoissonReconstruction poisson(set.reference, parse_edge_weights(set.weights));
    create_folder(options.output);
    Progress progress("reconstruct", range.size(), progress_options(options.common.quiet));
    for (int i = range.begin; i < range.end; ++i) {
        throw_if_interrupted(fmt::format("interrupted; {} of {} meshes are in {}", i - range.begin,
                                         range.size(), options.output));
        const auto index = static_cast<std::size_t>(i);
        TriangleMesh mesh{poisson.solve(set.shape(i)), set.reference.faces};
        if (!options.keep_aligned) {
            mesh.vertices =
                unaligned(std::move(mesh.vertices), set.rotation[index], set.translation[index]);
        }
        const std::string path =
            fmt::format("{}/{}.{}", options.output, names[index], options.format);
        if (options.format == "ply") {
            write_ply(path, mesh);
        } else {
            write_obj(path, mesh);
        }
        progress.update(i - range.begin + 1);
    }
    fmt::print("{}: {} meshes, {} vertices, {} faces\n", options.output, range.size(),
               set.vertex_count(), set.reference.face_count());
}

}  // namespace mscomp
