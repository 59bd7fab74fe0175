// SPDX-License-Identifier: MIT
#include "mscomp/acap/extract.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <utility>

#include "acap/turns/consistency.h"
#include "acap/turns/neighbor_starts.h"
#include "deformation_gradient.h"
#include "feature_format.h"
#include "float_range.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"
#include "shape_extraction.h"

namespace mscomp {
namespace {

struct ShapeOddities {
    Occurrences zero_area_faces, folded_rings, mirrored;
    bool far_from_origin = false;
};

/// Tells the caller, one call at a time, how many of the shapes are done.
class Progress {
  public:
    Progress(const ExtractProgress& report, int total) : report_(report), total_(total) {}

    /// A shape was read, got its turns, or was compared with its neighbours.
    void step() {
        if (!report_) return;
        const std::lock_guard<std::mutex> lock(mutex_);
        // Shapes may be compared again, which nobody can know beforehand.
        if (steps_ < kStepsPerShape * total_) ++steps_;
        report_(steps_ / kStepsPerShape, total_);
    }

  private:
    static constexpr int kStepsPerShape = 3;

    const ExtractProgress& report_;
    int total_;
    int steps_ = 0;
    std::mutex mutex_;
};

void check_size(std::string_view name, std::size_t vertices, const std::vector<Point>& reference) {
    if (vertices == reference.size()) return;
    throw MeshError(fmt::format("shape '{}' has {} vertices, the reference has {}", name, vertices,
                                reference.size()));
}

void check_faces(const ShapeSource& source, const std::vector<Point>& reference) {
    for (const Face& face : source.faces()) {
        for (const int corner : face) {
            if (corner >= 0 && corner < static_cast<int>(reference.size())) continue;
            throw MeshError(fmt::format("a face refers to vertex {}, the reference has {}", corner,
                                        reference.size()));
        }
    }
}

/// Faces as their file counts them (from 0), instead of triangles.
Occurrences in_file(Occurrences faces, const std::vector<int>& face_numbers) {
    if (faces.count > 0 && !face_numbers.empty()) faces.first = face_numbers[at(faces.first)] - 1;
    return faces;
}

/// Places count from 1, as in mesh files.
void warn_of_reference(const DeformationGradients& gradients, const std::vector<int>& face_numbers,
                       std::vector<std::string>& warnings) {
    const auto warn = [&](const Occurrences& found, const char* what, const char* kind) {
        if (found.count == 0) return;
        warnings.push_back(fmt::format("reference: {} {} (first: {} {})", found.count, what, kind,
                                       found.first + 1));
    };
    warn(in_file(gradients.zero_area_faces(), face_numbers), "faces without area carry no weight",
         "face");
    warn(gradients.isolated_vertices(), "vertices without faces get the identity", "vertex");
    warn(gradients.folded_rings(),
         "rings whose normals cancel use the direction of their least spread", "vertex");
    warn(gradients.degenerate_rings(), "rings without width take the mean of their neighbours",
         "vertex");
}

/// One sentence for all shapes together: totals, and where it happened first, from 1.
void warn_of_shapes(const std::vector<ShapeOddities>& shapes, const FeatureSet& set,
                    Occurrences ShapeOddities::*member, const char* what, const char* kind,
                    std::vector<std::string>& warnings) {
    std::int64_t total = 0;
    Occurrences affected;
    for (std::size_t n = 0; n < shapes.size(); ++n) {
        const int count = (shapes[n].*member).count;
        total += count;
        if (count > 0) affected.add(static_cast<int>(n));
    }
    if (total == 0) return;
    const auto first = at(affected.first);
    warnings.push_back(fmt::format("{} {} in {} of {} shapes (first: {} {} of '{}')", total, what,
                                   affected.count, shapes.size(), kind,
                                   (shapes[first].*member).first + 1, set.names[first]));
}

bool is_far_from_origin(const std::vector<Point>& shape) {
    return distance_from_origin(shape) > kFarFromOrigin;
}

void warn_of_far_shapes(const std::vector<ShapeOddities>& shapes, const FeatureSet& set,
                        std::vector<std::string>& warnings) {
    const auto is_far = [](const ShapeOddities& shape) { return shape.far_from_origin; };
    const auto first = std::ranges::find_if(shapes, is_far);
    if (first == shapes.end()) return;
    warnings.push_back(fmt::format(
        "{} of {} shapes lie over {} times their size from the origin (first: '{}'); float32 keeps "
        "few digits of such positions: move all meshes to the origin first",
        std::ranges::count_if(shapes, is_far), shapes.size(), kFarFromOrigin,
        set.names[at(first - shapes.begin())]));
}

/// The work on one set. Memory is what the shared part takes and one shape per thread, whatever N:
/// rows wait in `rows`, as float32, for the turns that only the whole set can tell. That rounding
/// is relative to each component of r, so it keeps the axes of small rotations, too.
class Extraction {
  public:
    Extraction(const ShapeSource& source, const ExtractOptions& options, FeatureSet& set,
               FeatureRows& rows, Progress& progress)
        : source_(source),
          align_(options.align),
          set_(set),
          rows_(rows),
          progress_(progress),
          gradients_(set.reference, options.weights),
          face_numbers_(source.face_numbers()),
          far_from_origin_(align_ && is_far_from_origin(set.reference.vertices)),
          oddities_(set.names.size()),
          summaries_(set.names.size()) {}

