// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "acapfeat_commands.h"
#include "cli/number_of.h"
#include "cli/say.h"
#include "cli/seed_option.h"
#include "mscomp/base/error.h"
#include "mscomp/base/kept_inputs.h"
#include "mscomp/base/outputs.h"
#include "mscomp/generate/generate.h"

namespace mscomp {
namespace {

/// An option that only some generators take.
struct OwnOption {
    const char* name;
    std::optional<double> GenerateCommand::*value;
    double TwistOptions::*target;
    const char* description;
};

const std::vector<OwnOption>& own_options() {
    static const std::vector<OwnOption> all{
        {"--turns", &GenerateCommand::turns, &TwistOptions::turns, "Turns of the far end"},
        {"--tilt", &GenerateCommand::tilt, &TwistOptions::tilt,
         "Degrees by which the axis leans over along the bar"},
        {"--noise", &GenerateCommand::noise, &TwistOptions::noise,
         "Standard deviation of the positions, relative to the mean edge length"},
        {"--thickness", &GenerateCommand::thickness, &TwistOptions::thickness,
         "Radius, relative to the spacing of the rings"}};
    return all;
}

TwistOptions twist_options(const GenerateCommand& options) {
    TwistOptions twist;
    for (const OwnOption& own : own_options()) {
        twist.*own.target = (options.*own.value).value_or(twist.*own.target);
    }
    return twist;
}

struct Generator {
    const char* name;
    const char* description;
    int frames, vertices;  // unless asked for others
    bool has_own_options;
    GeneratedSequence (*make)(int frames, int vertices, const GenerateCommand& options);
};

const std::vector<Generator>& generators() {
    static const std::vector<Generator> all{
        {"arm", "a limb that bends and twists, with bulges and ripples", 60, 3000, false,
         [](int frames, int vertices, const GenerateCommand& options) {
             return generate_arm(frames, options.seed, vertices);
         }},
        {"cloth", "a flat sheet with travelling folds, curling corners and wrinkles", 60, 3000,
         false,
         [](int frames, int vertices, const GenerateCommand& options) {
             return generate_cloth(frames, options.seed, vertices);
         }},
        {"face", "a head with overlapping expressions", 60, 3000, false,
         [](int frames, int vertices, const GenerateCommand& options) {
             return generate_face(frames, options.seed, vertices);
         }},
        {"twist", "a slender bar twisted by several turns", 60, 400, true,
         [](int frames, int vertices, const GenerateCommand& options) {
             return generate_twist(frames, options.seed, vertices, twist_options(options));
         }}};
    return all;
}

/// One number per generator: "arm 60, twist 60".
std::string defaults_of(int Generator::*number) {
    std::string text;
    for (const Generator& each : generators()) {
        text += fmt::format("{}{} {}", text.empty() ? "" : ", ", each.name, each.*number);
    }
    return text;
}

void refuse_foreign_options(const Generator& generator, const GenerateCommand& options) {
    if (generator.has_own_options) return;
    for (const OwnOption& own : own_options()) {
        if (!(options.*own.value)) continue;
        for (const Generator& other : generators()) {
            if (other.has_own_options) {
                throw UsageError(fmt::format("{} is an option of 'generate {}', got 'generate {}'",
                                             own.name, other.name, generator.name));
            }
        }
    }
}

/// Of what is kept of all frames until they are written.
void refuse_absurd_size(const Generator& generator, int frames, int vertices) {
    const double each =
        generator.has_own_options ? 72 : 24;  // a twist has features beside positions
    const double bytes = each * frames * vertices;
    const double here = static_cast<double>(::sysconf(_SC_PHYS_PAGES)) *
                        static_cast<double>(::sysconf(_SC_PAGESIZE));
    const double most = std::min(64e9, 0.75 * here);
    if (bytes <= most) return;
    throw UsageError(fmt::format(
        "{} frames of {} vertices take {:.3g} GB, wanted at most {:.3g} on this machine", frames,
        vertices, bytes / 1e9, most / 1e9));
}

}  // namespace

void setup_generate(CLI::App& app) {
    const auto options = std::make_shared<GenerateCommand>();
    CLI::App* command =
        app.add_subcommand("generate", "A built-in sequence whose true components are known");
    std::vector<std::string> names;
    std::string descriptions;
    for (const Generator& each : generators()) {
        names.emplace_back(each.name);
        descriptions +=
            fmt::format("{}{}: {}", descriptions.empty() ? "" : "; ", each.name, each.description);
    }
    command->add_option("NAME", options->name, descriptions)
        ->required()
        ->check(CLI::IsMember(names));
    command->add_option("-o,--output", options->output, "Folder to write it to")->required();
    command->add_option(
        "--frames", options->frames,
        "Number of shapes, the undeformed one included [" + defaults_of(&Generator::frames) + "]");
    command->add_option("--seed", options->seed, "Which motion, or which noise")
        ->check(is_seed)
        ->capture_default_str();
    command->add_option("--vertices", options->vertices,
                        "Vertices at least [" + defaults_of(&Generator::vertices) + "]");
    const TwistOptions defaults;
    for (const OwnOption& own : own_options()) {
        command->add_option(own.name, (*options).*own.value,
                            fmt::format("{} [twist {}]", own.description, defaults.*own.target));
    }
    add_force(*command, options->common);
    add_quiet(*command, options->common);
    add_threads(*command, options->common);
    set_example(*command, "acapfeat generate arm -o arm --frames 60 --seed 0");
    command->callback([options] { run_generate(*options); });
}

void run_generate(const GenerateCommand& options) {
    const auto generator = std::ranges::find_if(
        generators(), [&](const Generator& each) { return options.name == each.name; });
    if (generator == generators().end()) {
        throw UsageError(fmt::format("there is no generator named {}", options.name));
    }
    refuse_foreign_options(*generator, options);
    const int frames = options.frames.value_or(generator->frames);
    const int vertices = options.vertices.value_or(generator->vertices);
    refuse_absurd_size(*generator, frames, vertices);
    require_extension(options.output, "a folder", {});
    require_free_folder(options.output, options.common.force);
    const GeneratedSequence generated = generator->make(frames, vertices, options);
    write_generated(generated, options.output);
    print_out("{}: {} of {} and what they are made of\n", options.output,
              number_of_shapes(generated.sequence.shape_count()), options.name);
}

}  // namespace mscomp
