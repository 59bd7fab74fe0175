// SPDX-License-Identifier: MIT
// The kinds' own settings of a configuration.
#pragma once

#include "mscomp/config/config_file.h"
#include "mscomp/model/config.h"
#include "mscomp/nn/config.h"
#include "mscomp/nn/spectral_config.h"

namespace mscomp {

inline nn::StackedSettings& stacked(Config& c) { return c.own<nn::StackedSettings>(); }
inline const nn::StackedSettings& stacked(const Config& c) { return c.own<nn::StackedSettings>(); }
inline nn::SpectralSettings& spectral(Config& c) { return c.own<nn::SpectralSettings>(); }
inline const nn::SpectralSettings& spectral(const Config& c) {
    return c.own<nn::SpectralSettings>();
}

/// Every field of a configuration, so that equality misses none of those the table has.
inline std::string all_of(const Config& config) { return write_config(config, false); }

}  // namespace mscomp
