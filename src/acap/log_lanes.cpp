// SPDX-License-Identifier: MIT
#include "log_lanes.h"

#include <math.h>

#include "mscomp/base/vector_widths.h"

namespace mscomp {
namespace {

// atan(x) / x for |x| <= tan(π/8), a polynomial in x² through the Chebyshev points: error below
// 2e-18.
constexpr double kArctangent[12] = {1.0,
                                    -0.3333333333333312,
                                    0.19999999999940893,
                                    -0.14285714279250245,
                                    0.11111110744919658,
                                    -0.09090896809064027,
                                    0.07692045330902225,
                                    -0.06662951813629191,
                                    0.05846878297330872,
                                    -0.05035102456601552,
                                    0.03796525745386593,
                                    -0.017805397205419446};
constexpr double kEighthOfTurn = 0.78539816339744830962;
constexpr double kTangentOfSixteenth = 0.41421356237309504880;

/// atan2(y, x) / y for y, x >= 0 and x² + y² = 1.
[[gnu::always_inline]] inline double angle_per_sine(double y, double x) {
    // atan t = π/4 + atan((t - 1) / (t + 1)) brings t = y / x into the range of the polynomial, and
    // 1 / t does where t is above tan(3π/8).
    const double small = y < x ? y : x, large = y < x ? x : y;
    const bool is_middle = small > kTangentOfSixteenth * large;
    const double t = (is_middle ? small - large : small) / (is_middle ? small + large : large);
    const double z = t * t;
    double quotient = kArctangent[11];
    for (int k = 10; k >= 0; --k) quotient = quotient * z + kArctangent[k];
    const double angle = (is_middle ? kEighthOfTurn : 0.0) + t * quotient;
    const double whole = y < x ? angle : 2 * kEighthOfTurn - angle;
    // Without the division where y may be 0.
    const double is_small = y < x && !is_middle ? 1.0 : 0.0;
    return is_small > 0 ? quotient / x : whole / (is_small > 0 ? 1.0 : y);
}

}  // namespace

MSCOMP_FOR_EACH_VECTOR_WIDTH
void rotation_logs(LogLanes& lanes) {
    const auto& r = lanes.rotation;
#pragma omp simd
    for (int l = 0; l < LogLanes::kLanes; ++l) {
        // 4 q qᵀ of the unit quaternion q = (w, x, y, z) is linear in R; its column with the
        // largest entry on the diagonal gives q without cancellation.
        const double ww = 1 + r[0][l] + r[4][l] + r[8][l], xx = 1 + r[0][l] - r[4][l] - r[8][l];
        const double yy = 1 - r[0][l] + r[4][l] - r[8][l], zz = 1 - r[0][l] - r[4][l] + r[8][l];
        const double wx = r[5][l] - r[7][l], wy = r[6][l] - r[2][l], wz = r[1][l] - r[3][l];
        const double xy = r[1][l] + r[3][l], xz = r[2][l] + r[6][l], yz = r[5][l] + r[7][l];
        double largest = ww, w = ww, x = wx, y = wy, z = wz;
        const bool by_x = xx > largest;
        largest = by_x ? xx : largest;
        w = by_x ? wx : w, x = by_x ? xx : x, y = by_x ? xy : y, z = by_x ? xz : z;
        const bool by_y = yy > largest;
        largest = by_y ? yy : largest;
        w = by_y ? wy : w, x = by_y ? xy : x, y = by_y ? yy : y, z = by_y ? yz : z;
        const bool by_z = zz > largest;
        w = by_z ? wz : w, x = by_z ? xz : x, y = by_z ? yz : y, z = by_z ? zz : z;
        // q and -q are one rotation: w >= 0 is the half turn or less.
        const double vector_square = x * x + y * y + z * z;
        const double scale = 1 / sqrt(w * w + vector_square);
        const double sine = scale * sqrt(vector_square);
        const double cosine = scale * (w < 0 ? -w : w);
        const double factor = 2 * (w < 0 ? -scale : scale) * angle_per_sine(sine, cosine);
        lanes.logarithm[0][l] = factor * x;
        lanes.logarithm[1][l] = factor * y;
        lanes.logarithm[2][l] = factor * z;
    }
}

}  // namespace mscomp
