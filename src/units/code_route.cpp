// SPDX-License-Identifier: MIT
#include "units/code_route.h"

#include <utility>

namespace mscomp {

UnitCodes code_route(const Eigen::MatrixXd& gram, const ShapeBasis& basis, double noise) {
    // Beyond, least squares of codes that are never negative leaves units that are none.
    constexpr double kMostUnexplained = 0.2;
    if (basis.sizes.size() == 0) return {Eigen::MatrixXd(gram.rows(), 0), {}};
    UnitCodes units = without_predicted(agreed(quiet_codes(basis, noise)));
    if (unexplained(gram, units.codes) > kMostUnexplained) return units;
    return refitted(gram, std::move(units));
}

}  // namespace mscomp
