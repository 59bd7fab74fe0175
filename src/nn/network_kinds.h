// SPDX-License-Identifier: MIT
// What the kinds that are networks have in common.
#pragma once

#include "mscomp/model/kind.h"
#include "mscomp/nn/tied.h"

namespace mscomp::nn {

/// The keys of training by gradients.
Table network_train_keys(TrainConfig& train);

Choice tied_choice(Tied& tied);

/// Most shapes of a forward pass of a model that is made for `place`.
int batch_for(const TrainConfig& train, const ModelPlace& place);

/// Options that every network has.
template <class Options>
Options options_for(const Config& config, const ModelPlace& place) {
    Options options;
    options.batch = batch_for(config.train, place);
    options.losses = place.use == ModelUse::training;
    options.sparsity_gradient =
        place.use == ModelUse::training && config.train.sparsity_step == SparsityStep::subgradient;
    return options;
}

}  // namespace mscomp::nn
