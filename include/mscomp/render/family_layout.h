// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

namespace mscomp {

struct GridPlace {
    int row = 0, column = 0;

    bool operator==(const GridPlace&) const = default;
};

/// Where the children of a node stand.
struct Branch {
    int parent = 0;
    int column = 0;                   // of the first child
    int first_row = 0, last_row = 0;  // of all below the parent
};

/// Rows that belong together: a node without parent and all below it.
struct Family {
    int root = -1;  // -1: the nodes that have neither parent nor children
    int first_row = 0, rows = 0;
    int column = 0, columns = 0;
    int members = 0;
};

/// Places of nodes in a grid.
struct FamilyLayout {
    std::vector<GridPlace> places;  // of every node
    std::vector<Family> families;   // in the order of their roots
    std::vector<Branch> branches;   // one for every node with children
    int rows = 0, columns = 0;      // that are used
};

/// Every parent with its children to its right, from its own row on: first those that have children
/// themselves, one below the other, then the others side by side, in as many rows as they need. No
/// two nodes share a place. Children beyond the last column begin below their parent. Nodes that
/// have neither parent nor children come first, in rows of their own; a family
/// stands beside earlier ones where these leave room for it. Order is kept otherwise.
/// `parents`: of each node the number of its parent, which stands before it, or -1. Throws
/// UsageError for other parents, or less than one column.
FamilyLayout family_layout(std::span<const int> parents, int columns);

}  // namespace mscomp
