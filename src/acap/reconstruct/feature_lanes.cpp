// SPDX-License-Identifier: MIT
#include "feature_lanes.h"

#include <cmath>

#include "mscomp/base/vector_widths.h"

// Products and sums stay apart in this file, so that a lane gets the same bits in vectors of any
// width. As in rotation_exp and rotation_left_jacobian.

namespace mscomp {
namespace {

struct Vector {
    double x, y, z;
};

[[gnu::always_inline]] inline Vector cross(const Vector& a, const Vector& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

[[gnu::always_inline]] inline double sine_quotient(double half, double sine) {
    return half > 1e-8 ? sine / half : 1.0;
}

/// exp(r), row by row.
[[gnu::always_inline]] inline void rotation(const Vector& r, double half, double sine,
                                            double cosine, double (&result)[9]) {
    const double factor = 0.5 * sine_quotient(half, sine);
    const double x = factor * r.x, y = factor * r.y, z = factor * r.z, w = cosine;
    result[0] = 1 - 2 * (y * y + z * z);
    result[1] = 2 * (x * y - w * z);
    result[2] = 2 * (x * z + w * y);
    result[3] = 2 * (x * y + w * z);
    result[4] = 1 - 2 * (x * x + z * z);
    result[5] = 2 * (y * z - w * x);
    result[6] = 2 * (x * z - w * y);
    result[7] = 2 * (y * z + w * x);
    result[8] = 1 - 2 * (x * x + y * y);
}

/// J_l(r)ᵀ w.
[[gnu::always_inline]] inline Vector transposed_left_jacobian(const Vector& r, double half,
                                                              double sine, double cosine,
                                                              const Vector& w) {
    const double quotient = sine_quotient(half, sine);
    const double first = 0.5 * quotient * quotient;
    const double angle = 2 * half, square = angle * angle;
    const double far = (angle - 2 * sine * cosine) / (square * angle);
    const double near = 1.0 / 6 - square * (1.0 / 120 - square * (1.0 / 5040 - square / 362880));
    const double second = angle > 0.1 ? far : near;
    const Vector once = cross(r, w), twice = cross(r, once);
    return {w.x - first * once.x + second * twice.x, w.y - first * once.y + second * twice.y,
            w.z - first * once.z + second * twice.z};
}

}  // namespace

TurnLanes turns_of_features(const NineLanes& features) {
    TurnLanes turns;
    for (std::size_t l = 0; l < 8; ++l) {
        const double x = features[0][l], y = features[1][l], z = features[2][l];
        turns.half[l] = 0.5 * std::sqrt(x * x + y * y + z * z);
        turns.sine[l] = std::sin(turns.half[l]);
        turns.cosine[l] = std::cos(turns.half[l]);
    }
    return turns;
}

MSCOMP_FOR_EACH_VECTOR_WIDTH
void gradient_changes(const NineLanes& features, const TurnLanes& turns, NineLanes& changes) {
    const NineLanes& f = features;
#pragma omp simd
    for (std::size_t l = 0; l < 8; ++l) {
        double R[9];
        rotation({f[0][l], f[1][l], f[2][l]}, turns.half[l], turns.sine[l], turns.cosine[l], R);
        for (std::size_t row = 0; row < 3; ++row) {
            const double a = R[3 * row], b = R[3 * row + 1], c = R[3 * row + 2];
            changes[3 * row][l] = a * f[3][l] + b * f[4][l] + c * f[5][l];
            changes[3 * row + 1][l] = a * f[4][l] + b * f[6][l] + c * f[7][l];
            changes[3 * row + 2][l] = a * f[5][l] + b * f[7][l] + c * f[8][l];
        }
        changes[0][l] -= 1;
        changes[4][l] -= 1;
        changes[8][l] -= 1;
    }
}

MSCOMP_FOR_EACH_VECTOR_WIDTH
void feature_adjoint(const NineLanes& features, const TurnLanes& turns,
                     const NineLanes& by_gradient, NineLanes& by_feature) {
    const NineLanes& f = features;
    const NineLanes& g = by_gradient;
#pragma omp simd
    for (std::size_t l = 0; l < 8; ++l) {
        const Vector r{f[0][l], f[1][l], f[2][l]};
        double R[9], by_stretch[9], K[9];  // Rᵀ G, and K = G Sᵀ Rᵀ = G Tᵀ: <G, [w]x T> = <K, [w]x>
        rotation(r, turns.half[l], turns.sine[l], turns.cosine[l], R);
        for (std::size_t row = 0; row < 3; ++row) {
            for (std::size_t column = 0; column < 3; ++column) {
                by_stretch[3 * row + column] = R[row] * g[column][l] +
                                               R[3 + row] * g[3 + column][l] +
                                               R[6 + row] * g[6 + column][l];
            }
            const double a = g[3 * row][l], b = g[3 * row + 1][l], c = g[3 * row + 2][l];
            const double x = a * f[3][l] + b * f[4][l] + c * f[5][l];
            const double y = a * f[4][l] + b * f[6][l] + c * f[7][l];
            const double z = a * f[5][l] + b * f[7][l] + c * f[8][l];
            for (std::size_t column = 0; column < 3; ++column) {
                K[3 * row + column] =
                    x * R[3 * column] + y * R[3 * column + 1] + z * R[3 * column + 2];
            }
        }
        const Vector by_rotation =
            transposed_left_jacobian(r, turns.half[l], turns.sine[l], turns.cosine[l],
                                     {K[7] - K[5], K[2] - K[6], K[3] - K[1]});
        by_feature[0][l] = by_rotation.x;
        by_feature[1][l] = by_rotation.y;
        by_feature[2][l] = by_rotation.z;
        by_feature[3][l] = by_stretch[0];
        by_feature[4][l] = by_stretch[1] + by_stretch[3];
        by_feature[5][l] = by_stretch[2] + by_stretch[6];
        by_feature[6][l] = by_stretch[4];
        by_feature[7][l] = by_stretch[5] + by_stretch[7];
        by_feature[8][l] = by_stretch[8];
    }
}

}  // namespace mscomp
