// SPDX-License-Identifier: MIT
#include "mscomp/render/family_layout.h"

#include <fmt/format.h>

#include <algorithm>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

/// Rows in which families stand beside each other, as many as the first of them has.
struct Shelf {
    int first_row = 0, rows = 0, taken = 0;  // columns taken from the left
};

class FamilyPlacer {
  public:
    FamilyPlacer(std::span<const int> parents, int columns)
        : parents_(parents), columns_(columns), children_(parents.size()) {
        for (std::size_t i = 0; i < parents.size(); ++i) {
            if (parents[i] >= 0) children_[at(parents[i])].push_back(static_cast<int>(i));
        }
        layout_.places.resize(parents.size());
    }

    FamilyLayout layout() {
        std::vector<int> alone;
        for (std::size_t i = 0; i < parents_.size(); ++i) {
            if (parents_[i] < 0 && children_[i].empty()) alone.push_back(static_cast<int>(i));
        }
        if (!alone.empty()) {
            const int rows = put_side_by_side(alone, 0, 0);
            const int used = std::min(columns_, static_cast<int>(alone.size()));
            layout_.families.push_back({-1, 0, rows, 0, used, static_cast<int>(alone.size())});
            layout_.rows = rows;
        }
        std::vector<Shelf> shelves;
        for (std::size_t i = 0; i < parents_.size(); ++i) {
            if (parents_[i] >= 0 || children_[i].empty()) continue;
            const int root = static_cast<int>(i);
            const std::size_t branches = layout_.branches.size();
            const int rows = put(root, 0, 0);
            const std::vector<int> family = all_below(root);
            int used = 0;
            for (const int node : family) {
                used = std::max(used, layout_.places[at(node)].column + 1);
            }
            auto shelf = std::ranges::find_if(shelves, [&](const Shelf& one) {
                return one.taken + used <= columns_ && rows <= one.rows;
            });
            if (shelf == shelves.end()) {
                shelf = shelves.insert(shelf, Shelf{layout_.rows, rows, 0});
                layout_.rows += rows;
            }
            for (const int node : family) {
                layout_.places[at(node)].row += shelf->first_row;
                layout_.places[at(node)].column += shelf->taken;
            }
            for (std::size_t b = branches; b < layout_.branches.size(); ++b) {
                layout_.branches[b].column += shelf->taken;
                layout_.branches[b].first_row += shelf->first_row;
                layout_.branches[b].last_row += shelf->first_row;
            }
            layout_.families.push_back({root, shelf->first_row, rows, shelf->taken, used,
                                        static_cast<int>(family.size())});
            shelf->taken += used;
        }
        for (const GridPlace& place : layout_.places) {
            layout_.columns = std::max(layout_.columns, place.column + 1);
        }
        return layout_;
    }

  private:
    /// These and what follows return how many rows they took.
    int put_side_by_side(const std::vector<int>& nodes, int row, int column) {
        const int width = columns_ - column;
        for (std::size_t k = 0; k < nodes.size(); ++k) {
            const int i = static_cast<int>(k);
            layout_.places[at(nodes[k])] = {row + i / width, column + i % width};
        }
        return (static_cast<int>(nodes.size()) + width - 1) / width;
    }

    int put(int node, int row, int column) {
        layout_.places[at(node)] = {row, column};
        if (children_[at(node)].empty()) return 1;
        const bool has_room = column + 1 < columns_;
        const int next_column = has_room ? column + 1 : column;
        const int first = has_room ? row : row + 1;
        int next = first;
        std::vector<int> last;
        for (const int child : children_[at(node)]) {
            if (children_[at(child)].empty()) {
                last.push_back(child);
            } else {
                next += put(child, next, next_column);
            }
        }
        next += put_side_by_side(last, next, next_column);
        layout_.branches.push_back({node, next_column, first, next - 1});
        return next - row;
    }

    std::vector<int> all_below(int node) const {
        std::vector<int> all{node};
        for (std::size_t k = 0; k < all.size(); ++k) {
            const std::vector<int>& children = children_[at(all[k])];
            all.insert(all.end(), children.begin(), children.end());
        }
        return all;
    }

    std::span<const int> parents_;
    int columns_;
    std::vector<std::vector<int>> children_;
    FamilyLayout layout_;
};

}  // namespace

FamilyLayout family_layout(std::span<const int> parents, int columns) {
    if (columns < 1) throw UsageError(fmt::format("family layout: {} columns", columns));
    for (std::size_t i = 0; i < parents.size(); ++i) {
        if (parents[i] < -1 || parents[i] >= static_cast<int>(i)) {
            throw UsageError(fmt::format(
                "family layout: parent {} of {}, wanted -1 or one that stands before it",
                parents[i], i));
        }
    }
    return FamilyPlacer(parents, columns).layout();
}

}  // namespace mscomp
