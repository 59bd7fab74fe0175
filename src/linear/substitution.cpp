// SPDX-License-Identifier: MIT
#include "substitution.h"

#include "mscomp/base/index.h"
#include "mscomp/base/vector_widths.h"

// Products and sums stay apart in this file, and every sum has one order, so that a lane gets the
// same bits in vectors of any width.

namespace mscomp {
namespace {

#define MSCOMP_INLINE [[gnu::always_inline]] inline

template <std::size_t kLanes>
struct LaneVector;
template <>
struct LaneVector<1> {
    using Type = double;
};
template <>
struct LaneVector<4> {
    using Type __attribute__((vector_size(32))) = double;
};
template <>
struct LaneVector<8> {
    using Type __attribute__((vector_size(64))) = double;
};

template <std::size_t kLanes>
struct Vector {
    using Type = typename LaneVector<kLanes>::Type;

    MSCOMP_INLINE static const double* of(const double* x, int i) { return x + at(i) * kLanes; }
    MSCOMP_INLINE static double* of(double* x, int i) { return x + at(i) * kLanes; }
    /// x[i] -= value * y
    MSCOMP_INLINE static void subtract(double* x, double value, const Type& y) {
        Type sum;
        __builtin_memcpy(&sum, x, sizeof sum);
        sum -= value * y;
        __builtin_memcpy(x, &sum, sizeof sum);
    }
};

template <std::size_t kLanes>
MSCOMP_INLINE void forward(const SimplicialColumns& factor, double* x) {
    using Lane = Vector<kLanes>;
    typename Lane::Type solved;
    for (std::size_t j = 0; j < factor.size; ++j) {
        __builtin_memcpy(&solved, x + j * kLanes, sizeof solved);
        for (int k = factor.column_begin[j]; k < factor.column_begin[j + 1]; ++k) {
            Lane::subtract(Lane::of(x, factor.row[k]), factor.value[k], solved);
        }
    }
}

template <std::size_t kLanes>
MSCOMP_INLINE void backward(const SimplicialColumns& factor, double* x) {
    using Lane = Vector<kLanes>;
    typename Lane::Type solved, other;
    for (std::size_t j = factor.size; j-- > 0;) {
        __builtin_memcpy(&solved, x + j * kLanes, sizeof solved);
        solved *= factor.inverse_of_diagonal[j];
        for (int k = factor.column_begin[j]; k < factor.column_begin[j + 1]; ++k) {
            __builtin_memcpy(&other, Lane::of(x, factor.row[k]), sizeof other);
            solved -= factor.value[k] * other;
        }
        __builtin_memcpy(x + j * kLanes, &solved, sizeof solved);
    }
}

/// Sums under way at a time: as many as there are registers for, or as hide their latency.
template <std::size_t kLanes>
constexpr int kRowsAtOnce = kLanes == 1 ? 8 : 4;

/// x_row -= Σ_k value_k y_k for `kRows` rows of a block of `width` columns, y (width, kLanes).
template <std::size_t kLanes, int kRows>
MSCOMP_INLINE void subtract_from_rows(const double* value, int width, const int* row,
                                      const double* y, double* x) {
    using Lane = Vector<kLanes>;
    typename Lane::Type sum[kRows], solved;
    for (int r = 0; r < kRows; ++r) {
        __builtin_memcpy(&sum[r], Lane::of(x, row[r]), sizeof solved);
    }
    for (int k = 0; k < width; ++k) {
        __builtin_memcpy(&solved, Lane::of(y, k), sizeof solved);
        for (int r = 0; r < kRows; ++r) {
            sum[r] -= value[at(r) * at(width) + at(k)] * solved;
        }
    }
    for (int r = 0; r < kRows; ++r) {
        __builtin_memcpy(Lane::of(x, row[r]), &sum[r], sizeof solved);
    }
}

/// y_k -= Σ_row value_row,k x_row for `kRows` rows.
template <std::size_t kLanes, int kRows>
MSCOMP_INLINE void subtract_from_columns(const double* __restrict value, int width, const int* row,
                                         const double* x, double* __restrict y) {
    using Lane = Vector<kLanes>;
    typename Lane::Type solved[kRows], sum;
    for (int r = 0; r < kRows; ++r) {
        __builtin_memcpy(&solved[r], Lane::of(x, row[r]), sizeof sum);
    }
    for (int k = 0; k < width; ++k) {
        __builtin_memcpy(&sum, Lane::of(y, k), sizeof sum);
        for (int r = 0; r < kRows; ++r) {
            sum -= value[at(r) * at(width) + at(k)] * solved[r];
        }
        __builtin_memcpy(Lane::of(y, k), &sum, sizeof sum);
    }
}

/// The block's own columns: L y = y.
template <std::size_t kLanes>
MSCOMP_INLINE void solve_diagonal(const double* value, int width, const double* inverse,
                                  double* y) {
    using Lane = Vector<kLanes>;
    typename Lane::Type sum, solved;
    for (int j = 0; j < width; ++j, value += width) {
        __builtin_memcpy(&sum, Lane::of(y, j), sizeof sum);
        for (int k = 0; k < j; ++k) {
            __builtin_memcpy(&solved, Lane::of(y, k), sizeof solved);
            sum -= value[k] * solved;
        }
        sum *= inverse[j];
        __builtin_memcpy(Lane::of(y, j), &sum, sizeof sum);
    }
}

/// The block's own columns: Lᵀ y = y.
template <std::size_t kLanes>
MSCOMP_INLINE void solve_transposed_diagonal(const double* value, int width, const double* inverse,
                                             double* y) {
    using Lane = Vector<kLanes>;
    typename Lane::Type solved;
    for (int j = width; j-- > 0;) {
        __builtin_memcpy(&solved, Lane::of(y, j), sizeof solved);
        solved *= inverse[j];
        __builtin_memcpy(Lane::of(y, j), &solved, sizeof solved);
        const double* row = value + at(j) * at(width);
        for (int k = 0; k < j; ++k) Lane::subtract(Lane::of(y, k), row[k], solved);
    }
}

template <std::size_t kLanes>
MSCOMP_INLINE void forward(const SupernodalRows& factor, double* x) {
    constexpr int kAtOnce = kRowsAtOnce<kLanes>;
    for (std::size_t s = 0; s < factor.count; ++s) {
        const int first = factor.first_column[s], width = factor.first_column[s + 1] - first;
        double* y = Vector<kLanes>::of(x, first);
        const double* value = factor.value + factor.value_begin[s];
        solve_diagonal<kLanes>(value, width, factor.inverse_of_diagonal + first, y);
        const int* row = factor.row + factor.row_begin[s];
        const int rows = factor.row_begin[s + 1] - factor.row_begin[s];
        const auto stride = at(width);
        int r = width;
        for (; r + kAtOnce <= rows; r += kAtOnce) {
            subtract_from_rows<kLanes, kAtOnce>(value + at(r) * stride, width, row + r, y, x);
        }
        for (; r < rows; ++r) {
            subtract_from_rows<kLanes, 1>(value + at(r) * stride, width, row + r, y, x);
        }
    }
}

template <std::size_t kLanes>
MSCOMP_INLINE void backward(const SupernodalRows& factor, double* x) {
    constexpr int kAtOnce = kRowsAtOnce<kLanes>;
    for (std::size_t s = factor.count; s-- > 0;) {
        const int first = factor.first_column[s], width = factor.first_column[s + 1] - first;
        double* y = Vector<kLanes>::of(x, first);
        const double* value = factor.value + factor.value_begin[s];
        const int* row = factor.row + factor.row_begin[s];
        const int rows = factor.row_begin[s + 1] - factor.row_begin[s];
        const auto stride = at(width);
        int r = width;
        for (; r + kAtOnce <= rows; r += kAtOnce) {
            subtract_from_columns<kLanes, kAtOnce>(value + at(r) * stride, width, row + r, x, y);
        }
        for (; r < rows; ++r) {
            subtract_from_columns<kLanes, 1>(value + at(r) * stride, width, row + r, x, y);
        }
        solve_transposed_diagonal<kLanes>(value, width, factor.inverse_of_diagonal + first, y);
    }
}

template <std::size_t kLanes, class Factor>
MSCOMP_INLINE void sweep_through(const Factor& factor, double* x, Sweep sweep) {
    if (sweep != Sweep::backward) forward<kLanes>(factor, x);
    if (sweep != Sweep::forward) backward<kLanes>(factor, x);
}

MSCOMP_FOR_EACH_VECTOR_WIDTH
void columns_1(const SimplicialColumns& factor, double* x, Sweep s) {
    sweep_through<1>(factor, x, s);
}
MSCOMP_FOR_EACH_VECTOR_WIDTH
void columns_4(const SimplicialColumns& factor, double* x, Sweep s) {
    sweep_through<4>(factor, x, s);
}
MSCOMP_FOR_EACH_VECTOR_WIDTH
void columns_8(const SimplicialColumns& factor, double* x, Sweep s) {
    sweep_through<8>(factor, x, s);
}
MSCOMP_FOR_EACH_VECTOR_WIDTH
void blocks_1(const SupernodalRows& factor, double* x, Sweep s) { sweep_through<1>(factor, x, s); }
MSCOMP_FOR_EACH_VECTOR_WIDTH
void blocks_4(const SupernodalRows& factor, double* x, Sweep s) { sweep_through<4>(factor, x, s); }
MSCOMP_FOR_EACH_VECTOR_WIDTH
void blocks_8(const SupernodalRows& factor, double* x, Sweep s) { sweep_through<8>(factor, x, s); }

}  // namespace

void substitute(const SimplicialColumns& factor, double* x, std::size_t lanes, Sweep sweep) {
    (lanes == 1 ? columns_1 : lanes == 4 ? columns_4 : columns_8)(factor, x, sweep);
}

void substitute(const SupernodalRows& factor, double* x, std::size_t lanes, Sweep sweep) {
    (lanes == 1 ? blocks_1 : lanes == 4 ? blocks_4 : blocks_8)(factor, x, sweep);
}

}  // namespace mscomp
