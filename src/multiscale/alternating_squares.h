// SPDX-License-Identifier: MIT
#pragma once

#include "mscomp/base/mesh_data.h"
#include "multiscale/ball_components.h"
#include "multiscale/metric_rows.h"

namespace mscomp {

/// One round of alternating least squares (method §9, stage A): the joint codes Z of all shapes,
/// then at each vertex, with G = Σ z zᵀ and A the components that act there, C_v = (G_AA + damping
/// (tr G / K) I)⁻¹ Z_A x_v; then every component has unit length again. Returns the squared error
/// that the codes had with the components before, mean over the shapes. The same bits for any
/// number of threads.
double alternate(const MetricRows& rows, double damping, BallComponents& components, const OneRings& rings, std::span<const float> roots);

}  // namespace mscomp
