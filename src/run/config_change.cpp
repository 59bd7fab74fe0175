// SPDX-License-Identifier: MIT
#include "mscomp/run/config_change.h"

#include "mscomp/config/config_file.h"

namespace mscomp {
namespace {

/// The configuration as text without what a training may change on its way.
std::string decisive(Config config) {
    const TrainConfig any;
    config.train.epochs = any.epochs;
    config.train.plateau_epochs = any.plateau_epochs;
    config.train.plateau_gain = any.plateau_gain;
    config.train.checkpoint_every = any.checkpoint_every;
    config.filter = {};
    return write_config(config, false);
}

}  // namespace

ConfigChange config_change(const Config& earlier, const Config& now) {
    const TrainConfig &a = earlier.train, &b = now.train;
    ConfigChange change;
    change.training = decisive(earlier) != decisive(now);
    change.stopping = a.plateau_epochs != b.plateau_epochs || a.plateau_gain != b.plateau_gain;
    change.length = a.epochs != b.epochs;
    change.saving = a.checkpoint_every != b.checkpoint_every;
    change.filter = earlier.filter != now.filter;
    return change;
}

}  // namespace mscomp
