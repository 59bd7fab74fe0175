// SPDX-License-Identifier: MIT
#include "shape_extraction.h"

#include <algorithm>
#include <array>

#include "log_lanes.h"
#include "mscomp/base/feature_set.h"
#include "polar.h"

namespace mscomp {
namespace {

void store_rotation_vector(const Eigen::Vector3d& rotation_vector, float* feature) {
    for (int axis = 0; axis < kRotationDim; ++axis) {
        feature[axis] = static_cast<float>(rotation_vector[axis]);
    }
}

void store_stretch(const Eigen::Matrix3d& stretch, float* feature) {
    constexpr std::array<std::array<int, 2>, 6> kEntries{
        {{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}}};
    for (std::size_t k = 0; k < kEntries.size(); ++k) {
        feature[kRotationDim + k] = static_cast<float>(stretch(kEntries[k][0], kEntries[k][1]));
    }
}

void store_logarithms(std::span<const PolarDecomposition> polar, float* features) {
    constexpr std::size_t kLanes = LogLanes::kLanes;
    LogLanes lanes;
    for (std::size_t first = 0; first < polar.size(); first += kLanes) {
        const std::size_t count = std::min(kLanes, polar.size() - first);
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
            const double* rotation = polar[first + std::min(lane, count - 1)].rotation.data();
            for (int k = 0; k < 9; ++k) lanes.rotation[k][lane] = rotation[k];
        }
        rotation_logs(lanes);
        for (std::size_t lane = 0; lane < count; ++lane) {
            float* feature = features + (first + lane) * kFeatureDim;
            for (int axis = 0; axis < kRotationDim; ++axis) {
                feature[axis] = static_cast<float>(lanes.logarithm[axis][lane]);
            }
        }
    }
}

}  // namespace

ExtractedShape extract_shape(const DeformationGradients& gradients,
                             const std::vector<Point>& shape) {
    ExtractedShape result;
    const RingNormals directions = gradients.directions(shape);
    result.zero_area_faces = directions.zero_area_faces;
    result.folded_rings = directions.folded_rings;
    result.features.resize(shape.size() * kFeatureDim);
    // Few enough at a time to stay in the nearest cache between the steps.
    constexpr std::size_t kBlock = 64;
    std::array<Eigen::Matrix3d, kBlock> block;
    std::array<PolarDecomposition, kBlock> polar;
    for (std::size_t first = 0; first < shape.size(); first += kBlock) {
        const std::size_t count = std::min(kBlock, shape.size() - first);
        gradients.compute(shape, directions, first, std::span(block).first(count));
        polar_decompositions(block, std::span(polar).first(count));
        float* features = result.features.data() + first * kFeatureDim;
        store_logarithms(std::span(polar).first(count), features);
        for (std::size_t k = 0; k < count; ++k) {
            if (polar[k].mirrored) result.mirrored.add(static_cast<int>(first + k));
            store_stretch(polar[k].stretch, features + k * kFeatureDim);
        }
    }
    return result;
}

std::vector<Eigen::Vector3d> rotation_vectors_of(std::span<const float> row) {
    std::vector<Eigen::Vector3d> result(row.size() / kFeatureDim);
    for (std::size_t i = 0; i < result.size(); ++i) {
        result[i] = Eigen::Map<const Eigen::Vector3f>(row.data() + i * kFeatureDim).cast<double>();
    }
    return result;
}

void store_rotation_vectors(const std::vector<Eigen::Vector3d>& rotation_vectors,
                            std::span<float> row) {
    for (std::size_t i = 0; i < rotation_vectors.size(); ++i) {
        store_rotation_vector(rotation_vectors[i], row.data() + i * kFeatureDim);
    }
}

}  // namespace mscomp
