// SPDX-License-Identifier: MIT
// Shapes, frames and motions that the tests of measures share.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "mscomp/base/mesh_data.h"
#include "mscomp/base/random.h"

namespace mscomp {

using Frames = std::vector<std::vector<Point>>;

/// `points` times `scale`, turned about a tilted axis by `angle` and moved.
inline std::vector<Point> placed(const std::vector<Point>& points, double angle, double scale = 1) {
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(angle, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
    std::vector<Point> result(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        Eigen::Map<Eigen::Vector3d>(result[i].data()) =
            scale * (turn * Eigen::Map<const Eigen::Vector3d>(points[i].data()) +
                     angle * Eigen::Vector3d(3, 1, -2));
    }
    return result;
}

/// `points` with normal noise of deviation `size` on every coordinate.
inline std::vector<Point> noisy(const std::vector<Point>& points, double size, std::uint64_t seed) {
    const CounterRandom random(seed, 0);
    std::vector<Point> result = points;
    std::uint64_t index = 0;
    for (Point& p : result) {
        for (double& x : p) x += size * random.normal(index++);
    }
    return result;
}

/// A mesh that moves: `count` frames, each the one before with some noise.
inline Frames random_walk(const std::vector<Point>& start, int count, double step,
                          std::uint64_t seed) {
    Frames frames{start};
    while (static_cast<int>(frames.size()) < count) {
        frames.push_back(noisy(frames.back(), step, seed + frames.size()));
    }
    return frames;
}

/// Vertex i gets number order[i].
inline std::vector<Point> renumbered(const std::vector<Point>& points,
                                     const std::vector<int>& order) {
    std::vector<Point> result(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        result[static_cast<std::size_t>(order[i])] = points[i];
    }
    return result;
}

inline TriangleMesh renumbered(const TriangleMesh& mesh, const std::vector<int>& order) {
    TriangleMesh result{renumbered(mesh.vertices, order), mesh.faces};
    for (Face& face : result.faces) {
        for (int& v : face) v = order[static_cast<std::size_t>(v)];
    }
    return result;
}

}  // namespace mscomp
