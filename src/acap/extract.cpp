// SPDX-License-Identifier: MIT
#include "mscomp/acap/extract.h"

#include <fmt/format.h>

#include <cmath>
#include <mutex>
#include <utility>

#include "consistency.h"
#include "deformation_gradient.h"
#include "mscomp/acap/alignment.h"
#include "mscomp/base/error.h"
#include "mscomp/base/parallel.h"
#include "polar.h"
#include "rotation.h"

namespace mscomp {
namespace {

/// What one shape brings before its logarithms are made consistent.
struct ShapeResult {
    std::vector<Eigen::Vector3d> logarithms;  // (V) principal
    Occurrences zero_area_faces, folded_rings, mirrored;
};

/// Tells the caller, one call at a time, how many of the shapes are done; each takes two steps.
class Progress {
  public:
    Progress(const std::function<void(int, int)>& report, int total)
        : report_(report), total_(total) {}

    void step() {
        if (!report_) return;
        const std::lock_guard<std::mutex> lock(mutex_);
        ++steps_;
        if (steps_ % 2 == 0) report_(steps_ / 2, total_);
    }

  private:
    const std::function<void(int, int)>& report_;
    int total_;
    int steps_ = 0;
    std::mutex mutex_;
};

void check_sizes(const MeshSequence& sequence, const std::vector<Point>& reference) {
    for (std::size_t n = 0; n < sequence.shapes.size(); ++n) {
        if (sequence.shapes[n].size() == reference.size()) continue;
        throw MeshError(fmt::format("shape '{}' has {} vertices, the reference has {}",
                                    sequence.names[n], sequence.shapes[n].size(),
                                    reference.size()));
    }
    for (const Face& face : sequence.faces) {
        for (const int corner : face) {
            if (corner >= 0 && corner < static_cast<int>(reference.size())) continue;
            throw MeshError(fmt::format("a face refers to vertex {}, the reference has {}", corner,
                                        reference.size()));
        }
    }
}

void store_stretch(const Eigen::Matrix3d& stretch, float* feature) {
    constexpr std::array<std::array<int, 2>, 6> kEntries{
        {{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}}};
    for (std::size_t k = 0; k < kEntries.size(); ++k) {
        feature[kRotationDim + k] = static_cast<float>(stretch(kEntries[k][0], kEntries[k][1]));
    }
}

float* shape_features(FeatureSet& set, std::size_t shape) {
    return set.features.data() + shape * set.reference.vertices.size() * kFeatureDim;
}

/// Aligns shape n, stores its vertices, motion and S; returns its principal logarithms.
ShapeResult extract_shape(const DeformationGradients& gradients, const std::vector<Point>& input,
                          bool align, std::size_t n, FeatureSet& set) {
    const RigidMotion motion =
        align ? best_rigid_motion(input, set.reference.vertices) : RigidMotion{};
    const std::vector<Point> shape = align ? moved(input, motion) : input;
    using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    Eigen::Map<RowMajor>(set.rotation[n].data()) = motion.rotation;
    Eigen::Map<Eigen::Vector3d>(set.translation[n].data()) = motion.translation;

    float* positions = set.vertices.data() + n * shape.size() * 3;
    for (const Point& point : shape) {
        for (const double coordinate : point) *positions++ = static_cast<float>(coordinate);
    }
    const DeformationGradients::Result deformed = gradients.compute(shape);
    ShapeResult result;
    result.zero_area_faces = deformed.zero_area_faces;
    result.folded_rings = deformed.folded_rings;
    result.logarithms.resize(shape.size());
    float* features = shape_features(set, n);
    for (std::size_t i = 0; i < shape.size(); ++i) {
        const PolarDecomposition polar = polar_decomposition(deformed.gradients[i]);
        if (polar.mirrored) result.mirrored.add(static_cast<int>(i));
        result.logarithms[i] = rotation_log(polar.rotation);
        store_stretch(polar.stretch, features + i * kFeatureDim);
    }
    return result;
}

void make_shape_consistent(const ConsistencyGraph& graph, ShapeResult& shape, std::size_t n,
                           FeatureSet& set) {
    const ConsistencySummary summary = make_consistent(graph, shape.logarithms);
    set.consistency_energy[n] = summary.energy;
    set.consistency_gap[n] = summary.energy - summary.lower_bound;
    set.largest_jump[n] = summary.largest_jump;
    float* features = shape_features(set, n);
    for (std::size_t i = 0; i < shape.logarithms.size(); ++i) {
        for (int axis = 0; axis < kRotationDim; ++axis) {
            features[i * kFeatureDim + static_cast<std::size_t>(axis)] =
                static_cast<float>(shape.logarithms[i][axis]);
        }
    }
}

/// Root mean square rotation angle of every vertex over the shapes: how little it turns.
std::vector<double> unrest(const std::vector<ShapeResult>& shapes, std::size_t vertex_count) {
    std::vector<double> sum(vertex_count, 0.0);
    for (const ShapeResult& shape : shapes) {
        for (std::size_t i = 0; i < vertex_count; ++i) sum[i] += shape.logarithms[i].squaredNorm();
    }
    for (double& value : sum) value = std::sqrt(value / static_cast<double>(shapes.size()));
    return sum;
}

void warn_of_reference(const DeformationGradients& gradients, std::vector<std::string>& warnings) {
    const auto warn = [&](const Occurrences& found, const char* what, const char* kind) {
        if (found.count == 0) return;
        warnings.push_back(
            fmt::format("reference: {} {} (first: {} {})", found.count, what, kind, found.first));
    };
    warn(gradients.zero_area_faces(), "faces without area carry no weight", "face");
    warn(gradients.isolated_vertices(), "vertices without faces get the identity", "vertex");
    warn(gradients.folded_rings(),
         "rings whose normals cancel use the direction of their least spread", "vertex");
    warn(gradients.degenerate_rings(), "rings without width take the mean of their neighbours",
         "vertex");
}

/// One sentence for all shapes together: totals, and where it happened first.
void warn_of_shapes(const std::vector<ShapeResult>& shapes, const FeatureSet& set,
                    Occurrences ShapeResult::*member, const char* what, const char* kind,
                    std::vector<std::string>& warnings) {
    std::int64_t total = 0;
    Occurrences affected;
    for (std::size_t n = 0; n < shapes.size(); ++n) {
        const int count = (shapes[n].*member).count;
        total += count;
        if (count > 0) affected.add(static_cast<int>(n));
    }
    if (total == 0) return;
    const auto first = static_cast<std::size_t>(affected.first);
    warnings.push_back(fmt::format("{} {} in {} of {} shapes (first: {} {} of '{}')", total, what,
                                   affected.count, shapes.size(), kind,
                                   (shapes[first].*member).first, set.names[first]));
}

FeatureSet empty_set(const MeshSequence& sequence, const std::vector<Point>& reference,
                     EdgeWeights weights) {
    FeatureSet set;
    const std::size_t shapes = sequence.shapes.size(), vertices = reference.size();
    set.names = sequence.names;
    set.reference = {reference, sequence.faces};
    set.weights = to_string(weights);
    set.features.resize(shapes * vertices * kFeatureDim);
    set.vertices.resize(shapes * vertices * 3);
    set.rotation.resize(shapes);
    set.translation.resize(shapes);
    set.consistency_energy.resize(shapes);
    set.consistency_gap.resize(shapes);
    set.largest_jump.resize(shapes);
    return set;
}

}  // namespace

FeatureSet extract_features(const MeshSequence& sequence, const std::vector<Point>& reference,
                            const ExtractOptions& options,
                            const std::function<void(int done, int total)>& progress) {
    check_sizes(sequence, reference);
    FeatureSet set = empty_set(sequence, reference, options.weights);
    const DeformationGradients gradients(set.reference, options.weights);
    std::vector<ShapeResult> shapes(sequence.shapes.size());
    Progress steps(progress, sequence.shape_count());
    parallel_for(sequence.shape_count(), [&](std::int64_t index) {
        const auto n = static_cast<std::size_t>(index);
        shapes[n] = extract_shape(gradients, sequence.shapes[n], options.align, n, set);
        steps.step();
    });
    const ConsistencyGraph graph =
        consistency_graph(gradients.rings(), unrest(shapes, reference.size()));
    parallel_for(sequence.shape_count(), [&](std::int64_t index) {
        const auto n = static_cast<std::size_t>(index);
        make_shape_consistent(graph, shapes[n], n, set);
        steps.step();
    });
    warn_of_reference(gradients, set.warnings);
    warn_of_shapes(shapes, set, &ShapeResult::zero_area_faces, "faces without area", "face",
                   set.warnings);
    warn_of_shapes(shapes, set, &ShapeResult::folded_rings, "rings whose normals cancel", "vertex",
                   set.warnings);
    warn_of_shapes(shapes, set, &ShapeResult::mirrored,
                   "vertices are mirrored (det T < 0: S has a negative eigenvalue)", "vertex",
                   set.warnings);
    return set;
}

}  // namespace mscomp
