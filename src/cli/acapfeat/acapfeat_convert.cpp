// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "acapfeat_commands.h"
#include "cli/number_of.h"
#include "cli/progress.h"
#include "cli/say.h"
#include "cli/shape_files.h"
#include "convert_formats.h"
#include "mscomp/acap/feature_file.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/acap/mesh/natural_order.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/interruption.h"
#include "mscomp/base/json_text.h"
#include "mscomp/base/kept_inputs.h"
#include "mscomp/base/output_folder.h"
#include "mscomp/base/outputs.h"
#include "mscomp/convert/array_files.h"
#include "mscomp/convert/authors_text.h"
#include "mscomp/convert/splocs_file.h"

namespace mscomp {
namespace {

Contents read_meshes(const std::string& input) {
    Contents contents;
    std::vector<std::string> paths = expand_inputs({input});
    const std::string doubt = NaturalOrder(paths).doubt();
    if (!doubt.empty()) contents.notes.push_back(doubt);
    contents.shapes = std::make_unique<MeshFiles>(std::move(paths));
    return contents;
}

Contents read_text_pair(const std::string& path, const Supplement& supplement) {
    const std::string stretch_path = stretch_path_of(path);
    const AuthorsText r = parse_authors_text(read_file(path), AuthorsMatrix::log_rotation, path);
    const AuthorsText s =
        parse_authors_text(read_file(stretch_path), AuthorsMatrix::stretch, stretch_path);
    FeatureSet set;
    set.features = join_authors_text(r, s, stretch_path);
    set.weights.clear();
    return complete_features(std::move(set), r.shape_count, r.vertex_count, path, supplement);
}

Contents read_input(const ConvertCommand& options, FileFormat format) {
    Supplement supplement;
    supplement.weights = parse_edge_weights(options.weights);
    supplement.reference_path = options.reference;
    if (!options.reference.empty()) supplement.reference = read_mesh(options.reference);
    Contents contents;
    switch (format) {
        case FileFormat::meshes:
            contents = read_meshes(options.input);
            break;
        case FileFormat::safetensors:
            contents.features = read_features(options.input);
            break;
        case FileFormat::npz:
            contents = read_npz(options.input, supplement);
            break;
        case FileFormat::npy:
            contents = read_npy(options.input, supplement);
            break;
        case FileFormat::hdf5:
            contents = read_splocs(options.input);
            break;
        case FileFormat::text:
            contents = read_text_pair(options.input, supplement);
            break;
    }
    if (!options.reference.empty() && !contents.took_reference) {
        throw UsageError(
            fmt::format("--reference: {} has a reference or faces of its own", options.input));
    }
    return contents;
}

std::vector<std::string> inputs_of(const ConvertCommand& options, FileFormat format) {
    std::vector<std::string> inputs{options.input};
    if (format == FileFormat::meshes) inputs = expand_inputs({options.input});
    if (format == FileFormat::text) inputs.push_back(stretch_path_of(options.input));
    inputs.push_back(options.reference);
    return inputs;
}

void require_free(const ConvertCommand& options, const Output& output,
                  const std::vector<std::string>& inputs) {
    if (output.is_folder) {
        require_extension(options.output, "a folder", {});
        require_free_folder(options.output, options.common.force);
        return require_apart(files_of_kind(options.output, {output.mesh_format}), inputs);
    }
    require_extension(options.output, "the output of --to " + options.to, extensions_of(output));
    require_free_file(options.output, options.common.force);
    require_apart({options.output}, inputs);
    if (output.format != FileFormat::text) return;
    const std::string stretch_path = stretch_path_of(options.output);
    if (stretch_path.empty()) {
        throw UsageError(options.output +
                         ": wanted a name that begins with LOGRNEW; S*.txt is written beside it");
    }
    require_free_file(stretch_path, options.common.force);
    require_apart({stretch_path}, inputs);
}

void write_meshes(const ShapeSource& shapes, const ConvertCommand& options, const Output& output,
                  Progress& progress, Losses& losses) {
    const std::vector<std::string> names = shape_file_names(shapes.names());
    if (!output.is_folder && shapes.shape_count() != 1) {
        throw UsageError(fmt::format("{} holds {} shapes, {} would hold one; give a folder",
                                     options.input, shapes.shape_count(), options.output));
    }
    std::optional<OutputFolder> folder;
    if (output.is_folder) folder.emplace(options.output);
    for (int i = 0; i < shapes.shape_count(); ++i) {
        throw_if_interrupted("interrupted; nothing was written");
        const TriangleMesh mesh{shapes.shape(i), shapes.faces()};
        losses.watch_positions(mesh.vertices, output.mesh_format);
        write_mesh(folder ? folder->path(names[at(i)] + "." + output.mesh_format) : options.output,
                   mesh);
        progress.update(i + 1);
    }
    if (folder) folder->commit();
}

/// Extraction reads meshes only.
std::string how_to_extract(const std::string& input) {
    if (input_format(input) == FileFormat::meshes) {
        return fmt::format("acapfeat extract {} -o FEATURES.safetensors", input);
    }
    return fmt::format(
        "acapfeat convert {} MESHES --to obj, then acapfeat extract MESHES "
        "-o FEATURES.safetensors",
        input);
}

void write_shapes(const ShapeSource& shapes, const ConvertCommand& options, const Output& output,
                  Losses& losses) {
    Progress progress("convert", shapes.shape_count(), progress_options(options.common.quiet));
    const auto done = [&progress](int count) {
        throw_if_interrupted("interrupted; nothing was written");
        progress.update(count);
    };
    switch (output.format) {
        case FileFormat::meshes:
            return write_meshes(shapes, options, output, progress, losses);
        case FileFormat::npz:
            return write_npz(options.output, shapes, done);
        case FileFormat::npy:
            losses.add("faces");
            losses.add("names");
            return write_npy(options.output, shapes, done);
        case FileFormat::hdf5:
            losses.add("names");
            return write_splocs(options.output, shapes, done);
        case FileFormat::safetensors:
        case FileFormat::text:
            throw UsageError(options.input +
                             " has no features; make them with: " + how_to_extract(options.input));
    }
}

void write_text_pair(const std::string& path, const FeatureSet& set) {
    const std::string stretch_path = stretch_path_of(path);
    OutputFiles files({path, stretch_path});
    write_authors_text(files.path(stretch_path), set, AuthorsMatrix::stretch);
    write_authors_text(files.path(path), set, AuthorsMatrix::log_rotation);
    files.commit();
}

void write_features_as(const PlacedFeatures& set, const ConvertCommand& options,
                       const Output& output, Losses& losses) {
    switch (output.format) {
        case FileFormat::safetensors:
            return write_features(options.output, set, set.places);
        case FileFormat::npz:
            return write_npz(options.output, set, set.places);
        case FileFormat::npy:
            losses.add_all_but_features(set);
            return write_npy(options.output, set);
        default:
            losses.add_all_but_features(set);
            return write_text_pair(options.output, set);
    }
}

// Vertices of a feature set go to formats of vertices, and where asked for to arrays.
bool takes_vertices(const ConvertCommand& options, const Output& output) {
    if (output.format == FileFormat::meshes || output.format == FileFormat::hdf5) return true;
    return options.vertices;
}

void print_summary(const ConvertCommand& options, const Contents& contents, const Losses& losses,
                   bool wrote_features) {
    const int shapes =
        contents.features ? contents.features->shape_count() : contents.shapes->shape_count();
    const int vertices =
        contents.features ? contents.features->vertex_count() : contents.shapes->vertex_count();
    const std::vector<std::string> warnings =
        contents.shapes ? contents.shapes->warnings() : std::vector<std::string>{};
    if (options.common.json) {
        const nlohmann::ordered_json summary{
            {"file", options.output},     {"shapes", shapes},           {"vertices", vertices},
            {"features", wrote_features}, {"supplied", contents.notes}, {"lost", losses.all()},
            {"warnings", warnings}};
        print_lines(json_text(summary, 2) + "\n");
        return;
    }
    print_out("{}: {} of {} with {}\n", options.output, wrote_features ? "features" : "vertices",
              number_of_shapes(shapes), number_of_vertices(vertices));
    if (options.common.quiet) return;
    for (const std::string& warning : warnings) {
        say("acapfeat: warning: {}\n", warning);
    }
    std::vector<std::string> notes = contents.notes;
    if (!losses.all().empty()) {
        notes.push_back(
            fmt::format("{} does not hold {}", options.output, fmt::join(losses.all(), ", ")));
    }
    if (!notes.empty()) say("acapfeat: note: {}\n", fmt::format("{}", fmt::join(notes, "; ")));
}

}  // namespace

void setup_convert(CLI::App& app) {
    const auto options = std::make_shared<ConvertCommand>();
    CLI::App* command = app.add_subcommand(
        "convert", "Between meshes, feature files, npy/npz, SPLOCS HDF5 and the authors' text");
    command
        ->add_option("IN", options->input,
                     "Folder or quoted glob of meshes, mesh, .safetensors, .npz, .npy, .h5, .hdf5 "
                     "or LOGRNEW*.txt (with S*.txt beside it)")
        ->required();
    command->add_option("OUT", options->output, "What to write, by its extension; none: a folder")
        ->required();
    command->add_option("--to", options->to, "Format to write, where OUT does not tell")
        ->check(CLI::IsMember({"obj", "ply", "off", "safetensors", "npz", "npy", "h5", "text"}));
    command->add_option("--reference", options->reference,
                        "Mesh with the reference and faces that text and arrays may lack");
    command
        ->add_option("--weights", options->weights,
                     "Edge weights the features of text and arrays were made with")
        ->check(CLI::IsMember({"cotangent", "authors", "uniform"}))
        ->capture_default_str();
    command->add_flag("--aligned", options->aligned,
                      "Leave the vertices of features aligned instead of where the input stood");
    command->add_flag("--vertices", options->vertices,
                      "Of a feature file take the vertices to .npz or .npy, not the features");
    add_force(*command, options->common);
    add_quiet(*command, options->common);
    add_json(*command, options->common);
    add_threads(*command, options->common);
    set_example(*command, "acapfeat convert swing.safetensors swing.npz");
    command->callback([options] { run_convert(*options); });
}

void run_convert(const ConvertCommand& options) {
    const FileFormat from = input_format(options.input);
    const Output output = output_format(options.output, options.to);
    require_free(options, output, inputs_of(options, from));
    const Contents contents = read_input(options, from);
    throw_if_interrupted("interrupted; nothing was written");
    Losses losses;
    const bool write_features = contents.features && !takes_vertices(options, output);
    if (write_features) {
        write_features_as(*contents.features, options, output, losses);
    } else if (contents.features) {
        losses.add_all_but_vertices(*contents.features);
        write_shapes(FeatureShapes(*contents.features, options.aligned), options, output, losses);
    } else {
        write_shapes(*contents.shapes, options, output, losses);
        for (const std::string& unused : contents.shapes->unused()) losses.add(unused);
    }
    print_summary(options, contents, losses, write_features);
}

}  // namespace mscomp
