// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "acapfeat_commands.h"
#include "cli/progress.h"
#include "cli/say.h"
#include "mesh_inputs.h"
#include "mscomp/acap/check.h"
#include "mscomp/base/error.h"
#include "mscomp/base/interruption.h"
#include "mscomp/base/json_text.h"
#include "mscomp/base/parsed_number.h"

namespace mscomp {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kPlacesShown = 10;

CheckOptions check_options(const std::string& reference) {
    const auto index = parsed_number<decltype(CheckOptions::reference_index)>(reference);
    return index ? CheckOptions{*index, ""} : CheckOptions{0, reference};
}

Json to_json(const CheckPlace& place) {
    Json json{{"text", place.text}, {"file", place.file}};
    if (!place.other_file.empty()) json["other_file"] = place.other_file;
    if (place.line > 0) json["line"] = place.line;
    if (place.column > 0) json["column"] = place.column;
    if (place.vertex > 0) json["vertex"] = place.vertex;
    if (place.other_vertex > 0) json["other_vertex"] = place.other_vertex;
    if (place.face > 0) json["face"] = place.face;
    if (place.count > 0) json["count"] = place.count;
    return json;
}

Json to_json(const Finding& finding) {
    Json places = Json::array();
    for (const CheckPlace& place : finding.places) places.push_back(to_json(place));
    return {{"severity", to_string(finding.severity)},
            {"kind", finding.kind},
            {"count", finding.count},
            {"sentence", finding.sentence},
            {"advice", finding.advice},
            {"places", places}};
}

void print_json(const CheckReport& report) {
    Json findings = Json::array();
    for (const Finding& finding : report.findings) findings.push_back(to_json(finding));
    const Json json{{"files", report.files},
                    {"usable", report.usable},
                    {"errors", report.count(Severity::error)},
                    {"warnings", report.count(Severity::warning)},
                    {"notes", report.count(Severity::note)},
                    {"reference", report.reference},
                    {"vertices", report.vertices},
                    {"faces", report.faces},
                    {"edges", report.edges},
                    {"components", report.components},
                    {"boundary_loops", report.boundary_loops},
                    {"bounding_box", {{"lowest", report.lowest}, {"highest", report.highest}}},
                    {"unit_ball_scale", report.unit_ball_scale},
                    {"stretch",
                     {{"largest", report.stretch.largest},
                      {"file", report.stretch.file},
                      {"vertex", report.stretch.vertex},
                      {"quantile_999", report.stretch.most_below}}},
                    {"findings", findings}};
    print_lines(json_text(json, 2) + "\n");
}

void print_summary(const CheckReport& report) {
    print_out("shapes        {}{}\n", report.files,
              report.usable == report.files
                  ? ""
                  : fmt::format(", {} of them can be used", report.usable));
    if (report.reference.empty()) return;
    print_out("reference     {}\n", report.reference);
    print_out("vertices      {}\n", report.vertices);
    print_out("faces         {}\n", report.faces);
    print_out("edges         {}\n", report.edges);
    print_out("components    {}\n", report.components);
    print_out("boundaries    {}\n", report.boundary_loops);
    print_out("size          {:.4g} x {:.4g} x {:.4g}, in the unit of the files\n",
              report.highest[0] - report.lowest[0], report.highest[1] - report.lowest[1],
              report.highest[2] - report.lowest[2]);
    print_out("unit ball     positions times {:.6g}\n", report.unit_ball_scale);
    if (report.stretch.vertex == 0) return;
    print_out("largest |S-I| {:.4g} at vertex {} of {}\n", report.stretch.largest,
              report.stretch.vertex, report.stretch.file);
    print_out("most |S-I|    below {:.3g} for 99.9 % of the vertices of all shapes\n",
              report.stretch.most_below);
}

void print_finding(const Finding& finding) {
    print_out("\n{}: {} [{}]\n", to_string(finding.severity), finding.sentence, finding.kind);
    const std::size_t shown = std::min(finding.places.size(), kPlacesShown);
    for (std::size_t k = 0; k < shown; ++k) print_out("    {}\n", finding.places[k].text);
    if (finding.places.size() > shown) print_out("    ... (more of them with --json)\n");
    print_out("  {}\n", finding.advice);
}

void print_text(const CheckReport& report) {
    print_summary(report);
    for (const Finding& finding : report.findings) print_finding(finding);
    print_out("\n");
    const int errors = report.count(Severity::error), warnings = report.count(Severity::warning);
    if (report.findings.empty()) {
        print_out("Nothing is wrong or odd with these meshes.\n");
    } else if (errors > 0) {
        print_out("Extraction would stop: mend what is marked as error first.\n");
    } else if (warnings > 0) {
        print_out("Extraction works. Look at the warnings before a long training.\n");
    } else {
        print_out("Nothing is wrong with these meshes; the notes are worth knowing.\n");
    }
}

}  // namespace

void setup_check(CLI::App& app) {
    const auto options = std::make_shared<CheckCommand>();
    CLI::App* command = app.add_subcommand(
        "check", "What is in a set of meshes, and what is wrong or odd about it");
    command->add_option("INPUT", options->inputs,
                        "Mesh files, folders or quoted globs; used in natural order");
    command->add_option("--list", options->list,
                        "File naming the meshes in order, one per line, relative to its folder");
    command
        ->add_option("--reference", options->reference,
                     "Reference shape: index from 0, or a mesh file")
        ->capture_default_str();
    add_quiet(*command, options->common);
    add_json(*command, options->common);
    add_threads(*command, options->common);
    set_example(*command, "acapfeat check swing/*.obj");
    command->callback([options] { run_check(*options); });
}

void run_check(const CheckCommand& options) {
    const std::vector<std::string> paths = mesh_paths(options.inputs, options.list);
    Progress progress("check", static_cast<std::int64_t>(paths.size()),
                      progress_options(options.common.quiet));
    const CheckReport report =
        check_meshes(paths, check_options(options.reference), [&](int done, int) {
            throw_if_interrupted("interrupted; not all files were looked at");
            progress.update(done);
        });
    throw_if_interrupted("interrupted; not all files were looked at");
    if (options.common.json) {
        print_json(report);
    } else {
        print_text(report);
    }
    if (const int errors = report.count(Severity::error); errors > 0) {
        throw MeshError(fmt::format(
            "{} found, extraction would stop",
            errors == 1 ? "1 kind of error" : fmt::format("{} kinds of errors", errors)));
    }
}

}  // namespace mscomp
