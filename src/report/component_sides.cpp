// SPDX-License-Identifier: MIT
#include "component_sides.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "mscomp/acap/area_metric.h"
#include "mscomp/acap/mirrored_features.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "mscomp/base/points.h"
#include "mscomp/base/shape_features.h"

namespace mscomp {
namespace {

constexpr double kMost = 0.8;

Eigen::Vector3d normal_of(const Mirror& mirror) {
    const Eigen::Matrix3d square = (Eigen::Matrix3d::Identity() - mirror.matrix) / 2;  // n nᵀ
    Eigen::Index longest = 0;
    square.diagonal().maxCoeff(&longest);
    return square.col(longest).normalized();
}

/// Rows as they count, of unit length where they are not zero.
Eigen::VectorXf counted(std::span<const float> row, std::span<const float> roots) {
    Eigen::VectorXf result(static_cast<Eigen::Index>(row.size()));
    const std::size_t width = row.size() / roots.size();
    for (std::size_t i = 0; i < row.size(); ++i) {
        result[static_cast<Eigen::Index>(i)] = row[i] * roots[i / width];
    }
    const float length = result.norm();
    return length > 0 ? Eigen::VectorXf(result / length) : result;
}

/// The mirror image of a change of features (V,9) or of positions (V,3).
std::vector<float> mirrored_change(std::span<const float> change, const Mirror& mirror) {
    const auto vertices = at(mirror.vertex_count());
    if (change.size() == vertices * kFeatureDim) {
        const MemoryFeatures one(change, mirror.vertex_count());
        const MirroredFeatures both(one, mirror);
        return {both.shape(1).begin(), both.shape(1).end()};
    }
    const Eigen::Matrix3f M = mirror.matrix.cast<float>();
    std::vector<float> result(change.size());
    for (std::size_t v = 0; v < vertices; ++v) {
        const auto& [corners, weights] = mirror.partners[v];
        Eigen::Vector3f sum = Eigen::Vector3f::Zero();
        for (std::size_t k = 0; k < 3; ++k) {
            const auto corner = static_cast<std::size_t>(corners[k]);
            sum += weights[k] * Eigen::Map<const Eigen::Vector3f>(change.data() + 3 * corner);
        }
        Eigen::Map<Eigen::Vector3f>(result.data() + 3 * v) = M * sum;
    }
    return result;
}

/// |cosine| of each component (row) with the mirror image of each (column), of the nearer ends.
Eigen::MatrixXf mirrored_cosines(std::span<const Component> components, const Mirror& mirror,
                                 std::span<const float> roots) {
    const auto count = static_cast<Eigen::Index>(components.size());
    const std::size_t size = components.empty() ? 0 : components.front().difference.size();
    Eigen::MatrixXf ends(static_cast<Eigen::Index>(size), 2 * count);
    const auto end = [&](Eigen::Index column) -> const std::vector<float>& {
        const Component& c = components[at(column / 2)];
        return column % 2 == 0 ? c.difference : c.other_difference;
    };
    for (Eigen::Index k = 0; k < 2 * count; ++k) ends.col(k) = counted(end(k), roots);
    Eigen::MatrixXf all(2 * count, 2 * count);  // one image at a time: they may be large
    for (Eigen::Index k = 0; k < 2 * count; ++k) {
        const std::vector<float> image = mirrored_change(end(k), mirror);
        all.col(k) = (ends.transpose() * counted(image, roots)).cwiseAbs();
    }
    Eigen::MatrixXf cosines(count, count);
    for (Eigen::Index k = 0; k < count; ++k) {
        for (Eigen::Index l = 0; l < count; ++l) {
            cosines(k, l) = all.block<2, 2>(2 * k, 2 * l).maxCoeff();
        }
    }
    return cosines;
}

}  // namespace

std::vector<ComponentSide> component_sides(std::span<const Component> components,
                                           const TriangleMesh& reference, const Mirror& mirror) {
    constexpr float kAlike = 0.7F;
    const std::vector<float> roots = area_metric(reference);
    const Eigen::Vector3d normal = normal_of(mirror);
    std::vector<bool> is_along;  // of each vertex
    for (const Point& p : reference.vertices) {
        const Point across = minus(p, mirror.reflected(p));
        is_along.push_back(normal.dot(Eigen::Vector3d(across[0], across[1], across[2])) > 0);
    }
    std::vector<ComponentSide> sides(components.size());
    for (std::size_t k = 0; k < components.size(); ++k) {
        double along = 0, all = 0;
        const std::vector<float>& row = components[k].difference;
        const std::size_t width = row.size() / roots.size();
        for (std::size_t i = 0; i < row.size(); ++i) {
            const auto x = static_cast<double>(row[i] * roots[i / width]);
            all += x * x;
            along += is_along[i / width] ? x * x : 0;
        }
        if (all > 0) sides[k].part = along / all;
    }
    Eigen::MatrixXf cosines = mirrored_cosines(components, mirror, roots);
    std::vector<Eigen::Index> nearest(components.size());
    for (std::size_t k = 0; k < components.size(); ++k) {
        cosines.row(static_cast<Eigen::Index>(k)).maxCoeff(&nearest[k]);
    }
    for (std::size_t k = 0; k < components.size(); ++k) {
        const auto l = at(nearest[k]);
        const bool is_mutual = at(nearest[l]) == k && l != k;
        if (is_mutual && cosines(static_cast<Eigen::Index>(k), nearest[k]) >= kAlike) {
            sides[k].partner = static_cast<int>(l);
        }
    }
    return sides;
}

std::string side_name(const ComponentSide& side, const Mirror& mirror, const Stance& stance) {
    constexpr double kAcross = 0.7;
    const Point left = cross(stance.up, stance.front);
    const double across = normal_of(mirror).dot(Eigen::Vector3d(left[0], left[1], left[2]));
    if (std::abs(across) < kAcross) return "";
    if (!side.part) return "";
    const double part = across > 0 ? *side.part : 1 - *side.part;
    return part >= kMost ? "left" : part <= 1 - kMost ? "right" : "middle";
}

std::string way_of_acting(std::span<const float> difference, std::span<const float> area_roots) {
    double turns = 0, all = 0;
    for (std::size_t i = 0; i < difference.size(); ++i) {
        const std::size_t c = i % kFeatureDim;
        const double x =
            static_cast<double>(difference[i]) * static_cast<double>(area_roots[i / kFeatureDim]);
        const bool is_beside_diagonal = c == 4 || c == 5 || c == 7;  // of S, there twice
        const double square = (is_beside_diagonal ? 2 : 1) * x * x;
        all += square;
        turns += c < 3 ? square : 0;
    }
    if (all == 0) return "";
    return turns >= kMost * all ? "turns" : turns <= (1 - kMost) * all ? "stretches" : "both";
}

}  // namespace mscomp
