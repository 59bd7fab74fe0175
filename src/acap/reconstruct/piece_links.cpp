// SPDX-License-Identifier: MIT
#include "piece_links.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

#include "mscomp/base/index.h"
#include "mscomp/base/points.h"

namespace mscomp {
namespace {

/// A link with its squared length; the lesser one is taken.
struct CandidateLink {
    double square = std::numeric_limits<double>::infinity();
    int from = -1, to = -1;

    bool operator<(const CandidateLink& other) const {
        return std::tie(square, from, to) < std::tie(other.square, other.from, other.to);
    }
};

/// A k-d tree of some of the points, in groups, which finds the nearest one of another group.
class GroupTree {
  public:
    /// Borrows the points; `vertices` are those in the tree, at least one.
    GroupTree(const std::vector<Point>& points, std::vector<int> vertices)
        : points_(points), order_(std::move(vertices)), group_(points.size(), kMixed) {
        build(0, order_.size());
    }

    void set_groups(const std::vector<int>& group) {
        group_ = group;
        // Children come after their parents.
        for (std::size_t n = nodes_.size(); n-- > 0;) nodes_[n].group = common_group(nodes_[n]);
    }
    /// Replaces `best` by the link from `vertex` to another group if that is less. As long as no
    /// groups are set, all in the tree are of another one than vertices beside it.
    void improve(int vertex, CandidateLink& best) const { improve(0, vertex, best); }

  private:
    static constexpr std::size_t kLeaf = 8;
    static constexpr int kMixed = -1;

    struct Node {
        std::size_t begin, end;           // in order_
        std::size_t left = 0, right = 0;  // nodes, 0 for a leaf
        Point lowest, highest;
        int group = kMixed;
    };

    std::size_t build(std::size_t begin, std::size_t end) {
        const std::size_t number = nodes_.size();
        const Point& first = points_[at(order_[begin])];
        Node node{begin, end, 0, 0, first, first};
        for (std::size_t i = begin; i < end; ++i) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double x = points_[at(order_[i])][axis];
                node.lowest[axis] = std::min(node.lowest[axis], x);
                node.highest[axis] = std::max(node.highest[axis], x);
            }
        }
        nodes_.push_back(node);
        if (end - begin <= kLeaf) return number;
        const Point size = minus(node.highest, node.lowest);
        const auto axis = at(std::ranges::max_element(size) - size.begin());
        const std::size_t middle = begin + (end - begin) / 2;
        const auto place = [&](std::size_t i) {
            return order_.begin() + static_cast<std::ptrdiff_t>(i);
        };
        std::nth_element(place(begin), place(middle), place(end), [&](int a, int b) {
            return std::pair(points_[at(a)][axis], a) < std::pair(points_[at(b)][axis], b);
        });
        const std::size_t left = build(begin, middle), right = build(middle, end);
        nodes_[number].left = left;
        nodes_[number].right = right;
        return number;
    }

    int common_group(const Node& node) const {
        if (node.left != 0) {
            const int group = nodes_[node.left].group;
            return group == nodes_[node.right].group ? group : kMixed;
        }
        const int group = group_[at(order_[node.begin])];
        for (std::size_t i = node.begin; i < node.end; ++i) {
            if (group_[at(order_[i])] != group) return kMixed;
        }
        return group;
    }

    double square_distance_to(const Node& node, const Point& point) const {
        Point nearest;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            nearest[axis] = std::clamp(point[axis], node.lowest[axis], node.highest[axis]);
        }
        return square_distance(nearest, point);
    }

    void improve(std::size_t number, int vertex, CandidateLink& best) const {
        const Node& node = nodes_[number];
        const Point& point = points_[at(vertex)];
        const int own = group_[at(vertex)];
        if ((node.group == own && own != kMixed) || square_distance_to(node, point) > best.square)
            return;
        if (node.left == 0) {
            for (std::size_t i = node.begin; i < node.end; ++i) {
                const int other = order_[i];
                if (group_[at(other)] == own && own != kMixed) continue;
                best = std::min(best, {square_distance(point, points_[at(other)]), vertex, other});
            }
            return;
        }
        std::size_t near = node.left, far = node.right;
        if (square_distance_to(nodes_[far], point) < square_distance_to(nodes_[near], point)) {
            std::swap(near, far);
        }
        improve(near, vertex, best);
        improve(far, vertex, best);
    }

    const std::vector<Point>& points_;
    std::vector<int> order_, group_;
    std::vector<Node> nodes_;
};

