// SPDX-License-Identifier: MIT
// The table of the spectral kernels of one instruction set; see kernels_impl.h for what has to be
// defined.
#include "spectral_impl.h"

namespace mscomp::nn::MSCOMP_ISA {

template <class T>
constexpr int register_width() {
    return MSCOMP_VECTOR_BYTES / static_cast<int>(sizeof(T));
}
template <class T>
using Whole = typename VectorOf<T, register_width<T>()>::type;
/// For lanes that do not fill the register (they are a multiple of 8).
template <class T>
using Eight = typename VectorOf<T, (register_width<T>() > 8 ? 8 : register_width<T>())>::type;

// Chooses the register by the numbers per row: an argument list, twice.
#define MSCOMP_BY_SIZE(size, name, ...)                                 \
    ((size) % register_width<T>() == 0 ? name<T, Whole<T>>(__VA_ARGS__) \
                                       : name<T, Eight<T>>(__VA_ARGS__))

template <class T>
SpectralKernels<T> spectral_table() {
    SpectralKernels<T> t;
    t.instruction_set = MSCOMP_ISA_NAME;
    t.laplacian = [](const GraphMatrix<T>& matrix, const T* x, int row, T scale, const T* previous,
                     int begin, int end, T* out) {
        MSCOMP_BY_SIZE(row, laplacian, matrix, x, row, scale, previous, begin, end, out);
    };
    t.filter = [](const T* const* terms, int order, const T* theta, bool use_tanh, int lanes,
                  int count, T* y) {
        MSCOMP_BY_SIZE(lanes, filter, terms, order, theta, use_tanh, lanes, count, y);
    };
    t.outer_9x9 = [](const T* left, const T* right, int lanes, int count, T* sums) {
        MSCOMP_BY_SIZE(lanes, outer_9x9, left, right, lanes, count, sums);
    };
    t.tanh_slope = [](const T* y, std::int64_t count, T* slope) {
        MSCOMP_BY_SIZE(count, tanh_slope, y, count, slope);
    };
    t.error_slope = [](const T* x, const T* lane_weight, T factor, int lanes, int count, T* y) {
        return MSCOMP_BY_SIZE(lanes, error_slope, x, lane_weight, factor, lanes, count, y);
    };
    t.project = [](const T* weights, std::int64_t stride, int components, const T* rows, int lanes,
                   int count, Ahead& ahead, T* codes) {
        MSCOMP_BY_SIZE(lanes, project, weights, stride, components, rows, lanes, count, ahead,
                       codes);
    };
    t.expand = [](const T* weights, std::int64_t stride, int components, const T* codes, int lanes,
                  int count, bool accumulate, Ahead& ahead, T* rows) {
        MSCOMP_BY_SIZE(lanes, expand, weights, stride, components, codes, lanes, count, accumulate,
                       ahead, rows);
    };
    t.outer = &outer<T, Whole<T>>;
    t.lengths = &lengths<T>;
    t.outside = &outside<T>;
    t.shrink = &shrink<T>;
    return t;
}

#undef MSCOMP_BY_SIZE

template SpectralKernels<float> spectral_table<float>();
template SpectralKernels<double> spectral_table<double>();

}  // namespace mscomp::nn::MSCOMP_ISA
