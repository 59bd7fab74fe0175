// SPDX-License-Identifier: MIT
#pragma once

#include "mscomp/model/kind.h"
#include "mscomp/nn/config.h"
#include "mscomp/nn/spectral_config.h"

namespace mscomp::nn {

/// The kinds that are networks; settings are StackedSettings for the first two, SpectralSettings
/// for the third.
Kind stacked_attention();
Kind autoencoder();
Kind spectral_vae();

}  // namespace mscomp::nn