/// Which pieces hang together already.
class PieceGroups {
  public:
    explicit PieceGroups(int count) : parent_(at(count)) {
        std::iota(parent_.begin(), parent_.end(), 0);
    }
    int find(int piece) {
        while (parent_[at(piece)] != piece) {
            piece = parent_[at(piece)] = parent_[at(parent_[at(piece)])];
        }
        return piece;
    }
    /// Whether they were apart.
    bool join(int a, int b) {
        a = find(a);
        b = find(b);
        parent_[at(std::max(a, b))] = std::min(a, b);
        return a != b;
    }

  private:
    std::vector<int> parent_;
};

/// The shortest links that make one of all pieces. Borůvka: every group takes its shortest one,
/// until there is one group.
std::vector<PieceLink> shortest_links(const std::vector<Point>& points,
                                      const std::vector<int>& piece, int count) {
    std::vector<int> all(points.size());
    std::iota(all.begin(), all.end(), 0);
    GroupTree tree(points, std::move(all));
    PieceGroups groups(count);
    std::vector<PieceLink> links;
    while (static_cast<int>(links.size()) + 1 < count) {
        std::vector<int> group(piece.size());
        for (std::size_t v = 0; v < piece.size(); ++v) group[v] = groups.find(piece[v]);
        tree.set_groups(group);
        std::vector<CandidateLink> best(at(count));
        for (std::size_t v = 0; v < piece.size(); ++v) {
            tree.improve(static_cast<int>(v), best[at(group[v])]);
        }
        std::sort(best.begin(), best.end());
        for (const CandidateLink& link : best) {
            if (link.from < 0 || !groups.join(piece[at(link.from)], piece[at(link.to)])) continue;
            links.push_back({link.from, link.to});
        }
    }
    return links;
}

/// Links the vertices of two pieces.
class Linker {
  public:
    Linker(const std::vector<Point>& points, const std::vector<int>& piece, int count)
        : points_(points), vertices_(at(count)), trees_(at(count)) {
        for (std::size_t v = 0; v < piece.size(); ++v) {
            vertices_[at(piece[v])].push_back(static_cast<int>(v));
        }
    }
    std::vector<PieceLink> links(int from, int to) {
        const bool to_is_smaller = vertices_[at(to)].size() <= vertices_[at(from)].size();
        const GroupTree& tree = tree_of(to_is_smaller ? from : to);
        std::vector<PieceLink> links;
        for (const int v : vertices_[at(to_is_smaller ? to : from)]) {
            CandidateLink nearest;
            tree.improve(v, nearest);
            links.push_back(to_is_smaller ? PieceLink{nearest.to, v} : PieceLink{v, nearest.to});
        }
        return links;
    }

  private:
    const GroupTree& tree_of(int piece) {
        std::optional<GroupTree>& tree = trees_[at(piece)];
        if (!tree) tree.emplace(points_, vertices_[at(piece)]);
        return *tree;
    }

    const std::vector<Point>& points_;
    std::vector<std::vector<int>> vertices_;  // of every piece
    std::vector<std::optional<GroupTree>> trees_;
};

}  // namespace

std::vector<PieceJoint> piece_joints(const std::vector<Point>& points,
                                     const std::vector<int>& piece) {
    const int count = piece.empty() ? 0 : *std::ranges::max_element(piece) + 1;
    if (count < 2) return {};
    std::vector<std::vector<int>> neighbors(at(count));
    for (const auto& [a, b] : shortest_links(points, piece, count)) {
        neighbors[at(piece[at(a)])].push_back(piece[at(b)]);
        neighbors[at(piece[at(b)])].push_back(piece[at(a)]);
    }
    Linker linker(points, piece, count);
    std::vector<PieceJoint> joints;
    std::vector<char> is_held(at(count), 0);
    std::vector<int> order{0};
    is_held[0] = 1;
    for (std::size_t n = 0; n < order.size(); ++n) {
        const int from = order[n];
        for (const int to : neighbors[at(from)]) {
            if (is_held[at(to)] != 0) continue;
            is_held[at(to)] = 1;
            joints.push_back({from, to, linker.links(from, to)});
            order.push_back(to);
        }
    }
    return joints;
}

}  // namespace mscomp
