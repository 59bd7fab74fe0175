// SPDX-License-Identifier: MIT
#include "mscomp/kinds/kinds.h"

#include <fmt/format.h>

#include <algorithm>

#include "mscomp/base/error.h"
#include "mscomp/multiscale/multiscale.h"
#include "mscomp/nn/kinds.h"
#include "mscomp/units/units.h"

namespace mscomp {

Kind pca();  // src/baselines

// A row makes a kind known to the configuration, to training and to every command.
const std::vector<Kind>& all_kinds() {
    static const std::vector<Kind> kinds{
        multiscale(), nn::stacked_attention(), nn::autoencoder(), nn::spectral_vae(), units(),
        pca(),
    };
    return kinds;
}

std::vector<std::string> kind_names() {
    std::vector<std::string> names;
    for (const Kind& kind : all_kinds()) names.push_back(kind.name);
    return names;
}

const Kind& kind_named(const std::string& name) {
    const auto found = std::ranges::find(all_kinds(), name, &Kind::name);
    if (found != all_kinds().end()) return *found;
    throw UsageError(fmt::format("unknown model kind \"{}\"; known kinds: {}", name,
                                 fmt::join(kind_names(), ", ")));
}

Config default_config(const std::string& kind) {
    Config config;
    config.kind = kind;
    kind_named(kind).set_defaults(config);
    return config;
}

}  // namespace mscomp
