// SPDX-License-Identifier: MIT
#include "units/weighted_squares.h"

#include "mscomp/base/index.h"
#include "units/weighted_sums.h"

namespace mscomp {

using Eigen::Index;
using Eigen::MatrixXd;

static_assert(WeightedSquares::kLanes == kWeights);

WeightedSquares::WeightedSquares(const MatrixXd& places, int width)
    : directions_(static_cast<int>(places.cols())), at_places_(at(places.rows() / width)) {
    const Index count = places.cols() * (places.cols() + 1) / 2;
    const Index groups = (count + kTogether - 1) / kTogether;
    squares_.assign(at(groups * kTogether) * at_places_, 0.0);
    Index entry = 0;
    for (Index b = 0; b < places.cols(); ++b) {
        for (Index a = b; a < places.cols(); ++a, ++entry) {
            double* to = squares_.data() + at(entry / kTogether * kTogether) * at_places_ +
                         at(entry % kTogether);
            for (std::size_t i = 0; i < at_places_; ++i) {
                const Index from = static_cast<Index>(i) * width;
                to[kTogether * i] =
                    places.col(a).segment(from, width).dot(places.col(b).segment(from, width));
            }
        }
    }
}

void WeightedSquares::add_up(const double* weights, double* sums) const {
    add_weighted(squares_.data(), squares_.size() / at_places_, at_places_, weights, sums);
}

void WeightedSquares::lower(const double* sums, int lane, MatrixXd& to) const {
    const double* from = sums + lane;
    for (Index b = 0; b < directions_; ++b) {
        for (Index a = b; a < directions_; ++a, from += kLanes) to(a, b) = *from;
    }
}

}  // namespace mscomp
