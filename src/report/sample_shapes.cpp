// SPDX-License-Identifier: MIT
#include "mscomp/report/sample_shapes.h"

#include <fmt/format.h>

#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/interruption.h"
#include "mscomp/base/output_folder.h"
#include "mscomp/edit/code_positions.h"
#include "mscomp/report/component_sheets.h"

namespace mscomp {
namespace {

/// One line per sample: its name and all codes, with digits enough for float32.
std::string code_table(const std::vector<Component>& components,
                       const std::vector<std::string>& names,
                       const std::vector<std::vector<float>>& codes) {
    std::string text = "sample";
    for (const Component& c : components) text += "," + c.id;
    text += "\n";
    for (std::size_t i = 0; i < names.size(); ++i) {
        text += names[i];
        for (const float code : codes[i]) text += fmt::format(",{:.9g}", code);
        text += "\n";
    }
    return text;
}

}  // namespace

std::vector<std::string> sample_shapes(TrainedRun& run, const std::string& folder,
                                       const SampleShapesOptions& options) {
    constexpr int kMostDrawn = 60;
    const CodeSampler sampler(options.distribution, run.file.codes(), options.seed);
    const CodePositions positions(*run.model, run.reference(),
                                  parse_edge_weights(run.context().weights),
                                  VertexSolver::lossless);
    OutputFolder output(folder);
    const int digits = static_cast<int>(std::to_string(options.count).size());
    std::vector<std::string> names, files;
    std::vector<std::vector<float>> codes;
    std::vector<ColoredShape> drawn;
    for (int i = 0; i < options.count; ++i) {
        throw_if_interrupted(fmt::format("interrupted; nothing was changed in {}", folder));
        codes.push_back(sampler.draw(static_cast<std::uint64_t>(i)));
        TriangleMesh mesh{positions.positions(positions.rows(codes.back())), run.reference().faces};
        names.push_back(fmt::format("sample_{:0{}}", i, digits));
        const std::string file = fmt::format("{}.{}", names.back(), options.format);
        files.push_back(fmt::format("{}/{}", folder, file));
        write_mesh(output.path(file), run.context().whole(mesh.vertices));
        if (i < kMostDrawn) drawn.push_back({std::move(mesh), {}, 0});
        if (options.on_progress) options.on_progress(i + 1, options.count);
    }
    write_file(output.path("codes.csv"), code_table(run.components(), names, codes));
    write_png(
        output.path("overview.png"),
        shapes_sheet(options.title, "Random shapes", run.reference(), drawn, names, options.tile));
    output.commit();
    return files;
}

}  // namespace mscomp
