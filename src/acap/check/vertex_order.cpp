// SPDX-License-Identifier: MIT
#include "vertex_order.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "check_edges.h"
#include "mscomp/base/index.h"
#include "mscomp/base/points.h"

namespace mscomp {
namespace {

// Measured on bodies, hands, faces, cloth and animals: of 20 shapes with 50 vertices shuffled in a
// patch every one has 16 or more such vertices hanging together, as captured none more than 3. A
// ring that got out of order is wider, too; one that is pressed flat, as at lips, is not.
constexpr double kOutOfRing = 0.7;      // spreads
constexpr double kWider = 1.25;         // than the reference's, beside the usual ratio of the shape
constexpr double kWiderThanSize = 1.5;  // the usual ratio is at most that of the sizes times this
constexpr std::size_t kCrowd = 6;
constexpr std::size_t kMany = 4;          // one of so many vertices: no pose does that
constexpr double kNearer = 0.5;           // than whose ring it is
constexpr double kFarOut = 1.5;           // of both of two exchanged vertices
constexpr double kBeyondReference = 2.0;  // times as far out of the ring as in the reference
constexpr std::size_t kMostExchanged = 500;

// Torn edges, as along blocks of vertices that changed places.
constexpr double kTorn = 4.0;        // times the median length of the edges at both ends
constexpr double kTornShare = 0.25;  // of the radius of the shape
constexpr double kContinues = 0.5;   // of the length of an edge, for one on the other side
constexpr double kBeside = 1.2;      // median lengths to whoever sits where a neighbour belongs
constexpr std::size_t kTornEdges = 8;

double length_between(const Point& a, const Point& b) { return std::sqrt(square_distance(a, b)); }

/// An edge that is far longer than those around its ends.
struct Torn {
    int from = 0, to = 0;
};

/// What first_torn() needs of one shape.
class Tears {
  public:
    Tears(const OneRings& rings, const std::vector<Point>& reference,
          const std::vector<Point>& shape)
        : rings_(rings), reference_(reference), shape_(shape), usual_(usual_lengths()) {
        const double least = kTornShare * rms_radius(shape);
        for_each_edge([&](int i, int j) {
            if (length(i, j) > least && is_torn(i, j) && is_torn(j, i)) torn_.push_back({i, j});
        });
    }

    /// Torn edges beside which another torn end sits where the far one belongs.
    std::vector<Torn> with_a_stranger() const {
        std::vector<int> ends;
        for (const Torn& edge : torn_) ends.insert(ends.end(), {edge.from, edge.to});
        std::ranges::sort(ends);
        ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
        std::vector<Torn> result;
        for (const Torn& edge : torn_) {
            if (has_stranger(edge.from, ends) || has_stranger(edge.to, ends)) {
                result.push_back(edge);
            }
        }
        return result;
    }

  private:
    template <class Visit>
    void for_each_neighbor(int vertex, Visit visit) const {
        for (int k = rings_.offsets[at(vertex)]; k < rings_.offsets[at(vertex) + 1]; ++k) {
            visit(rings_.neighbors[at(k)]);
        }
    }
    template <class Visit>
    void for_each_edge(Visit visit) const {
        for (int i = 0; i < rings_.vertex_count(); ++i) {
            for_each_neighbor(i, [&](int j) {
                if (j > i) visit(i, j);
            });
        }
    }
    double length(int i, int j) const { return length_between(shape_[at(i)], shape_[at(j)]); }

    /// (V) median length of the edges at every vertex.
    std::vector<double> usual_lengths() const {
        std::vector<double> result(shape_.size(), 0.0);
        std::vector<double> lengths;
        for (int i = 0; i < rings_.vertex_count(); ++i) {
            lengths.clear();
            for_each_neighbor(i, [&](int j) { lengths.push_back(length(i, j)); });
            if (lengths.empty()) continue;
            const auto middle =
                lengths.begin() + static_cast<std::ptrdiff_t>((lengths.size() - 1) / 2);
            std::nth_element(lengths.begin(), middle, lengths.end());
            result[at(i)] = *middle;
        }
        return result;
    }

    /// Whether the edge is long beside the others at `i`, and no edge on its other side is: where a
    /// surface is stretched that goes on.
    bool is_torn(int i, int j) const {
        const double own = length(i, j);
        const double before = length_between(reference_[at(i)], reference_[at(j)]);
        if (!(before > 0) || !(own > kTorn * usual_[at(i)])) return false;
        const Point along = minus(reference_[at(j)], reference_[at(i)]);
        bool goes_on = false;
        for_each_neighbor(i, [&](int k) {
            const Point other = minus(reference_[at(k)], reference_[at(i)]);
            goes_on = goes_on || (dot(along, other) < 0 && length(i, k) > kContinues * own);
        });
        return !goes_on;
    }

    bool has_stranger(int vertex, const std::vector<int>& ends) const {
        const double reach = kBeside * usual_[at(vertex)];
        const auto begin = rings_.neighbors.begin() + rings_.offsets[at(vertex)];
        const auto end = rings_.neighbors.begin() + rings_.offsets[at(vertex) + 1];
        return std::ranges::any_of(ends, [&](int other) {
            return other != vertex && length(vertex, other) <= reach &&
                   !std::binary_search(begin, end, other);
        });
    }

