// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

namespace mscomp {

/// L D Lᵀ, the part of L below the diagonal by columns; borrowed.
struct SimplicialColumns {
    std::size_t size;                   // n
    const int* column_begin;            // (n+1)
    const int* row;                     // (nonzeros)
    const double* value;                // (nonzeros)
    const double* inverse_of_diagonal;  // (n) 1 / D
};

/// L Lᵀ in blocks of w columns, each with r >= w rows, the first w of which are the columns' own;
/// borrowed.
struct SupernodalRows {
    std::size_t count;                  // of blocks
    const int* first_column;            // (count+1)
    const int* row_begin;               // (count+1) in `row`
    const int* value_begin;             // (count+1) in `value`
    const int* row;                     // increasing within a block
    const double* value;                // of each block (r,w), row by row
    const double* inverse_of_diagonal;  // (n) 1 / L_jj
};

/// Forward through L, backward through the rest (D Lᵀ or Lᵀ), or one after the other.
enum class Sweep { forward, backward, both };

/// Overwrite x (n, lanes) with the solution of L D Lᵀ y = x, or L Lᵀ y = x, or of that part of it
/// which the sweep is about, for 1, 4 or 8 lanes. A lane's result does not depend on the number of
/// lanes.
void substitute(const SimplicialColumns& factor, double* x, std::size_t lanes, Sweep sweep);
void substitute(const SupernodalRows& factor, double* x, std::size_t lanes, Sweep sweep);

}  // namespace mscomp
