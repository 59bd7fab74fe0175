// SPDX-License-Identifier: MIT
#include "nn/network_kinds.h"

#include <algorithm>

#include "mscomp/model/counts.h"
#include "nn/trainer.h"

namespace mscomp::nn {

Table network_train_keys(TrainConfig& train) {
    return {
        {"epochs", &train.epochs, kCount, "passes over the training shapes"},
        {"batch", &train.batch, kCount, "shapes per step, at most all"},
        {"learning_rate", &train.learning_rate, kPositive,
         "of Adam, at the start; the papers: 0.001"},
        {"learning_rate_decay", &train.learning_rate_decay, kPositiveUpToOne, "factor per decay"},
        {"decay_steps", &train.decay_steps, kCount, "steps between two decays"},
        {"learning_rate_floor", &train.learning_rate_floor, kNotNegative, "never below"},
        {"seed", &train.seed, kNotNegative, "of batches and of the random start"},
        {"start",
         choice(train.start, {{Start::deflation, "deflation"}, {Start::random, "random"}}),
         {},
         "first components: from the data or at random"},
        {"sparsity_step",
         choice(train.sparsity_step,
                {{SparsityStep::proximal, "proximal"}, {SparsityStep::subgradient, "subgradient"}}),
         {},
         "proximal: exact zeros; subgradient: the papers"},
        {"supports", &train.supports, {}, "leave out vertices where nothing acts: faster"},
        {"fill_up_to", &train.fill_up_to, Bounds{0, 4096},
         "fewer shapes are joined by locally mixed ones; 0: never"},
        {"fill_below", &train.fill_below, Bounds{0, 4096}, "but so many shapes and more never"},
        {"plateau_epochs", &train.plateau_epochs, kCountOrNone,
         "ends when so many epochs gain too little; 0: never"},
        {"plateau_gain", &train.plateau_gain, kUnitRange, "part of the error that is too little"},
        {"checkpoint_every", &train.checkpoint_every, kCount, "epochs; the last always"},
    };
}

Choice tied_choice(Tied& tied) {
    return choice(tied,
                  {{Tied::transpose, "transpose"}, {Tied::same, "same"}, {Tied::none, "none"}});
}

int batch_for(const TrainConfig& train, const ModelPlace& place) {
    if (place.use == ModelUse::reading) return place.shapes;
    return std::min(train.batch, epoch_size(train, place.shapes, place.reference.vertex_count()));
}

}  // namespace mscomp::nn
