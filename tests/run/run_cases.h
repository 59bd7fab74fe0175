// SPDX-License-Identifier: MIT
// A small set of shapes and configurations to train on it, for tests of runs.
#pragma once

#include <string>

#include "base/temporary_folder.h"
#include "mscomp/acap/extract.h"
#include "mscomp/acap/feature_file.h"
#include "mscomp/generate/generate.h"
#include "mscomp/kinds/kinds.h"
#include "mscomp/nn/kinds.h"

namespace mscomp::cases {

/// A generated arm of `frames` frames, extracted to `path`.
inline std::string extracted_arm(const std::string& path, int frames = 9) {
    const GeneratedSequence arm = generate_arm(frames, 3, 300);
    write_features(path, extract_features(arm.sequence, arm.sequence.shapes.front()));
    return path;
}

/// A few epochs of few components; every other shape trains.
inline Config small_config(const std::string& kind, const std::string& features) {
    Config config = default_config(kind);
    config.data.features = features;
    config.data.split.train = SplitKind::every;
    config.data.split.step = 2;
    if (auto* stacked = std::any_cast<nn::StackedSettings>(&config.settings)) {
        for (nn::LevelConfig& level : stacked->model.levels) level.components = 2;
    }
    if (auto* spectral = std::any_cast<nn::SpectralSettings>(&config.settings)) {
        spectral->model.components = 3;
    }
    if (kind_named(kind).rows(config) == ShapeRows::features) config.train.epochs = 3;
    config.train.fill_up_to = 0;
    return config;
}

}  // namespace mscomp::cases
