// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "mscomp/base/metric_scale.h"
#include "multiscale/ball_components.h"
#include "multiscale/metric_rows.h"
#include "multiscale/space_error.h"

namespace mscomp {

/// What descent in space knows between two epochs.
struct SpaceState {
    Eigen::MatrixXd codes;                // (K,shapes) that fit the positions
    std::vector<float> moment1, moment2;  // of Adam, beside the values of the components
    std::int64_t steps = 0;
};

/// Lowers mean E + share F over some shapes (method §9, stage B): E the error in space at codes of
/// its own, F the squared error of the features at joint codes, as many times as makes both equal
/// at first. Components follow their gradient by Adam, codes by Gauss-Newton steps.
class SpaceDescent {
  public:
    /// Borrows rows and scale.
    SpaceDescent(const TriangleMesh& reference, const std::string& weights,
                 const MetricScale& scale, const MetricRows& rows, double feature_share);

    /// At the joint codes.
    SpaceState begin(const BallComponents& components) const;
    /// Means over the shapes and the steps of one epoch.
    struct Report {
        double space = 0, features = 0;  // E and F as they are
        double total = 0;
        double first = 0;  // the total before the first step
    };
    /// Normal matrices anew, then kSteps steps at `rate` times what is usual.
    Report run_epoch(double rate, BallComponents& components, SpaceState& state) const;

    static constexpr int kSteps = 25;

  private:
    class Codes;
    double step_size(const BallComponents& components, double features) const;
    void update(double rate, const std::vector<float>& gradient, BallComponents& components,
                SpaceState& state) const;

    const MetricScale& scale_;
    const MetricRows& rows_;
    SpaceError error_;
    LosslessReconstruction lossless_;
    double feature_share_;
    double energy_;  // mean squared size of a shape
};

}  // namespace mscomp
