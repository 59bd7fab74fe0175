// SPDX-License-Identifier: MIT
#pragma once

#include "code_trials.h"

namespace mscomp {

struct DescentOptions {
    int max_steps;        // accepted ones
    double least_gain;    // ends when a step lowers the objective by a smaller share of it
    double first_radius;  // the damping is 1 / radius of the diagonal of H
};

/// The radius that damps nothing, as long as Gauss-Newton steps help.
inline constexpr double kUndampedRadius = 1e12;

struct Descent {
    Trial best;
    double initial_error = 0;  // Trial::error of the start
    int steps = 0;
    bool converged = false;
};

/// Levenberg-Marquardt steps from the start to where no code lowers the objective any more, which
/// never rises. Throws NumericalError if the start decodes to what is not finite.
Descent descend(const CodeTrials& trials, const DescentOptions& options);

}  // namespace mscomp
