// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "acapfeat_commands.h"
#include "cli/progress.h"
#include "cli/say.h"
#include "cli/shape_files.h"
#include "handle_file.h"
#include "mscomp/acap/feature_file.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/acap/reconstruct.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/interruption.h"
#include "mscomp/base/json_text.h"
#include "mscomp/base/kept_inputs.h"
#include "mscomp/base/output_folder.h"
#include "mscomp/base/outputs.h"
#include "mscomp/base/parallel.h"
#include "mscomp/eval/measures.h"

namespace mscomp {
namespace {

// Features of a mesh leave about 1e-7, the rounding of float32; averaged or predicted ones 1e-2.
constexpr double kNoMesh = 1e-5;

double seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
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

Point aligned(const Point& position, const std::array<double, 9>& rotation,
              const std::array<double, 3>& translation) {
    Point result = translation;
    for (std::size_t row = 0; row < 3; ++row) {
        for (std::size_t column = 0; column < 3; ++column) {
            result[row] += rotation[3 * row + column] * position[column];
        }
    }
    return result;
}

/// One shape on its W places, in the frame of the features.
struct Solved {
    std::vector<Point> input;  // the mesh the features were taken from
    ReconstructedShape shape;
    std::vector<Point> poisson;
    std::vector<Point> written;  // as who reads its file finds it
    double seconds = 0, poisson_seconds = 0;
};

/// What is told about all shapes together.
struct Summary {
    explicit Summary(const std::vector<Point>& reference)
        : rms_error(reference), poisson_rms_error(reference) {}

    RmsError rms_error, poisson_rms_error;
    double seconds = 0, poisson_seconds = 0;
    double residual_max = 0, residual_sum = 0;
    int residual_max_shape = -1;
    int without_mesh = 0;  // shapes with features that no mesh has
    int not_converged = 0;
};

class ShapeReconstruction {
  public:
    ShapeReconstruction(const ReconstructCommand& options, const FeatureFile& file)
        : options_(options),
          file_(file),
          set_(file.outline()),
          surface_(set_.places.surface(set_.reference)),
          poisson_(surface_, parse_edge_weights(set_.weights)) {
        if (options.solver == "lossless") {
            lossless_.emplace(surface_, parse_edge_weights(set_.weights));
        }
        if (!options.handles.empty()) {
            handles_ = on_places(read_handles(options.handles, set_.vertex_count()));
        }
    }

    bool is_lossless() const { return lossless_.has_value(); }

    /// Safe to call from several threads.
    Solved solve(int index) const {
        Solved solved;
        const std::vector<Point> vertices = points_of(file_.vertices(index));
        solved.input = set_.places.of_places(std::span(vertices));
        const std::vector<float> features = set_.places.of_places(file_.shape(index), kFeatureDim);
        const double start = seconds();
        solved.poisson = poisson_.solve(features, solved.input);
        const double between = seconds();
        solved.poisson_seconds = solved.seconds = between - start;
        if (!lossless_) {
            solved.shape.vertices = solved.poisson;
            return solved;
        }
        solved.shape = handles_.empty()
                           ? lossless_->solve(features, solved.input)
                           : lossless_->solve_by_ceres(features, handles_of(index), solved.input);
        solved.seconds = seconds() - between;
        return solved;
    }

    const TriangleMesh& surface() const { return surface_; }

    /// Writes all vertices: those without a face where the file has them.
    void write(int index, const std::string& path, Solved& solved) const {
        const auto n = at(index);
        std::vector<Point> positions = points_of(file_.vertices(index));
        set_.places.to_vertices(std::span<const Point>(solved.shape.vertices),
                                std::span(positions));
        if (!options_.keep_aligned) {
            positions = unaligned(std::move(positions), set_.rotation[n], set_.translation[n]);
        }
        const TriangleMesh mesh{std::move(positions), set_.reference.faces};
        write_mesh(path, mesh);
        const std::vector<Point> written = as_written(path, mesh);
        solved.written = set_.places.of_places(std::span(written));
        if (options_.keep_aligned) return;
        for (Point& point : solved.written) {
            point = aligned(point, set_.rotation[n], set_.translation[n]);
        }
    }

