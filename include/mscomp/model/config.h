// SPDX-License-Identifier: MIT
#pragma once

#include <any>
#include <cstdint>
#include <string>

namespace mscomp {

enum class SplitKind { all, every, random, file };

struct SplitConfig {
    SplitKind train = SplitKind::all;
    int step = 10;           // every: shapes 0, step, 2 step, ... train
    int count = 0;           // random: how many train
    std::uint64_t seed = 0;  // random
    std::string path;        // file: 0-based indices, one per line
};

enum class Scaling { reference, minmax };
enum class Scale { shared, separate, robust };
/// What a squared error of a feature counts as: the same at every vertex, or as the area around it.
enum class FeatureMetric { vertices, area };

struct DataConfig {
    std::string features;  // feature file; relative paths are relative to the config file
    SplitConfig split;
    Scaling center = Scaling::reference;  // of kinds that work on features
    Scale scale = Scale::shared;
    FeatureMetric metric = FeatureMetric::vertices;
};

enum class Start { deflation, random };
enum class SparsityStep { proximal, subgradient };

/// How a model is trained; a kind has those of the keys that mean something to it.
struct TrainConfig {
    int epochs = 500;
    int batch = 256;
    double learning_rate = 3e-3;       // the papers: 1e-3
    double learning_rate_decay = 0.9;  // factor per decay_steps, staircase
    int decay_steps = 4000;
    double learning_rate_floor = 1e-5;
    std::uint64_t seed = 0;
    Start start = Start::deflation;
    std::string start_run;  // whose components are begun with, by kinds that can; empty: none
    SparsityStep sparsity_step = SparsityStep::proximal;
    /// Steps of the last level leave out vertices where nothing acts (the same optimum, faster);
    /// needs the proximal step.
    bool supports = true;
    /// Fewer training shapes than this are joined by mixed ones (learning/mixed_features.h), others
    /// every eight epochs; 0: never. Lanes come in sixteens, so that up to 48 cost what 36 do.
    int fill_up_to = 48;
    int fill_below = 4096;  // so many training shapes and more are never joined by mixed ones
    /// Training ends when the mean error of so many epochs is less than `plateau_gain` of it below
    /// that of as many before; 0: never before the last epoch.
    int plateau_epochs = 100;
    double plateau_gain = 0.005;
    int checkpoint_every = 100;  // epochs; the last one is always saved
};

/// Which components are left out as redundant (docs/components.md).
enum class FilterRule {
    refit,    // those that the others, refitted, make up for
    strength  // those that move little, [A] §4.3
};

/// The redundancy filter. Strengths are in the unit of the model (ShapeModel::unit).
struct FilterConfig {
    FilterRule rule = FilterRule::refit;
    /// refit: what the squared error of the training shapes may grow by in all, as a share of
    /// itself
    double refit_share = 0.1;
    /// refit: components whose codes predict each other so well, or whose changes have such a
    /// cosine, become one, within that share; 1: only what is the same
    double alike = 0.95;
    double minimum_strength = 0.01;    // strength: epsilon_2
    double minimum_share = 0.05;       // strength: the same as a part of the strongest component's;
                                       // paper: 0
    double relative_threshold = 0.01;  // epsilon_1 as a fraction of the component's peak
    double absolute_threshold =
        0.0;  // epsilon_1 itself; > 0 replaces the relative one (paper: 1e-6)

    bool operator==(const FilterConfig&) const = default;
};

/// What is trained and how.
struct Config {
    std::string kind;   // one of the kinds of kinds.h
    std::any settings;  // what is the kind's own, a struct that it declares
    DataConfig data;
    TrainConfig train;
    FilterConfig filter;

    /// The kind's own settings. Throws std::bad_any_cast for those of another kind.
    template <class Settings>
    Settings& own() {
        return std::any_cast<Settings&>(settings);
    }
    template <class Settings>
    const Settings& own() const {
        return std::any_cast<const Settings&>(settings);
    }
};

}  // namespace mscomp