    void run() {
        const ConsistencyGraph graph = consistency_graph(gradients_.rings(), extract_shapes());
        parallel_for(set_.shape_count(), [&](std::int64_t index) {
            choose_turns(graph, static_cast<int>(index));
            progress_.step();
        });
        improve_from_neighbors(graph, rows_, summaries_, [&] { progress_.step(); });
        store_summaries();
        warn();
    }

  private:
    /// Principal logarithms and S of all shapes. Returns the root mean square rotation angle of
    /// every vertex over the shapes: how little it turns.
    std::vector<double> extract_shapes() {
        const auto vertex_count = set_.reference.vertices.size();
        std::vector<double> sum(vertex_count, 0.0);
        // Added in the order of the shapes, so the size of the chunks changes no bit.
        const Chunks chunks{set_.shape_count(), 8 * static_cast<std::int64_t>(thread_count())};
        std::vector<std::vector<double>> squares(at(chunks.size));
        for (std::int64_t chunk = 0; chunk < chunks.count(); ++chunk) {
            const std::int64_t begin = chunks.begin(chunk), count = chunks.end(chunk) - begin;
            parallel_for(count, [&](std::int64_t i) {
                squares[at(i)] = extract(static_cast<int>(begin + i));
                progress_.step();
            });
            for (std::int64_t i = 0; i < count; ++i) {
                const std::vector<double>& shape = squares[at(i)];
                for (std::size_t v = 0; v < vertex_count; ++v) sum[v] += shape[v];
            }
        }
        for (double& value : sum) value = std::sqrt(value / static_cast<double>(chunks.total));
        return sum;
    }

    /// Returns the squared rotation angle of every vertex.
    std::vector<double> extract(int index) {
        const auto n = at(index);
        const std::vector<Point> input = source_.shape(index);
        check_size(set_.names[n], input.size(), set_.reference.vertices);
        const ExtractedShape shape =
            extract_shape(gradients_, set_.reference.vertices, input, align_);
        using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
        Eigen::Map<RowMajor>(set_.rotation[n].data()) = shape.motion.rotation;
        Eigen::Map<Eigen::Vector3d>(set_.translation[n].data()) = shape.motion.translation;
        oddities_[n] = {in_file(shape.zero_area_faces, face_numbers_), shape.folded_rings,
                        shape.mirrored, far_from_origin_ || (!align_ && is_far_from_origin(input))};
        rows_.put_vertices(index, shape.vertices);
        rows_.put_features(index, shape.features);
        std::vector<double> squares;
        squares.reserve(input.size());
        for (const Eigen::Vector3d& r : rotation_vectors_of(shape.features)) {
            squares.push_back(r.squaredNorm());
        }
        return squares;
    }

