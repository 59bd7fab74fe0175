// SPDX-License-Identifier: MIT
// Shapes made of units that switch on and off.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "mscomp/base/random.h"

namespace mscomp::cases {

/// Codes (shapes,units) from 0 to 1, each unit on in about one shape of four.
inline Eigen::MatrixXd switching_codes(int shapes, int units) {
    const CounterRandom is_on(3, 1), how_much(3, 2);
    Eigen::MatrixXd codes(shapes, units);
    for (Eigen::Index i = 0; i < codes.size(); ++i) {
        const auto n = static_cast<std::uint64_t>(i);
        codes.data()[i] = is_on.uniform(n) < 0.25 ? 0.3 + 0.7 * how_much.uniform(n) : 0.0;
    }
    return codes;
}

/// For each column of `wanted` the |cosine| of the nearest column of `found`.
inline Eigen::VectorXd nearest_cosines(const Eigen::MatrixXd& wanted,
                                       const Eigen::MatrixXd& found) {
    return (wanted.colwise().normalized().transpose() * found.colwise().normalized())
        .cwiseAbs()
        .rowwise()
        .maxCoeff();
}

}  // namespace mscomp::cases
