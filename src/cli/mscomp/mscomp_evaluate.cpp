// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "cli/progress.h"
#include "cli/say.h"
#include "mscomp/base/json_text.h"
#include "mscomp/base/kept_inputs.h"
#include "mscomp/base/outputs.h"
#include "mscomp/base/printable.h"
#include "mscomp/report/evaluation.h"
#include "mscomp/run/fits.h"
#include "mscomp/run/run_folder.h"
#include "mscomp_commands.h"

namespace mscomp {
namespace {

using nlohmann::ordered_json;

std::vector<std::string> fits_of(const ordered_json& report) {
    std::vector<std::string> fits;
    for (const std::string& fit : fit_names()) {
        if (report.contains(fit)) fits.push_back(fit);
    }
    return fits;
}

std::string number(const ordered_json& value, const char* format) {
    return value.is_null() ? "-" : fmt::format(fmt::runtime(format), value.get<double>());
}

/// One measure: a column per fit, and what the undeformed reference has.
void print_measure(const ordered_json& report, const char* label, const char* key,
                   const char* format) {
    print_out("  {:<40}", label);
    for (const std::string& fit : fits_of(report)) {
        print_out("{:>14}", number(report[fit][key], format));
    }
    print_out("{:>10}\n", number(report["reference"][key], format));
}

void print_measures(const ordered_json& report) {
    print_out("{:<42}", "");
    for (const std::string& fit : fits_of(report)) print_out("{:>14}", fit + " fit");
    print_out("{:>10}\n", "reference");
    print_measure(report, "E_rms (x1000, unit ball)", "rms_error", "{:.3f}");
    if (!report[fits_of(report).front()]["rms_error_pieces"].is_null()) {
        print_measure(report, "  every piece aligned by itself", "rms_error_pieces", "{:.3f}");
    }
    print_measure(report, "STED", "sted", "{:.5f}");
    print_measure(report, "  spatial part", "sted_spatial", "{:.5f}");
    print_measure(report, "  temporal part", "sted_temporal", "{:.5f}");
    print_measure(report, "mean vertex distance (mesh units)", "mean_vertex_distance", "{:.4g}");
    print_measure(report, "largest vertex distance (mesh units)", "max_vertex_distance", "{:.4g}");
    print_measure(report, "mean relative squared feature error", "relative_squared_error_mean",
                  "{:.5f}");
    print_measure(report, "largest relative squared feature error", "relative_squared_error_max",
                  "{:.5f}");
}

/// Those that are worst in some fit, in the order of the last one.
void print_worst(const ordered_json& report) {
    const std::vector<std::string> fits = fits_of(report);
    std::vector<int> shapes;
    for (auto fit = fits.rbegin(); fit != fits.rend(); ++fit) {
        for (const ordered_json& shape : report["worst"][*fit]) {
            const int index = shape["shape"];
            if (std::ranges::find(shapes, index) == shapes.end()) shapes.push_back(index);
        }
    }
    if (shapes.empty()) return;
    print_out("\nworst shapes, E_rms\n");
    for (const int index : shapes) {
        for (const ordered_json& row : report["per_shape"]) {
            if (row["shape"] != index) continue;
            print_out("  {:>5}  {:<33}", index, row["name"].get<std::string>());
            for (const std::string& fit : fits) {
                print_out("{:>14}", number(row[fit]["rms_error"], "{:.3f}"));
            }
            print_out("\n");
        }
    }
}

void print_curves(const ordered_json& report) {
    const std::vector<std::string> fits = fits_of(report);
    if (report[fits.front()].contains("by_components")) {
        print_out("\nE_rms with the n strongest components only\n");
        const std::size_t count = report[fits.front()]["by_components"].size();
        for (std::size_t i = 0; i < count; ++i) {
            print_out("  {:>5}  {:<33}", report[fits.front()]["by_components"][i]["n"].get<int>(),
                      "");
            for (const std::string& fit : fits) {
                print_out("{:>14}", number(report[fit]["by_components"][i]["rms_error"], "{:.3f}"));
            }
            print_out("\n");
        }
    }
    if (!report.contains("by_handles")) return;
    print_out("\nE_rms where only n vertices of a shape are known\n");
    for (const ordered_json& entry : report["by_handles"]) {
        print_out("  {:>5}  {:<33}{:>14}\n", entry["n"].get<int>(), "",
                  number(entry["rms_error"], "{:.3f}"));
    }
}

void print_trust(const ordered_json& report) {
    double sum = 0;
    std::vector<double> held_out;
    for (const ordered_json& c : report["component_list"]) {
        if (!c["kept"] || !c.contains("found_again")) continue;
        sum += c["found_again"].get<double>();
        held_out.push_back(c["held_out"].get<double>());
    }
    if (held_out.empty()) return;
    std::ranges::sort(held_out);
    print_out(
        "found again in subsets of the training shapes: {:.0f} % of them on average; their "
        "codes in shapes left out correlate by {:.2f} (median)\n",
        100 * sum / static_cast<double>(held_out.size()), held_out[held_out.size() / 2]);
}

void print_components(const ordered_json& report) {
    constexpr std::size_t kShown = 10;
    const std::vector<std::string> fits = fits_of(report);
    print_out("\ncomponents kept:");
    for (std::size_t l = 0; l < report["components"].size(); ++l) {
        print_out("{} {} on level {}", l == 0 ? "" : ",", report["components"][l].get<int>(), l);
    }
    const ordered_json& support = report[fits.front()]["support_mean"];
    if (!support.is_null()) {
        print_out("; mean support {:.1f} % of the vertices", 100 * support.get<double>());
    }
    print_out("\n");
    print_out("cosine similarity of different components: mean {}, largest {}\n",
              number(report["cosine"]["mean"], "{:.3f}"),
              number(report["cosine"]["max"], "{:.3f}"));
    print_trust(report);
    std::vector<ordered_json> kept;
    for (const ordered_json& c : report["component_list"]) {
        if (c["kept"]) kept.push_back(c);
    }
    std::ranges::stable_sort(kept, [](const ordered_json& a, const ordered_json& b) {
        return a["distance"].get<double>() > b["distance"].get<double>();
    });
    if (kept.empty()) return;
    print_out("  {:<10}{:>7}{:>11}{:>13}{:>10}\n", "strongest", "level", "distance", "support (%)",
              "radius");
    for (std::size_t k = 0; k < std::min(kShown, kept.size()); ++k) {
        const ordered_json& c = kept[k];
        print_out("  {:<10}{:>7}{:>11.4f}{:>13.1f}{:>10.3f}\n", c["id"].get<std::string>(),
                  c["level"].get<int>(), c["distance"].get<double>(),
                  100 * c["support"].get<double>(), c["localization_radius"].get<double>());
    }
    if (kept.size() > kShown) {
        print_out("  and {} more: --json or -o lists all\n", kept.size() - kShown);
    }
}

void print_units(const ordered_json& report) {
    if (!report.contains("units")) return;
    const ordered_json& units = report["units"];
    print_out("\n{} known units, {} of them vary over these shapes\n", units["units"].get<int>(),
              units["varying"].get<int>());
    for (const std::string& fit : fits_of(report)) {
        print_out(
            "  {} fit: {} matched (|correlation| >= {:.1f}), {} by a component of their own\n", fit,
            units[fit]["matched"].get<int>(), units["threshold"].get<double>(),
            units[fit]["matched_one_to_one"].get<int>());
    }
}

void print_scales(const ordered_json& matches, const std::string& label) {
    for (const char* name : {"coarse", "fine"}) {
        const ordered_json& scale = matches[name];
        const int count = scale["components"];
        if (count == 0) continue;
        const auto of_all = [&](const char* key) {
            return !scale.contains(key) || scale[key].is_null()
                       ? std::string("-")
                       : fmt::format("{} of {}", scale[key].get<int>(), count);
        };
        print_out("  {:<24}{:>8}{:>8}{:>8}{:>12}{:>10}{:>12}\n", label, name,
                  number(scale["iou"], "{:.2f}"), number(scale["soft_iou"], "{:.2f}"),
                  of_all("at_scale"), number(scale.value("correlation", ordered_json()), "{:.2f}"),
                  of_all("matched_one_to_one"));
    }
}

std::string cell(const ordered_json& match) {
    const ordered_json& id = match["component"];
    return fmt::format("{:>12}{:>6}", id.is_null() ? "-" : id.get<std::string>(),
                       number(match["iou"], "{:.2f}"));
}

void print_truth(const ordered_json& report) {
    if (!report.contains("truth")) return;
    const ordered_json& truth = report["truth"];
    print_out("\n{} true components, {} of them vary over these shapes; means\n",
              truth["components"].get<int>(), truth["varying"].get<int>());
    print_out("  {:<24}{:>8}{:>8}{:>8}{:>12}{:>10}{:>12}\n", "", "", "IoU", "soft", "at scale",
              "|corr.|", "matched");
    print_scales(truth["by_overlap"], "by overlap");
    for (const std::string& fit : fits_of(report)) print_scales(truth[fit], "by codes, " + fit);
    const std::string first = fits_of(report).front();
    print_out("  {:<24}{:>8}{:>12}{:>6}{:>8}{:>12}{:>6}{:>8}\n", "", "", "by overlap", "IoU",
              "|corr.|", "by codes", "IoU", "|corr.|");
    for (const ordered_json& row : truth[first]["list"]) {
        const ordered_json& one = row["one_to_one"];
        const ordered_json& overlapping = row["by_overlap"];
        print_out("  {:<24}{:>8}{}{:>8}{}{:>8}\n", printable(row["unit"].get<std::string>()),
                  row["scale"].get<std::string>(), cell(overlapping),
                  number(overlapping["correlation"], "{:.2f}"), cell(one),
                  number(one["correlation"], "{:.2f}"));
    }
}

void print_report(const EvaluateOptions& options, const ordered_json& report) {
    print_out("{}: {}, {} of {} shapes of {} ({}), as a {}\n\n", options.run,
              report["kind"].get<std::string>(), report["shapes"].get<int>(),
              report["shapes_in_set"].get<int>(), report["features_file"].get<std::string>(),
              report["split"].get<std::string>(), report["order"].get<std::string>());
    if (report["kept_only"]) print_out("with the components that the filter keeps alone\n\n");
    print_measures(report);
    print_worst(report);
    print_curves(report);
    print_components(report);
    print_units(report);
    print_truth(report);
    if (!options.output.empty()) {
        print_out("\n{}: table.csv, components.csv{}\n", options.output,
                  options.worst > 0 ? ", errors.png" : "");
    }
}

void require_own_output(const EvaluateOptions& options) {
    require_extension(options.output, "a folder", {});
    require_free_folder(options.output, options.common.force);
    require_apart(files_of_kind(options.output, {"csv", "png"}),
                  {model_path(options.run), options.features, options.units, options.truth});
}

}  // namespace

void setup_evaluate(CLI::App& app) {
    const auto options = std::make_shared<EvaluateOptions>();
    CLI::App* command =
        app.add_subcommand("evaluate", "Measure how well a model gives shapes back");
    command->add_option("RUN", options->run, "Run folder or model file")->required();
    command->add_option("FEATURES", options->features,
                        "Feature file of the same mesh; without it the one the model was trained "
                        "on");
    command
        ->add_option("--split", options->split,
                     "Which shapes, as split for training; without it test, or all of another file")
        ->check(CLI::IsMember({"test", "train", "all"}));
    command
        ->add_option(
            "--fit", options->fit,
            "Codes of the encoder (features), fitted to the features (codes), fitted to the "
            "vertices; both: the first and the last")
        ->check(CLI::IsMember(fit_choices()))
        ->capture_default_str();
    command->add_flag("--kept", options->kept,
                      "Only with the components that the filter keeps, their codes refitted");
    command
        ->add_option("--components", options->components,
                     "Also with the N strongest components only; several numbers: N,N,...")
        ->delimiter(',');
    command
        ->add_option("--handles", options->handles,
                     "Also where only N spread vertices of a shape are known: N,N,...")
        ->delimiter(',');
    command
        ->add_option("--order", options->order,
                     "Whether shapes follow each other in time; auto: where the split is 'every'")
        ->check(CLI::IsMember({"auto", "sequence", "set"}))
        ->capture_default_str();
    command->add_option("--units", options->units,
                        "CSV of true weights, a row per shape, to tell which a component matches");
    command->add_option("--truth", options->truth,
                        "truth.json of a generated set, its supports beside it: which component "
                        "lies where a true one does, and has its weights");
    command->add_option("--worst", options->worst, "How many of the worst shapes to name and draw")
        ->check(CLI::Range(0, 30))
        ->capture_default_str();
    command->add_option("-o,--output", options->output,
                        "Folder for table.csv, components.csv and errors.png");
    add_force(*command, options->common);
    add_quiet(*command, options->common);
    add_json(*command, options->common);
    add_threads(*command, options->common);
    set_example(*command, "mscomp evaluate swing.run -o swing.measures");
    command->callback([options] { run_evaluate(*options); });
}

void run_evaluate(const EvaluateOptions& options) {
    if (!options.output.empty()) require_own_output(options);
    std::optional<Progress> progress;
    EvaluationOptions evaluated{options.run,
                                options.features,
                                options.split,
                                options.handles,
                                options.components,
                                options.fit,
                                options.kept,
                                options.order,
                                options.worst,
                                options.units,
                                options.truth,
                                options.output,
                                {}};
    evaluated.on_progress = [&](std::int64_t done, std::int64_t total) {
        if (!progress) progress.emplace("evaluate", total, progress_options(options.common.quiet));
        progress->update(done);
    };
    const ordered_json report = evaluation_report(evaluated);
    progress.reset();
    if (options.common.json) {
        print_lines(json_text(report, 2) + "\n");
    } else {
        print_report(options, report);
    }
}

}  // namespace mscomp
