// SPDX-License-Identifier: MIT
#include "check_frame.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "acap/mesh/float_range.h"
#include "acap/polar.h"
#include "mscomp/base/index.h"
#include "mscomp/base/random.h"

namespace mscomp {
namespace {

// A reference that bends less than this (root mean square sine) is flat: it has no mirror image.
constexpr double kFlat = 0.02;

/// Equal exactly for equal positions; -0 equals 0.
std::array<std::uint64_t, 2> hash_of(const std::vector<Point>& shape) {
    std::vector<Point> plain = shape;
    for (Point& point : plain) {
        for (double& coordinate : point) coordinate += 0.0;
    }
    const XXH128_hash_t hash = XXH3_128bits(plain.data(), plain.size() * sizeof(Point));
    return {hash.high64, hash.low64};
}

/// Means over the vertices of ±(distance from the centroid), each with signs of its own: a rigid
/// motion keeps them, a local deformation changes most of them.
std::array<double, kInvariants> frame_invariants(const std::vector<Point>& shape) {
    const Point center = centroid_of(shape);
    const CounterRandom random(0, 0);
    std::array<double, kInvariants> result{};
    for (std::size_t i = 0; i < shape.size(); ++i) {
        const double length = (as_vector(shape[i]) - as_vector(center)).norm();
        const auto signs = static_cast<unsigned>(random.bits(i));
        for (std::size_t k = 0; k < kInvariants; ++k) {
            result[k] += (signs >> k & 1u) != 0 ? length : -length;
        }
    }
    for (double& value : result)
        value /= static_cast<double>(std::max<std::size_t>(shape.size(), 1));
    return result;
}

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
    double ab = 0, aa = 0, bb = 0;
    for (std::size_t k = 0; k < a.size(); ++k) {
        ab += a[k] * b[k];
        aa += a[k] * a[k];
        bb += b[k] * b[k];
    }
    const double flat = kFlat * kFlat * static_cast<double>(a.size());
    return aa > flat && bb > flat ? ab / std::sqrt(aa * bb) : 1.0;
}

}  // namespace

FrameMeter::FrameMeter(const TriangleMesh& reference, VertexPlaces used)
    : used_(std::move(used)),
      reference_(used_.surface(reference)),
      gradients_(reference_, EdgeWeights::cotangent),
      edges_(reference_.vertices, gradients_.rings()),
      center_(centroid_of(reference_.vertices)),
      radius_(rms_radius(reference_.vertices)),
      pinch_(reference_.vertices, gradients_.rings()) {
    std::map<std::pair<int, int>, int> side;
    for (int f = 0; f < reference_.face_count(); ++f) {
        const Face& face = reference_.faces[at(f)];
        for (std::size_t k = 0; k < 3; ++k) side[{face[k], face[(k + 1) % 3]}] = f;
    }
    for (const auto& [ends, left] : side) {
        const auto opposite = side.find({ends.second, ends.first});
        if (ends.first > ends.second || opposite == side.end()) continue;
        hinges_.push_back({ends.first, ends.second, left, opposite->second});
    }
    reference_bends_ = bends(reference_.vertices);
}

/// Sine of the angle between the two faces of every hinge, positive where the surface is convex.
std::vector<double> FrameMeter::bends(const std::vector<Point>& shape) const {
    std::vector<Eigen::Vector3d> normals;
    normals.reserve(reference_.faces.size());
    for (const Face& face : reference_.faces) {
        normals.push_back(face_normal(shape, face).value_or(Eigen::Vector3d::Zero()));
    }
    std::vector<double> result;
    result.reserve(hinges_.size());
    for (const Hinge& hinge : hinges_) {
        const Eigen::Vector3d along =
            (as_vector(shape[at(hinge.to)]) - as_vector(shape[at(hinge.from)])).stableNormalized();
        const Eigen::Vector3d across = normals[at(hinge.left)].cross(normals[at(hinge.right)]);
        result.push_back(across.dot(along));
    }
    return result;
}

FrameFacts FrameMeter::measure(const std::vector<Point>& shape, StretchHistogram& histogram) const {
    FrameFacts facts = measure_used(used_.of_places(std::span(shape)), histogram);
    facts.hash = hash_of(shape);
    number_as_files(facts);
    return facts;
}

void FrameMeter::number_as_files(FrameFacts& facts) const {
    const auto renumber = [&](int& vertex) {
        if (vertex >= 0) vertex = used_.vertex(vertex);
    };
    renumber(facts.folded_rings.first);
    renumber(facts.mirrored.first);
    renumber(facts.largest_stretch_vertex);
    renumber(facts.sharpest_turn_vertex);
    renumber(facts.edges.first_permuted);
    for (int& vertex : facts.edges.stray) renumber(vertex);
    for (int& vertex : facts.edges.shrunk) renumber(vertex);
}

FrameFacts FrameMeter::measure_used(const std::vector<Point>& shape,
                                    StretchHistogram& histogram) const {
    FrameFacts facts;
    facts.invariant = frame_invariants(shape);
    facts.edges = edges_.compare(shape);
    const double size = std::max(radius_, rms_radius(shape));
    facts.offset = (as_vector(centroid_of(shape)) - as_vector(center_)).norm() / size;
    facts.origin_distance = distance_from_origin(shape);
    facts.bend_agreement = correlation(reference_bends_, bends(shape));
    measure_gradients(shape, facts, histogram);
    if (facts.largest_stretch_vertex >= 0) {
        facts.opens_a_pinch =
            pinch_.opens_a_pinch(shape, facts.largest_stretch_vertex, facts.edges.median_ratio);
    }
    return facts;
}

void FrameMeter::measure_gradients(const std::vector<Point>& shape, FrameFacts& facts,
                                   StretchHistogram& histogram) const {
    const DeformationGradients::Result deformed = gradients_.compute(shape);
    facts.zero_area_faces = deformed.zero_area_faces;
    facts.folded_rings = deformed.folded_rings;
    std::vector<Eigen::Matrix3d> rotations(shape.size(), Eigen::Matrix3d::Identity());
    for (std::size_t i = 0; i < shape.size(); ++i) {
        if (!deformed.gradients[i].allFinite()) {
            facts.finite = false;
            return;
        }
        const PolarDecomposition polar = polar_decomposition(deformed.gradients[i]);
        if (polar.mirrored) facts.mirrored.add(static_cast<int>(i));
        rotations[i] = polar.rotation;
        const double stretch = (polar.stretch - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
        histogram.add(stretch);
        if (stretch > facts.largest_stretch) {
            facts.largest_stretch = stretch;
            facts.largest_stretch_vertex = static_cast<int>(i);
        }
    }
    measure_turns(rotations, facts);
}

/// The angle between neighbours is what no choice of full turns can take away.
void FrameMeter::measure_turns(const std::vector<Eigen::Matrix3d>& rotations,
                               FrameFacts& facts) const {
    const OneRings& rings = gradients_.rings();
    double least_trace = 3;
    for (std::size_t i = 0; i < rotations.size(); ++i) {
        for (int place = rings.offsets[i]; place < rings.offsets[i + 1]; ++place) {
            const auto j = at(rings.neighbors[at(place)]);
            if (j < i) continue;
            const double trace = rotations[i].cwiseProduct(rotations[j]).sum();
            if (!(trace < least_trace)) continue;
            least_trace = trace;
            facts.sharpest_turn_vertex = static_cast<int>(i);
        }
    }
    facts.sharpest_turn = std::acos(std::clamp((least_trace - 1) / 2, -1.0, 1.0));
}

}  // namespace mscomp
