// SPDX-License-Identifier: MIT
#include "ring_normals.h"

#include <Eigen/Eigenvalues>

#include "mscomp/base/index.h"

namespace mscomp {
namespace {

// A sum below this share of the number of faces is rounding of the file, not a direction.
constexpr double kCancelled = 1e-4;

Eigen::Vector3d least_spread(const std::vector<Point>& points, const OneRings& rings,
                             std::size_t vertex, double length) {
    if (!(length > 0)) return Eigen::Vector3d::UnitZ();
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (int place = rings.offsets[vertex]; place < rings.offsets[vertex + 1]; ++place) {
        const auto j = at(rings.neighbors[at(place)]);
        const Eigen::Vector3d edge = (as_vector(points[j]) - as_vector(points[vertex])) / length;
        spread += edge * edge.transpose();
    }
    return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(0);
}

double mean_edge_length(const std::vector<Point>& points, const OneRings& rings,
                        std::size_t vertex) {
    double sum = 0;
    for (int place = rings.offsets[vertex]; place < rings.offsets[vertex + 1]; ++place) {
        const auto j = at(rings.neighbors[at(place)]);
        sum += (as_vector(points[j]) - as_vector(points[vertex])).norm();
    }
    const int degree = rings.offsets[vertex + 1] - rings.offsets[vertex];
    return degree > 0 ? sum / degree : 0.0;
}

/// Unit normals of the faces, zero for those without area, which are counted.
std::vector<Eigen::Vector3d> face_normals(const std::vector<Point>& points,
                                          const std::vector<Face>& faces, RingNormals& result) {
    std::vector<Eigen::Vector3d> normals;
    normals.reserve(faces.size());
    for (std::size_t f = 0; f < faces.size(); ++f) {
        const auto normal = face_normal(points, faces[f]);
        if (!normal) result.zero_area_faces.add(static_cast<int>(f));
        normals.push_back(normal.value_or(Eigen::Vector3d::Zero()));
    }
    return normals;
}

}  // namespace

RingNormals ring_directions(const std::vector<Point>& points, const std::vector<Face>& faces,
                            const VertexFaces& around, const OneRings& rings) {
    const std::size_t count = points.size();
    RingNormals result;
    const std::vector<Eigen::Vector3d> of_face = face_normals(points, faces, result);
    result.normal.assign(count, Eigen::Vector3d::Zero());
    result.sum_length.assign(count, 0.0);
    result.folded.assign(count, 0);
    for (std::size_t i = 0; i < count; ++i) {
        if (rings.degree(static_cast<int>(i)) == 0) continue;
        Eigen::Vector3d normal = Eigen::Vector3d::Zero();
        for (int place = around.offsets[i]; place < around.offsets[i + 1]; ++place) {
            normal += of_face[at(around.faces[at(place)])];
        }
        const double sum = result.sum_length[i] = normal.norm();
        if (sum > kCancelled * around.count(static_cast<int>(i))) {
            result.normal[i] = normal * (1 / sum);
        } else {
            result.normal[i] = least_spread(points, rings, i, mean_edge_length(points, rings, i));
            result.folded[i] = 1;
            result.folded_rings.add(static_cast<int>(i));
        }
    }
    return result;
}

RingNormals ring_normals(const std::vector<Point>& points, const std::vector<Face>& faces,
                         const VertexFaces& around, const OneRings& rings) {
    RingNormals result = ring_directions(points, faces, around, rings);
    result.height.assign(points.size(), 0.0);
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (rings.degree(static_cast<int>(i)) == 0) continue;
        result.height[i] = kHeightFactor * mean_edge_length(points, rings, i);
    }
    return result;
}

}  // namespace mscomp