  private:
    std::vector<Handle> on_places(std::vector<Handle> handles) const {
        for (Handle& handle : handles) {
            const int place = set_.places.place(handle.vertex);
            if (place < 0) {
                throw UsageError(
                    fmt::format("--handles: vertex {} is in no face, so nothing would follow it",
                                handle.vertex));
            }
            handle.vertex = place;
        }
        return handles;
    }

    /// Handles are given where the meshes are written to.
    std::vector<Handle> handles_of(int index) const {
        std::vector<Handle> handles = handles_;
        const auto n = at(index);
        if (options_.keep_aligned) return handles;
        for (Handle& handle : handles) {
            handle.position = aligned(handle.position, set_.rotation[n], set_.translation[n]);
        }
        return handles;
    }

    const ReconstructCommand& options_;
    const FeatureFile& file_;
    const PlacedFeatures& set_;
    TriangleMesh surface_;  // the reference on its W places
    PoissonReconstruction poisson_;
    std::optional<LosslessReconstruction> lossless_;
    std::vector<Handle> handles_;
};

void add_to(Summary& summary, const Solved& solved, int index) {
    summary.rms_error.add(solved.input, solved.written);
    summary.poisson_rms_error.add(solved.input, solved.poisson);
    summary.seconds += solved.seconds;
    summary.poisson_seconds += solved.poisson_seconds;
    const double residual = solved.shape.residual;
    summary.residual_sum += residual;
    if (summary.residual_max_shape < 0 || residual > summary.residual_max) {
        summary.residual_max = residual;
        summary.residual_max_shape = index;
    }
    summary.without_mesh += residual > kNoMesh ? 1 : 0;
    summary.not_converged += solved.shape.converged ? 0 : 1;
}

Summary reconstruct_shapes(const ReconstructCommand& options, const FeatureFile& file,
                           const ShapeReconstruction& reconstruction, ShapeRange range) {
    const std::vector<std::string> names = shape_file_names(file.outline().names);
    OutputFolder output(options.output);
    Summary summary(reconstruction.surface().vertices);
    Progress progress("reconstruct", range.size(), progress_options(options.common.quiet));
    // Blocks keep the memory bounded and the sums in the order of the shapes.
    const int block = 4 * thread_count();
    for (int begin = range.begin; begin < range.end; begin += block) {
        throw_if_interrupted(fmt::format("interrupted; nothing was changed in {}", options.output));
        std::vector<Solved> solved(at(std::min(block, range.end - begin)));
        parallel_for(static_cast<std::int64_t>(solved.size()), [&](std::int64_t i) {
            const int index = begin + static_cast<int>(i);
            Solved& one = solved[at(i)];
            one = reconstruction.solve(index);
            reconstruction.write(index, output.path(names[at(index)] + "." + options.format), one);
        });
        for (std::size_t i = 0; i < solved.size(); ++i) {
            add_to(summary, solved[i], begin + static_cast<int>(i));
            file.forget(begin + static_cast<int>(i));
        }
        progress.update(begin - range.begin + static_cast<int>(solved.size()));
    }
    output.commit();
    return summary;
}

void print_summary(const ReconstructCommand& options, const FeatureSet& set, int count,
                   bool is_lossless, const Summary& summary) {
    const double per_shape = 1000 * summary.seconds / count;
    const double poisson_per_shape = 1000 * summary.poisson_seconds / count;
    if (options.common.json) {
        nlohmann::ordered_json json{{"folder", options.output},
                                    {"shapes", count},
                                    {"solver", options.solver},
                                    {"rms_error", summary.rms_error.value()},
                                    {"rms_error_poisson", summary.poisson_rms_error.value()},
                                    {"ms_per_shape", per_shape},
                                    {"ms_per_shape_poisson", poisson_per_shape}};
        if (is_lossless) {
            json["residual_mean"] = summary.residual_sum / count;
            json["residual_max"] = summary.residual_max;
            json["residual_max_shape"] = set.names[at(summary.residual_max_shape)];
            json["shapes_without_mesh"] = summary.without_mesh;
            json["shapes_not_converged"] = summary.not_converged;
        }
        print_lines(json_text(json, 2) + "\n");
        return;
    }
    print_out("{}: {} {}, {} vertices, {} faces\n", options.output, count,
              count == 1 ? "mesh" : "meshes", set.vertex_count(), set.reference.face_count());
    print_out("E_rms to the meshes in the file (x1000, unit ball): {:.3g}, {:.3g} ms a shape",
              summary.rms_error.value(), per_shape);
    if (!is_lossless) {
        print_out("\n");
        return;
    }
    print_out("; Poisson alone {:.3g}, {:.3g} ms\n", summary.poisson_rms_error.value(),
              poisson_per_shape);
    print_out("residual of the features: mean {:.2g}, largest {:.2g} in '{}'\n",
              summary.residual_sum / count, summary.residual_max,
              set.names[at(summary.residual_max_shape)]);
    if (options.common.quiet) return;
    if (summary.without_mesh > 0 && options.handles.empty()) {
        say("acapfeat: note: {} of {} shapes have features that no mesh has exactly; "
            "their meshes come nearest\n",
            summary.without_mesh, count);
    }
    if (summary.not_converged > 0) {
        say("acapfeat: warning: {} of {} shapes are not solved to the last digit\n",
            summary.not_converged, count);
    }
}

}  // namespace

void setup_reconstruct(CLI::App& app) {
    const auto options = std::make_shared<ReconstructCommand>();
    CLI::App* command = app.add_subcommand("reconstruct", "Meshes from ACAP features");
    command->add_option("FEATURES", options->features, "Feature file")->required();
    command->add_option("-o,--output", options->output, "Folder to write the meshes to")
        ->required();
    command
        ->add_option("--solver", options->solver,
                     "lossless: the meshes whose features these are; poisson: nearly, faster")
        ->check(CLI::IsMember({"lossless", "poisson"}))
        ->capture_default_str();
    command
        ->add_option("--frames", options->frames,
                     "A:B for shapes A to B-1, counted from 0; either may be left out")
        ->capture_default_str();
    command->add_option("--format", options->format, "Format of the meshes")
        ->check(CLI::IsMember({"obj", "ply", "off"}))
        ->capture_default_str();
    command->add_option("--handles", options->handles,
                        "JSON file of vertices and where they shall be, in every shape");
    command->add_flag("--aligned", options->keep_aligned,
                      "Leave shapes aligned to the reference instead of where the input stood");
    add_force(*command, options->common);
    add_quiet(*command, options->common);
    add_json(*command, options->common);
    add_threads(*command, options->common);
    set_example(*command, "acapfeat reconstruct swing.safetensors -o meshes --frames 0:10");
    command->callback([options] { run_reconstruct(*options); });
}

void run_reconstruct(const ReconstructCommand& options) {
    if (!options.handles.empty() && options.solver != "lossless") {
        throw UsageError("--handles: got --solver poisson, wanted lossless");
    }
    require_extension(options.output, "a folder", {});
    require_free_folder(options.output, options.common.force);
    require_apart(files_of_kind(options.output, {options.format}),
                  {options.features, options.handles});
    const FeatureFile file(options.features);
    const ShapeRange range = parse_shape_range(options.frames, file.shape_count());
    const ShapeReconstruction reconstruction(options, file);
    const Summary summary = reconstruct_shapes(options, file, reconstruction, range);
    print_summary(options, file.outline(), range.size(), reconstruction.is_lossless(), summary);
}

}  // namespace mscomp
