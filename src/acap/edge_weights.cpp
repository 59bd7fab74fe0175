// SPDX-License-Identifier: MIT
#include "edge_weights.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "mscomp/acap/mesh/surface_mesh.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

constexpr double kSmallestCotangentWeight = 1e-3;

std::size_t edge_index(const OneRings& rings, int from, int to) {
    const auto begin = rings.neighbors.begin() + rings.offsets[at(from)];
    const auto end = rings.neighbors.begin() + rings.offsets[at(from) + 1];
    return at(std::lower_bound(begin, end, to) - rings.neighbors.begin());
}

double positive_weight(double half_cotangents, EdgeWeights kind) {
    if (kind == EdgeWeights::uniform) return 1.0;
    if (kind == EdgeWeights::cotangent) return std::max(half_cotangents, kSmallestCotangentWeight);
    return std::sqrt(half_cotangents > 0 ? 1 + half_cotangents : std::exp(half_cotangents));
}

}  // namespace

EdgeWeights parse_edge_weights(const std::string& name) {
    for (const EdgeWeights kind :
         {EdgeWeights::cotangent, EdgeWeights::authors, EdgeWeights::uniform}) {
        if (name == to_string(kind)) return kind;
    }
    throw UsageError(fmt::format("edge weights '{}': wanted cotangent, authors or uniform", name));
}

std::string to_string(EdgeWeights weights) {
    switch (weights) {
        case EdgeWeights::authors:
            return "authors";
        case EdgeWeights::uniform:
            return "uniform";
        case EdgeWeights::cotangent:
            break;
    }
    return "cotangent";
}

std::optional<Eigen::Vector3d> face_normal_of_any_size(const Eigen::Vector3d& ab,
                                                       const Eigen::Vector3d& ac, double length) {
    // Divided first, so that the product neither underflows nor overflows in any unit.
    const Eigen::Vector3d cross = (ab / length).cross(ac / length);
    const double area = cross.norm();
    if (!(area > kZeroArea)) return std::nullopt;
    return cross / area;
}

EdgeWeightTable edge_weights(const TriangleMesh& reference, const OneRings& rings,
                             EdgeWeights kind) {
    EdgeWeightTable table;
    table.weights.assign(rings.neighbors.size(), 0.0);
    for (int index = 0; index < reference.face_count(); ++index) {
        const Face& face = reference.faces[at(index)];
        const auto normal = face_normal(reference.vertices, face);
        if (!normal) {
            table.zero_area_faces.add(index);
            continue;
        }
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const int a = face[(corner + 1) % 3], b = face[(corner + 2) % 3];
            const auto tip = as_vector(reference.vertices[at(face[corner])]);
            const Eigen::Vector3d u = as_vector(reference.vertices[at(a)]) - tip;
            const Eigen::Vector3d v = as_vector(reference.vertices[at(b)]) - tip;
            const double half_cotangent = 0.5 * u.dot(v) / normal->dot(u.cross(v));
            table.weights[edge_index(rings, a, b)] += half_cotangent;
            table.weights[edge_index(rings, b, a)] += half_cotangent;
        }
    }
    for (double& weight : table.weights) weight = positive_weight(weight, kind);
    return table;
}

std::vector<double> ring_weights(const TriangleMesh& reference, EdgeWeights weights) {
    return edge_weights(reference, SurfaceMesh(reference).rings(), weights).weights;
}

}  // namespace mscomp
