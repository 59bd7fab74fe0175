// SPDX-License-Identifier: MIT
#pragma once

#include "mscomp/model/config.h"

namespace mscomp {

/// What of a configuration differs from that of an earlier training: the one rule of which key
/// decides what. A feature file that has moved is another one, whatever it holds.
struct ConfigChange {
    bool training = false;  // another training altogether
    bool stopping = false;  // train.plateau_epochs, train.plateau_gain: it may end elsewhere
    bool length = false;    // train.epochs
    bool saving = false;    // train.checkpoint_every
    bool filter = false;    // which components are kept; nothing is trained anew

    /// Whether training may go on from where the earlier one came to.
    bool may_go_on() const { return !training; }
    /// Whether that ends where training from the start would, as far as it is not longer.
    bool same_result() const { return !training && !stopping; }
};

ConfigChange config_change(const Config& earlier, const Config& now);

}  // namespace mscomp
