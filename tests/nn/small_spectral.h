// SPDX-License-Identifier: MIT
// The small training problem for the spectral VAE.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "nn/spectral_vae.h"
#include "small_training.h"

namespace mscomp::nn {

template <class T>
std::unique_ptr<SpectralVae<T>> make_vae(SmallTraining& problem) {
    typename SpectralVae<T>::Options options;
    options.batch =
        std::min(problem.config.train.batch,
                 epoch_size(problem.config.train, static_cast<int>(problem.shapes.size()),
                            problem.mesh.vertex_count()));
    options.sparsity_gradient = problem.config.train.sparsity_step == SparsityStep::subgradient;
    return std::make_unique<SpectralVae<T>>(
        problem.config.spectral, problem.config.spectral_loss,
        one_rings_of_faces(problem.mesh.vertex_count(), problem.mesh.faces),
        std::span<const double>{}, problem.distances, options);
}

}  // namespace mscomp::nn