    const OneRings& rings_;
    const std::vector<Point>& reference_;
    const std::vector<Point>& shape_;
    std::vector<double> usual_;
    std::vector<Torn> torn_;
};

}  // namespace

VertexOrderTest::VertexOrderTest(const std::vector<Point>& reference, const OneRings& rings)
    : rings_(rings), reference_(reference), of_reference_(rings_of(reference)) {}

std::vector<VertexOrderTest::Ring> VertexOrderTest::rings_of(
    const std::vector<Point>& shape) const {
    std::vector<Ring> result(shape.size());
    for (std::size_t i = 0; i < shape.size(); ++i) {
        const int degree = rings_.degree(static_cast<int>(i));
        if (degree < 3) continue;
        Ring& ring = result[i];
        const auto begin = at(rings_.offsets[i]), end = at(rings_.offsets[i + 1]);
        for (std::size_t k = begin; k < end; ++k) {
            const Point& p = shape[at(rings_.neighbors[k])];
            for (std::size_t x = 0; x < 3; ++x) ring.center[x] += p[x] / degree;
        }
        double squares = 0;
        for (std::size_t k = begin; k < end; ++k) {
            squares += square_distance(shape[at(rings_.neighbors[k])], ring.center);
        }
        ring.spread = std::sqrt(squares / degree);
        if (ring.spread > 0) ring.offset = length_between(shape[i], ring.center) / ring.spread;
    }
    return result;
}

std::vector<char> VertexOrderTest::out_of_ring(const std::vector<Ring>& rings, double least) const {
    std::vector<char> result(rings.size(), 0);
    for (std::size_t i = 0; i < rings.size(); ++i) {
        const double offset = rings[i].offset;
        result[i] = offset > least && offset > kBeyondReference * of_reference_[i].offset ? 1 : 0;
    }
    return result;
}

/// The ratio of spreads to those of the reference that a ring in order has in this shape.
double VertexOrderTest::usual_ratio(const std::vector<Ring>& rings, double size_ratio) const {
    std::vector<double> ratios;
    ratios.reserve(rings.size());
    for (std::size_t i = 0; i < rings.size(); ++i) {
        if (of_reference_[i].spread > 0)
            ratios.push_back(rings[i].spread / of_reference_[i].spread);
    }
    if (ratios.empty()) return size_ratio;
    const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
    std::nth_element(ratios.begin(), middle, ratios.end());
    return std::min(*middle, kWiderThanSize * size_ratio);
}

/// The lowest vertex out of its ring where that is so all over the shape, however coarse.
int VertexOrderTest::first_of_many(const std::vector<Ring>& rings) const {
    const std::vector<char> is_out = out_of_ring(rings, kOutOfRing);
    const auto count = static_cast<std::size_t>(std::ranges::count(is_out, 1));
    if (count < kCrowd || count * kMany < rings.size()) return -1;
    return static_cast<int>(std::ranges::find(is_out, 1) - is_out.begin());
}

/// The lowest of all that hang together in sufficient number.
int VertexOrderTest::first_of_crowd(const std::vector<Ring>& rings, double size_ratio) const {
    const double wide = kWider * usual_ratio(rings, size_ratio);
    std::vector<char> is_left = out_of_ring(rings, kOutOfRing);
    for (std::size_t i = 0; i < is_left.size(); ++i) {
        if (!(rings[i].spread > wide * of_reference_[i].spread)) is_left[i] = 0;
    }
    std::vector<int> crowd;
    for (std::size_t seed = 0; seed < is_left.size(); ++seed) {
        if (is_left[seed] == 0) continue;
        crowd.assign(1, static_cast<int>(seed));
        is_left[seed] = 0;
        for (std::size_t n = 0; n < crowd.size(); ++n) {
            const auto vertex = at(crowd[n]);
            for (int k = rings_.offsets[vertex]; k < rings_.offsets[vertex + 1]; ++k) {
                const int neighbor = rings_.neighbors[at(k)];
                if (is_left[at(neighbor)] == 0) continue;
                is_left[at(neighbor)] = 0;
                crowd.push_back(neighbor);
            }
        }
        if (crowd.size() >= kCrowd) return static_cast<int>(seed);
    }
    return -1;
}

/// The lower of two vertices that sit in each other's rings.
int VertexOrderTest::first_exchanged(const std::vector<Ring>& rings,
                                     const std::vector<Point>& shape) const {
    const std::vector<char> is_out = out_of_ring(rings, kFarOut);
    std::vector<std::size_t> out;
    for (std::size_t i = 0; i < is_out.size() && out.size() < kMostExchanged; ++i) {
        if (is_out[i] != 0) out.push_back(i);
    }
    const auto sits_in = [&](std::size_t i, std::size_t ring) {
        const double limit = std::min(1.0, kNearer * rings[ring].offset);
        return length_between(shape[i], rings[ring].center) <= limit * rings[ring].spread;
    };
    for (std::size_t a = 0; a < out.size(); ++a) {
        for (std::size_t b = a + 1; b < out.size(); ++b) {
            if (sits_in(out[a], out[b]) && sits_in(out[b], out[a])) {
                return static_cast<int>(out[a]);
            }
        }
    }
    return -1;
}

int VertexOrderTest::first_torn(const std::vector<Point>& shape) const {
    const std::vector<Torn> torn = Tears(rings_, reference_, shape).with_a_stranger();
    return torn.size() >= kTornEdges ? torn.front().from : -1;
}

int VertexOrderTest::first_out_of_place(const std::vector<Point>& shape) const {
    const std::vector<Ring> rings = rings_of(shape);
    const double size_ratio = rms_radius(shape) / rms_radius(reference_);
    int first = std::numeric_limits<int>::max();
    for (const int found : {first_of_many(rings), first_of_crowd(rings, size_ratio),
                            first_exchanged(rings, shape), first_torn(shape)}) {
        if (found >= 0) first = std::min(first, found);
    }
    return first == std::numeric_limits<int>::max() ? -1 : first;
}

}  // namespace mscomp
