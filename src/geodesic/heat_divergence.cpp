// SPDX-License-Identifier: MIT
#include "heat_divergence.h"

#include <math.h>

#include "mscomp/base/index.h"
#include "mscomp/base/vector_widths.h"

// Products and sums stay apart in this file, so that vectors of any width give the same bits.

namespace mscomp {
namespace {

constexpr double kLargest = 1.7976931348623157e308;

template <std::size_t kLanes>
[[gnu::always_inline]] inline void add_all(std::span<const FlatTriangle> triangles,
                                           const double* heat, double* divergence) {
    for (const FlatTriangle& triangle : triangles) {
        const std::size_t p = at(triangle.corners[0]) * kLanes;
        const std::size_t q = at(triangle.corners[1]) * kLanes;
        const std::size_t r = at(triangle.corners[2]) * kLanes;
        double at_q[kLanes], at_r[kLanes];
#pragma omp simd
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
            const double along = (heat[q + lane] - heat[p + lane]) / triangle.base;
            const double across =
                (heat[r + lane] - heat[p + lane] - triangle.x * along) / triangle.y;
            // Dividing by the larger part first keeps the squares inside the range of double.
            const double size_along = along < 0 ? -along : along;
            const double size_across = across < 0 ? -across : across;
            const double larger = size_across > size_along ? size_across : size_along;
            const double reciprocal = 1 / larger;
            const double scale = reciprocal <= kLargest ? reciprocal : 0.0;
            const double gx = along * scale;
            const double gy = across * scale;
            const double norm = sqrt(gx * gx + gy * gy);
            const double divisor = norm > 0 ? norm : 1.0;
            const double ux = -gx / divisor;
            const double uy = -gy / divisor;
            at_q[lane] = 0.5 * (triangle.y * ux - triangle.x * uy);
            at_r[lane] = 0.5 * triangle.base * uy;
        }
        // Corners may coincide: one after the other.
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
            divergence[p + lane] -= at_q[lane] + at_r[lane];
        }
        for (std::size_t lane = 0; lane < kLanes; ++lane) divergence[q + lane] += at_q[lane];
        for (std::size_t lane = 0; lane < kLanes; ++lane) divergence[r + lane] += at_r[lane];
    }
}

MSCOMP_FOR_EACH_VECTOR_WIDTH
void add_1(std::span<const FlatTriangle> triangles, const double* heat, double* divergence) {
    add_all<1>(triangles, heat, divergence);
}
MSCOMP_FOR_EACH_VECTOR_WIDTH
void add_4(std::span<const FlatTriangle> triangles, const double* heat, double* divergence) {
    add_all<4>(triangles, heat, divergence);
}
MSCOMP_FOR_EACH_VECTOR_WIDTH
void add_8(std::span<const FlatTriangle> triangles, const double* heat, double* divergence) {
    add_all<8>(triangles, heat, divergence);
}

}  // namespace

void add_divergence(std::span<const FlatTriangle> triangles, const double* heat, double* divergence,
                    std::size_t lanes) {
    (lanes == 1 ? add_1 : lanes == 4 ? add_4 : add_8)(triangles, heat, divergence);
}

}  // namespace mscomp
