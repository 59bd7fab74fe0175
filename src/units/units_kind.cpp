// SPDX-License-Identifier: MIT
#include <memory>

#include "mscomp/model/counts.h"
#include "mscomp/units/units.h"
#include "units/unit_model.h"

namespace mscomp {
namespace {

KindKeys keys(Config& config) {
    auto& own = config.own<UnitSettings>();
    return {"Components that are one thing each.",
            {{"components", &own.components, Bounds{0, kMostUnits},
              "at most so many, those that move most; 0: as many as are found"},
             {"rows",
              choice(own.rows,
                     {{ShapeRows::features, "features"}, {ShapeRows::positions, "positions"}}),
              {},
              "what they change; positions: plain, whatever data.scale and data.metric"},
             {"route",
              choice(own.route, {{UnitRoute::automatic, "auto"},
                                 {UnitRoute::codes, "codes"},
                                 {UnitRoute::space, "space"}}),
              {},
              "how they are looked for; codes: as what rests in most shapes; space: as joints, "
              "turns along few edges, of features; auto: codes where their units are of a place, "
              "else what is read better in shapes left out"}},
            "",
            {},
            {{"start",
              &config.train.start_run,
              {},
              "a run whose components say what the shapes are; empty: the shapes themselves"}}};
}

void set_defaults(Config& config) {
    config.settings = UnitSettings{};
    config.data.metric = FeatureMetric::area;
    config.train.epochs = 1;
    config.train.plateau_epochs = 0;
    config.train.fill_up_to = 0;
    // Votes choose them: none is there that is worth nothing.
    config.filter.rule = FilterRule::strength;
    config.filter.minimum_strength = 0;
    config.filter.minimum_share = 0;
}

std::unique_ptr<LearnedModel> make(const Config& config, const ModelPlace& place) {
    return std::make_unique<UnitModel>(config, place);
}

ShapeRows rows(const Config& config) { return config.own<UnitSettings>().rows; }

}  // namespace

Kind units() { return {"units", rows, set_defaults, keys, make, false}; }

}  // namespace mscomp
