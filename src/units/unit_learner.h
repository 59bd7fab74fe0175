// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "mscomp/model/learned_model.h"
#include "multiscale/metric_rows.h"
#include "units/found_units.h"
#include "units/turning_components.h"
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
    /// Unscaled features (V,9) of training shape m as another model says; none: as they are.
    using Feature = std::function<std::vector<float>(int m)>;

    MetricRows rows() const;
    double squares_left_by_model();
    void begin(MetricRows rows, const Eigen::MatrixXd& gram, const Feature& said);
    std::vector<float> feature(int m) const;
    void note(const FoundUnits& found, const FoundUnits& other, bool turning);
    std::vector<int> strongest(const std::vector<double>& movements) const;
    void take_switching(const MetricRows& rows, const FoundUnits& found);
    void take_turning(MetricRows rows, const TurningShapes& shapes, const FoundUnits& found);

    UnitModel& model_;
    const UnitSettings& settings_;
    const ShapeSet& shapes_;
    std::vector<int> train_;
    TrainingState state_;
    std::vector<std::string> notes_, warnings_;
};

}  // namespace mscomp
