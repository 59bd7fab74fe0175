// SPDX-License-Identifier: MIT
#include "multiscale/cross_validation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "multiscale/alternating_squares.h"
#include "multiscale/ball_start.h"
#include "multiscale/joint_codes.h"
#include "multiscale/space_error.h"
#include "multiscale/training_pool.h"

namespace mscomp {
namespace {

constexpr int kFolds = 3;

/// The shapes of one fold.
struct Fold {
    std::vector<int> seen, left_out;

    Fold(const std::vector<int>& train, int number) {
        for (std::size_t i = 0; i < train.size(); ++i) {
            (static_cast<int>(i % kFolds) == number ? left_out : seen).push_back(train[i]);
        }
    }
};

BallComponents fitted(const Choices& choices, MultiscaleSettings settings, std::uint64_t seed,
                      const ChoicePlace& place, const ShapeFeatures& shapes,
                      const std::vector<int>& seen) {
    settings.global_components = choices.global_components;
    TrainingPool pool(shapes, seen, place.mirror, place.distances, place.scale,
                      {choices.fill_up_to, seed, settings.between});
    BallComponents components = start_balls(pool.rows(0), settings, place.distances);
    const AlternatingSquares squares(
        one_rings_of_faces(place.reference.vertex_count(), place.reference.faces), place.scale,
        settings.damping);
    for (int round = 0; round < (settings.rounds + 1) / 2; ++round) {
        squares.round(pool.rows(round), components);
    }
    return components;
}

/// Sum of E over the shapes that were left out.
double error_of(const BallComponents& components, const MetricRows& rows, const SpaceError& error) {
    const Eigen::MatrixXd codes = JointCodes(components).solve(products(components, rows));
    const std::vector<double> errors = error.evaluate(components, codes);
    return std::accumulate(errors.begin(), errors.end(), 0.0);
}

}  // namespace

ChosenBySpaceError choose(const std::vector<Choices>& candidates,
                          const MultiscaleSettings& settings, std::uint64_t seed,
                          const ChoicePlace& place, const ShapeFeatures& shapes,
                          const std::vector<int>& train) {
    std::vector<double> sums(candidates.size(), 0.0);
    for (int number = 0; number < kFolds; ++number) {
        const Fold fold(train, number);
        TrainingPool left_out(shapes, fold.left_out, nullptr, place.distances, place.scale, {});
        const MetricRows& rows = left_out.rows(0);
        const SpaceError error(place.reference, place.weights, place.scale, rows);
        for (std::size_t i = 0; i < candidates.size(); ++i) {
            const BallComponents components =
                fitted(candidates[i], settings, seed, place, shapes, fold.seen);
            sums[i] += error_of(components, rows, error);
        }
    }
    ChosenBySpaceError result{candidates[at(std::ranges::min_element(sums) - sums.begin())], {}};
    for (std::size_t i = 0; i < candidates.size(); ++i) {
        result.notes.push_back(fmt::format(
            "cross-validation: {} global components, filled up to {} shapes: E_rms {:.4g}",
            candidates[i].global_components, candidates[i].fill_up_to,
            std::sqrt(sums[i] / static_cast<double>(train.size()))));
    }
    return result;
}

}  // namespace mscomp
