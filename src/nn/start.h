// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>

#include "nn/spectral_vae.h"
#include "nn/stacked_model.h"

namespace mscomp::nn {

/// All parameters from N(0, 0.02^2), biases zero ([A] §4.4).
template <class T>
void start_random(StackedModel<T>& model, std::uint64_t seed);

/// Deflation start (method §7): convolutions are the identity on the vertex itself, component
/// weights are found one after the other on what is left of the autoencoder's input: around the
/// vertex with the largest remaining energy, by power iterations inside the sparsity range, rows of
/// unit length. No random numbers, no dead or duplicate components, exact supports from the first
/// step. Children are started on their masked residual. Uses up to 256 of `shapes`, evenly chosen,
/// whatever the batch. Once the input is explained the other components stay zero.
template <class T>
void start_deflation(StackedModel<T>& model, const ScaledFeatures& features,
                     std::span<const int> shapes);

/// The spectral VAE likewise: theta_0 is the identity and the other filters are zero, components
/// act inside the initial range, and C_std is zero: the spread is its offset.
template <class T>
void start_random(SpectralVae<T>& model, std::uint64_t seed);
template <class T>
void start_deflation(SpectralVae<T>& model, const ScaledFeatures& features,
                     std::span<const int> shapes);

/// The same with `features` (N,V,9) in memory, scaled already.
template <class T>
void start_deflation(StackedModel<T>& model, std::span<const float> features,
                     std::span<const int> shapes) {
    const MemoryFeatures memory(features, model.vertex_count());
    start_deflation(model, ScaledFeatures{memory}, shapes);
}

}  // namespace mscomp::nn
