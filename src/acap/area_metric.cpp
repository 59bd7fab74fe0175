// SPDX-License-Identifier: MIT
#include "mscomp/acap/area_metric.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "mscomp/base/index.h"

namespace mscomp {
namespace {

constexpr double kLeastShare = 0.02;

std::vector<double> vertex_areas(const TriangleMesh& mesh) {
    std::vector<double> areas(mesh.vertices.size(), 0.0);
    const auto position = [&](int v) {
        return Eigen::Map<const Eigen::Vector3d>(mesh.vertices[at(v)].data());
    };
    for (const auto& [a, b, c] : mesh.faces) {
        const Eigen::Vector3d ab = position(b) - position(a), ac = position(c) - position(a);
        const double area = ab.cross(ac).norm() / 2;
        for (const int corner : {a, b, c}) areas[at(corner)] += area / 3;
    }
    return areas;
}

void make_mean_one(std::vector<double>& values) {
    const double mean =
        std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
    for (double& value : values) value = mean > 0 ? value / mean : 1;
}

}  // namespace

std::vector<float> area_metric(const TriangleMesh& mesh) {
    std::vector<double> shares = vertex_areas(mesh);
    make_mean_one(shares);
    for (double& share : shares) share = std::max(share, kLeastShare);
    make_mean_one(shares);
    std::vector<float> roots;
    for (const double share : shares) roots.push_back(static_cast<float>(std::sqrt(share)));
    return roots;
}

}  // namespace mscomp
