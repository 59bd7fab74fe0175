// SPDX-License-Identifier: MIT
#include "mscomp/acap/mirrored_features.h"

#include <Eigen/Core>
#include <cassert>
#include <utility>

#include "mscomp/base/index.h"

namespace mscomp {
namespace {

using FeatureValues = Eigen::Matrix<float, kFeatureDim, 1>;

FeatureValues interpolated(std::span<const float> row, const SurfaceLocation& location) {
    FeatureValues sum = FeatureValues::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
        if (location.weights[k] == 0) continue;
        sum += location.weights[k] *
               Eigen::Map<const FeatureValues>(row.data() + at(location.corners[k]) * kFeatureDim);
    }
    return sum;
}

FeatureValues mirrored(const FeatureValues& feature, const Eigen::Matrix3f& M) {
    Eigen::Matrix3f S;
    S << feature[3], feature[4], feature[5],  //
        feature[4], feature[6], feature[7],   //
        feature[5], feature[7], feature[8];
    const Eigen::Vector3f r = -(M * feature.head<3>());
    S = M * S * M.transpose();
    FeatureValues result;
    result << r, S(0, 0), S(0, 1), S(0, 2), S(1, 1), S(1, 2), S(2, 2);
    return result;
}

}  // namespace

MirroredFeatures::MirroredFeatures(const ShapeFeatures& features, const Mirror& mirror)
    : features_(features), mirror_(mirror) {
    assert(features.vertex_count() == mirror.vertex_count());
}

std::vector<float> MirroredFeatures::mirrored_row(int index) const {
    const std::span<const float> source = features_.shape(index);
    const Eigen::Matrix3f M = mirror_.matrix.cast<float>();
    std::vector<float> row(source.size());
    for (std::size_t v = 0; v < at(vertex_count()); ++v) {
        Eigen::Map<FeatureValues>(row.data() + v * kFeatureDim) =
            mirrored(interpolated(source, mirror_.partners[v]), M);
    }
    return row;
}

std::span<const float> MirroredFeatures::shape(int index) const {
    const int count = features_.shape_count();
    if (index < count) return features_.shape(index);
    return rows_.row(index, [&] { return mirrored_row(index - count); });
}

void MirroredFeatures::forget(int index) const {
    if (index < features_.shape_count()) return features_.forget(index);
    rows_.forget(index);
}

}  // namespace mscomp
