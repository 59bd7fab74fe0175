// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "mscomp/linear/block_cholesky.h"

namespace mscomp {

/// One vertex of eight shapes side by side: features, or (3,3) matrices row by row.
using NineLanes = std::array<Lanes<8>, 9>;

/// What T = exp(r) S needs of r: of half the angle |r| / 2 the sine and cosine.
struct TurnLanes {
    Lanes<8> half, sine, cosine;
};
TurnLanes turns_of_features(const NineLanes& features);

/// T - 1. A lane's bits do not depend on the others, here and below.
void gradient_changes(const NineLanes& features, const TurnLanes& turns, NineLanes& changes);

/// dE/d(r, S) from dE/dT, so that <dE/dT, dT> = <by_feature, d(r, S)> for dT = [J_l(r) dr]x T +
/// exp(r) dS: a channel beside the diagonal stands for two entries of S. Accurate near r = 0 and of
/// any length of r.
void feature_adjoint(const NineLanes& features, const TurnLanes& turns,
                     const NineLanes& by_gradient, NineLanes& by_feature);

}  // namespace mscomp
