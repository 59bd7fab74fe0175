// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

#include "mscomp/model/learned_model.h"
#include "multiscale/metric_rows.h"
#include "units/code_route.h"
#include "units/unit_model.h"

namespace mscomp {

/// Finds the units of some shapes at its start; its one epoch measures what they leave.
class UnitLearner final : public Learner {
  public:
    /// Borrows everything but the numbers of the training shapes.
    UnitLearner(UnitModel& model, const UnitSettings& settings, const ShapeSet& shapes,
                std::span<const int> train);

    std::vector<std::string> term_names() const override { return {"reconstruction"}; }
    /// Throws UsageError where shapes are too few, or do not move.
    void start() override;
    void start_from(const GivenComponents& given) override;
    std::vector<std::string> notes() const override { return notes_; }
    std::vector<std::string> warnings() const override { return warnings_; }
    void resume(const TrainingState& state) override { state_ = state; }
    const TrainingState& state() const override { return state_; }
    EpochReport run_epoch() override;
    bool is_over() const override { return state_.epoch >= 1; }
    CodeTable codes() override;

  private:
    MetricRows rows() const;
    void begin(const MetricRows& rows, const Eigen::MatrixXd& gram);
    void take(const MetricRows& rows, const FoundUnits& found);

    UnitModel& model_;
    const UnitSettings& settings_;
    const ShapeSet& shapes_;
    std::vector<int> train_;
    TrainingState state_;
    std::vector<std::string> notes_, warnings_;
};

}  // namespace mscomp
