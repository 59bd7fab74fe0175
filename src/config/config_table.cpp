// SPDX-License-Identifier: MIT
#include "config_table.h"

#include <utility>

#include "mscomp/kinds/kinds.h"
#include "mscomp/model/counts.h"

namespace mscomp {
namespace {

Choice kind_choice(std::string& kind) {
    std::vector<std::pair<std::string, std::string>> kinds;
    for (const std::string& name : kind_names()) kinds.emplace_back(name, name);
    return choice(kind, std::move(kinds));
}

Table model_table(std::string& kind, Table own) {
    Table table{{"kind", kind_choice(kind), {}, "what is trained"}};
    append(table, std::move(own));
    return table;
}

Table split_table(SplitConfig& split) {
    return {
        {"train",
         choice(split.train, {{SplitKind::all, "all"},
                              {SplitKind::every, "every"},
                              {SplitKind::random, "random"},
                              {SplitKind::file, "file"}}),
         {},
         "which shapes train, the others test"},
        {"step", &split.step, kCount, "every: shapes 0, step, 2 step, ..."},
        {"count", &split.count, kCountOrNone, "random: how many"},
        {"seed", &split.seed, kNotNegative, "random: which"},
        {"path", &split.path, {}, "file: shape indices from 0, one per line"},
    };
}

Table data_table(DataConfig& data, const Kind& kind) {
    Table table{
        {"features", &data.features, {}, "from acapfeat extract; relative to this file"},
        {"split", split_table(data.split), {}, "Which shapes the model is trained on."},
    };
    // A kind whose settings say what it works on is read before they are known.
    if (kind.rows(default_config(kind.name)) != ShapeRows::features) return table;
    if (kind.has_center) {
        append(
            table,
            {{"center",
              choice(data.center, {{Scaling::reference, "reference"}, {Scaling::minmax, "minmax"}}),
              {},
              "what maps to zero; minmax: the papers"}});
    }
    append(table,
           {{"scale",
             choice(data.scale, {{Scale::shared, "shared"},
                                 {Scale::separate, "separate"},
                                 {Scale::robust, "robust"}}),
             {},
             "factors of rotation and stretch around the reference; robust: but for few vertices"},
            {"metric",
             choice(data.metric,
                    {{FeatureMetric::vertices, "vertices"}, {FeatureMetric::area, "area"}}),
             {},
             "what an error counts as: the same everywhere, or the area around its vertex"}});
    return table;
}

Table filter_table(FilterConfig& filter) {
    return {
        {"rule",
         choice(filter.rule, {{FilterRule::refit, "refit"}, {FilterRule::strength, "strength"}}),
         {},
         "refit: those that the others make up for; strength, the papers: those that move little"},
        {"refit_share", &filter.refit_share, kUnitRange,
         "refit: so much more squared error of the training shapes in all, as a part of it"},
        {"alike", &filter.alike, kUnitRange,
         "refit: correlation of codes, or cosine of changes, from which two may become one"},
        {"minimum_strength", &filter.minimum_strength, kNotNegative,
         "strength: weaker ones are dropped"},
        {"minimum_share", &filter.minimum_share, kUnitRange,
         "strength: and those weaker than this part of the strongest; the paper: 0"},
        {"relative_threshold", &filter.relative_threshold, kUnitRange,
         "part of the peak from which a vertex counts"},
        {"absolute_threshold", &filter.absolute_threshold, kNotNegative,
         "> 0 replaces the relative one; the paper: 1.0e-6"},
    };
}

std::string filter_comment(ShapeRows rows) {
    return rows == ShapeRows::features
               ? "Which components are worth keeping, in unscaled features."
               : "Which components are worth keeping, as parts of the radius of the reference.";
}

}  // namespace

Table config_table(Config& config) {
    const Kind& kind = kind_named(config.kind);
    KindKeys own = kind.keys(config);
    Table table{{"model", model_table(config.kind, std::move(own.model)), {}, own.model_comment}};
    if (!own.loss.empty()) table.push_back({"loss", std::move(own.loss), {}, own.loss_comment});
    table.push_back({"data", data_table(config.data, kind), {}, "What it is trained on."});
    if (!own.train.empty()) {
        table.push_back({"train", std::move(own.train), {}, "How it is trained."});
    }
    table.push_back({"filter", filter_table(config.filter), {}, filter_comment(kind.rows(config))});
    return table;
}

}  // namespace mscomp