    void choose_turns(const ConsistencyGraph& graph, int index) {
        std::vector<float> row(set_.reference.vertices.size() * kFeatureDim);
        rows_.get_features(index, row);
        std::vector<Eigen::Vector3d> rotation_vectors = rotation_vectors_of(row);
        summaries_[at(index)] = make_consistent(graph, rotation_vectors);
        store_rotation_vectors(rotation_vectors, row);
        rows_.put_features(index, row);
    }

    void store_summaries() {
        for (std::size_t n = 0; n < summaries_.size(); ++n) {
            const ConsistencySummary& summary = summaries_[n];
            set_.principal_energy[n] = summary.principal_energy;
            set_.propagation_energy[n] = summary.propagation_energy;
            set_.relaxation_energy[n] = summary.relaxation_energy;
            set_.consistency_energy[n] = summary.energy;
            set_.consistency_gap[n] = summary.energy - summary.lower_bound;
            set_.largest_jump[n] = summary.largest_jump;
            set_.large_jumps[n] = summary.large_jumps;
            set_.inherent_jumps[n] = summary.inherent_jumps;
            set_.removable_jumps[n] = summary.removable_jumps;
        }
    }

    void warn() {
        warn_of_reference(gradients_, face_numbers_, set_.warnings);
        warn_of_shapes(oddities_, set_, &ShapeOddities::zero_area_faces, "faces without area",
                       "face", set_.warnings);
        warn_of_shapes(oddities_, set_, &ShapeOddities::folded_rings, "rings whose normals cancel",
                       "vertex", set_.warnings);
        warn_of_shapes(oddities_, set_, &ShapeOddities::mirrored,
                       "vertices are mirrored (det T < 0: S has a negative eigenvalue)", "vertex",
                       set_.warnings);
        warn_of_far_shapes(oddities_, set_, set_.warnings);
    }

    const ShapeSource& source_;
    bool align_;
    FeatureSet& set_;
    FeatureRows& rows_;
    Progress& progress_;
    DeformationGradients gradients_;
    std::vector<int> face_numbers_;              // of the triangles in their file, or empty
    bool far_from_origin_;                       // where all shapes are moved to
    std::vector<ShapeOddities> oddities_;        // (N)
    std::vector<ConsistencySummary> summaries_;  // (N)
};

}  // namespace

FeatureSet feature_outline(const ShapeSource& source, const std::vector<Point>& reference,
                           const ExtractOptions& options) {
    FeatureSet set;
    set.names = source.names();
    set.reference = {reference, source.faces()};
    set.weights = to_string(options.weights);
    set.rotation.resize(set.names.size());
    set.translation.resize(set.names.size());
    for (const PerShapeNumber& number : kPerShapeNumbers) {
        (set.*number.member).resize(set.names.size());
    }
    return set;
}

FeatureSet extract_features(const ShapeSource& source, const std::vector<Point>& reference,
                            const ExtractOptions& options, FeatureRows& rows,
                            const ExtractProgress& progress) {
    if (source.shape_count() > 0) {
        check_size(source.names()[0], at(source.vertex_count()), reference);
    }
    check_faces(source, reference);
    if (is_too_small_for_float(reference)) {
        throw MeshError("the reference is too small for float32; scale all meshes up");
    }
    FeatureSet set = feature_outline(source, reference, options);
    Progress steps(progress, source.shape_count());
    Extraction(source, options, set, rows, steps).run();
    return set;
}

FeatureSet extract_features(const MeshSequence& sequence, const std::vector<Point>& reference,
                            const ExtractOptions& options, const ExtractProgress& progress) {
    const auto values = sequence.shapes.size() * reference.size();
    FeatureSet set;
    set.features.resize(values * kFeatureDim);
    set.vertices.resize(values * 3);
    MemoryRows rows(set);
    FeatureSet result =
        extract_features(SequenceSource(sequence), reference, options, rows, progress);
    result.features = std::move(set.features);
    result.vertices = std::move(set.vertices);
    return result;
}

}  // namespace mscomp
