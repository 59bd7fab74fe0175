// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "cli/program.h"
#include "cli/say.h"
#include "mscomp/base/index.h"
#include "mscomp/base/json_text.h"
#include "mscomp/model/components.h"
#include "mscomp/run/trained_run.h"
#include "mscomp_commands.h"

namespace mscomp {

void setup_run_info(CLI::App& app) {
    const auto options = std::make_shared<RunInfoOptions>();
    CLI::App* command = app.add_subcommand("info", "What a run has learnt so far");
    command->add_option("RUN", options->run, "Run folder or model file")->required();
    add_quiet(*command, options->common);
    add_json(*command, options->common);
    add_threads(*command, options->common);
    set_example(*command, "mscomp info swing.run");
    command->callback([options] { run_run_info(*options); });
}

void run_run_info(const RunInfoOptions& options) {
    TrainedRun run = open_run(options.run, 1);
    const ModelContext& context = run.context();
    const std::vector<Component> components = run.components();
    const int vertices = context.reference.vertex_count();
    nlohmann::ordered_json levels = nlohmann::ordered_json::array();
    const std::vector<LevelSize> sizes = run.model->levels();
    for (int l = 0; l < static_cast<int>(sizes.size()); ++l) {
        const auto kept = std::ranges::count_if(
            components, [l](const Component& c) { return c.level == l && c.kept; });
        const LevelSize& level = sizes[at(l)];
        levels.push_back({{"autoencoders", level.autoencoders},
                          {"components", level.codes()},
                          {"kept", kept},
                          {"support_mean", mean_support(components, l, vertices)}});
    }
    const TrainingState& state = run.file.state();
    // The loss is that of the last step: before the first there is none.
    const bool has_loss = state.step > 0;
    const nlohmann::ordered_json report{
        {"run", options.run},
        {"kind", run.config.kind},
        {"source", context.source},
        {"vertices", context.mesh().vertex_count()},
        {"faces", context.reference.face_count()},
        {"train_shapes", context.train_shapes.size()},
        {"test_shapes", context.test_shapes.size()},
        {"epochs", state.epoch},
        {"epochs_planned", run.config.train.epochs},
        {"steps", state.step},
        {"loss", has_loss ? nlohmann::ordered_json(state.total) : nlohmann::ordered_json(nullptr)},
        {"rate_factor", state.rate_factor},
        {"largest_distance", context.largest_distance},
        {"largest_distance_exact", context.largest_distance_exact},
        {"levels", levels}};
    if (options.common.json) {
        print_lines(json_text(report, 2) + "\n");
        return;
    }
    print_out("{}: {}, {} of {} epochs, {} steps, loss {}\n", options.run, run.config.kind,
              state.epoch, run.config.train.epochs, state.step,
              has_loss ? fmt::format("{:.6g}", state.total) : "not known yet");
    if (state.rate_factor < 1) {
        print_out("training diverged and went back; learning rate times {:g} since then\n",
                  state.rate_factor);
    }
    print_out("trained on {} of {} shapes of {}, {} vertices, {} faces\n",
              context.train_shapes.size(), context.train_shapes.size() + context.test_shapes.size(),
              context.source, context.mesh().vertex_count(), context.reference.face_count());
    for (std::size_t l = 0; l < levels.size(); ++l) {
        print_out("level {}: {} components ({} kept), mean support {:.1f} % of the vertices\n", l,
                  levels[l]["components"].get<int>(), levels[l]["kept"].get<int>(),
                  100 * levels[l]["support_mean"].get<double>());
    }
}

}  // namespace mscomp
