// SPDX-License-Identifier: MIT
#include "units/weighted_sums.h"

#include "mscomp/base/vector_widths.h"

// Products and sums stay apart in this file: a lane gets the same bits in vectors of any width.

namespace mscomp {
namespace {

constexpr std::size_t kAtOnce = 8;                 // lanes of a vector
constexpr std::size_t kVectors = 2;                // as many sums as there are registers for
constexpr std::size_t kPart = kAtOnce * kVectors;  // weights of a sweep over the places
using Lanes8 __attribute__((vector_size(64))) = double;

MSCOMP_FOR_EACH_VECTOR_WIDTH
void add_group(const double* numbers, std::size_t places, const double* weights, double* sums) {
    for (std::size_t first = 0; first < kWeights; first += kPart) {
        Lanes8 sum[kTogether][kVectors] = {};
        for (std::size_t i = 0; i < places; ++i) {
            Lanes8 weight[kVectors];
            __builtin_memcpy(weight, weights + i * kWeights + first, sizeof weight);
            for (std::size_t k = 0; k < kTogether; ++k) {
                for (std::size_t v = 0; v < kVectors; ++v) {
                    sum[k][v] += numbers[i * kTogether + k] * weight[v];
                }
            }
        }
        for (std::size_t k = 0; k < kTogether; ++k) {
            __builtin_memcpy(sums + k * kWeights + first, sum[k], sizeof sum[k]);
        }
    }
}

}  // namespace

void add_weighted(const double* numbers, std::size_t count, std::size_t places,
                  const double* weights, double* sums) {
    for (std::size_t k = 0; k < count; k += kTogether) {
        add_group(numbers + k * places, places, weights, sums + k * kWeights);
    }
}

}  // namespace mscomp
