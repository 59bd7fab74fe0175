// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "cli/progress.h"
#include "cli/say.h"
#include "mscomp/base/json_text.h"
#include "mscomp/base/kept_inputs.h"
#include "mscomp/base/outputs.h"
#include "mscomp/report/component_export.h"
#include "mscomp/run/run_folder.h"
#include "mscomp_commands.h"

namespace mscomp {

void setup_export(CLI::App& app) {
    const auto options = std::make_shared<ExportOptions>();
    CLI::App* command = app.add_subcommand(
        "export-components", "Write the learnt components as coloured meshes and one picture");
    command->add_option("RUN", options->run, "Run folder or model file")->required();
    command->add_option("-o,--output", options->output, "Folder to write to")->required();
    command->add_flag("--all", options->all,
                      "Also components that the redundancy filter drops or merges");
    command->add_option("--tile", options->tile, "Pixels per side of one component in overview.png")
        ->check(CLI::Range(64, 1024))
        ->capture_default_str();
    command->add_option("--up", options->up,
                        "Axis that points up in overview.png: x, y, z, -x, -y or -z (default: y, "
                        "unless the mesh is more than twice as long along another)");
    command->add_option("--view", options->view,
                        "Side that all are seen from in overview.png: front, back, left, right, "
                        "top, bottom, or azimuth,elevation in degrees (default: for each the one "
                        "that shows most of its motion)");
    add_force(*command, options->common);
    add_quiet(*command, options->common);
    add_json(*command, options->common);
    add_threads(*command, options->common);
    set_example(*command, "mscomp export-components swing.run -o components");
    command->callback([options] { run_export(*options); });
}

void run_export(const ExportOptions& options) {
    ComponentExportOptions exported;
    exported.all = options.all;
    exported.tile = options.tile;
    if (!options.up.empty()) exported.up = parse_axis(options.up);
    if (!options.view.empty()) exported.view = parse_viewpoint(options.view);
    require_extension(options.output, "a folder", {});
    require_free_folder(options.output, options.common.force);
    require_apart(files_of_kind(options.output, {"ply", "json", "png"}), {model_path(options.run)});
    TrainedRun run = open_run(options.run);
    std::optional<Progress> progress;
    exported.on_progress = [&](std::int64_t done, std::int64_t total) {
        if (!progress) progress.emplace("export", total, progress_options(options.common.quiet));
        progress->update(done);
    };
    const nlohmann::ordered_json report =
        export_components(run, options.run, options.output, exported);
    progress.reset();
    if (options.common.json) {
        print_lines(json_text(report, 2) + "\n");
        return;
    }
    std::size_t files = 0;
    for (const auto& component : report["components"]) {
        files += component["file"].is_null() ? 0 : 2;
    }
    print_out("{}/overview.png: {} of {} components kept\n", options.output,
              report["kept"].get<int>(), report["components"].size());
    print_out("  up {}{}, front {}; --up and --view change that\n",
              report["stance"]["up"].get<std::string>(),
              report["stance"]["up_guessed"].get<bool>() ? " (a guess)" : "",
              report["stance"]["front"].get<std::string>());
    print_out("{}/components.json and {} PLY files\n", options.output, files);
}

}  // namespace mscomp
