// SPDX-License-Identifier: MIT
#include "mscomp/acap/extract.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <utility>

#include "acap/mesh/float_range.h"
#include "acap/turns/consistency.h"
#include "acap/turns/neighbor_starts.h"
#include "coincident_vertices.h"
#include "deformation_gradient.h"
#include "extract_warnings.h"
#include "feature_format.h"
#include "mscomp/acap/alignment.h"
#include "mscomp/acap/shape_outliers.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"
#include "mscomp/base/points.h"
#include "shape_extraction.h"

namespace mscomp {
namespace {

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

/// Rows of the W places of a surface, put into those of its V vertices.
class SurfaceRows final : public FeatureRows {
  public:
    SurfaceRows(FeatureRows& rows, const VertexPlaces& places, std::size_t vertex_count)
        : rows_(rows), places_(places), vertex_count_(vertex_count) {}

    /// Vertices are put whole: coincident ones keep what float32 tells apart.
    void put_vertices(int shape, std::span<const float> row) override {
        rows_.put_vertices(shape, row);
    }
    void put_features(int shape, std::span<const float> row) override {
        std::vector<float> all = reference_features();
        places_.to_vertices(row, std::span(all), kFeatureDim);
        rows_.put_features(shape, all);
    }
    void get_features(int shape, std::span<float> row) const override {
        const auto all = std::make_unique<float[]>(vertex_count_ * kFeatureDim);
        const std::span<float> rows(all.get(), vertex_count_ * kFeatureDim);
        rows_.get_features(shape, rows);
        const std::vector<float> wanted =
            places_.of_places(std::span<const float>(rows), kFeatureDim);
        std::ranges::copy(wanted, row.begin());
    }

  private:
    std::vector<float> reference_features() const {
        std::vector<float> all;
        all.reserve(vertex_count_ * kFeatureDim);
        for (std::size_t v = 0; v < vertex_count_; ++v) {
            all.insert(all.end(), kReferenceFeature.begin(), kReferenceFeature.end());
        }
        return all;
    }

    FeatureRows& rows_;
    const VertexPlaces& places_;
    std::size_t vertex_count_;
};

/// Where to lay the origin: at 0, or amid a surface that float32 could not hold where it lies.
Point origin_for(const std::vector<Point>& reference, const VertexPlaces& places) {
    const std::vector<Point> surface = places.of_places(std::span(reference));
    return distance_from_origin(surface) > kFarFromOrigin ? mean_point(surface) : Point{};
}

std::vector<float> to_floats(const std::vector<Point>& points) {
    std::vector<float> result;
    result.reserve(3 * points.size());
    for (const Point& point : points) {
        for (const double x : point) result.push_back(static_cast<float>(x));
    }
    return result;
}

/// The work on one set. Memory is what the shared part takes and one shape per thread, whatever N:
/// rows wait in `rows`, as float32, for the turns that only the whole set can tell. That rounding
/// is relative to each component of r, so it keeps the axes of small rotations, too.
class Extraction {
  public:
    /// `origin`: where the origin of `set` lies in the input.
    Extraction(const ShapeSource& source, const ExtractOptions& options, const Point& origin,
               PlacedFeatures& set, FeatureRows& rows, Progress& progress)
        : source_(source),
          align_(options.align),
          set_(set),
          surface_rows_(rows, set.places, set.reference.vertices.size()),
          rows_(set.places.are_all_vertices() ? rows : surface_rows_),
          progress_(progress),
          origin_(origin),
          gradients_(set.places.surface(set.reference), options.weights),
          outliers_(gradients_.reference(), set.shape_count()),
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
        if (origin_ != Point{}) warn_of_moved_origin(origin_, set_);
        warn_of_oddities(gradients_, oddities_, source_.face_numbers(), set_);
        const std::vector<std::string> outliers = outliers_.warnings(set_.names);
        set_.warnings.insert(set_.warnings.end(), outliers.begin(), outliers.end());
    }

  private:
    std::size_t place_count() const { return gradients_.reference().vertices.size(); }

    /// How the input gets to where it is kept.
    RigidMotion motion_of(const std::vector<Point>& surface) const {
        if (align_) return best_rigid_motion(surface, gradients_.reference().vertices);
        RigidMotion motion;
        motion.translation = -as_vector(origin_);
        return motion;
    }

    /// Principal logarithms and S of all shapes. Returns the root mean square rotation angle of
    /// every vertex over the shapes: how little it turns.
    std::vector<double> extract_shapes() {
        const std::size_t count_of_places = place_count();
        std::vector<double> sum(count_of_places, 0.0);
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
                for (std::size_t v = 0; v < count_of_places; ++v) sum[v] += shape[v];
            }
        }
        for (double& value : sum) value = std::sqrt(value / static_cast<double>(chunks.total));
        return sum;
    }

    /// Returns the squared rotation angle of every place.
    std::vector<double> extract(int index) {
        const auto n = at(index);
        const std::vector<Point> input = source_.shape(index);
        check_size(set_.names[n], input.size(), set_.reference.vertices);
        const RigidMotion motion = motion_of(set_.places.of_places(std::span(input)));
        using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
        Eigen::Map<RowMajor>(set_.rotation[n].data()) = motion.rotation;
        Eigen::Map<Eigen::Vector3d>(set_.translation[n].data()) = motion.translation;
        const bool stays = !align_ && origin_ == Point{};
        const std::vector<Point> aligned = stays ? input : moved(input, motion);
        const std::vector<Point> surface = set_.places.of_places(std::span(aligned));
        const ExtractedShape shape = extract_shape(gradients_, surface);
        oddities_[n] = {shape.zero_area_faces, shape.folded_rings, shape.mirrored,
                        !align_ && distance_from_origin(surface) > kFarFromOrigin};
        outliers_.look_at(index, surface, shape.features);
        rows_.put_vertices(index, to_floats(aligned));
        rows_.put_features(index, shape.features);
        std::vector<double> squares;
        squares.reserve(surface.size());
        for (const Eigen::Vector3d& r : rotation_vectors_of(shape.features)) {
            squares.push_back(r.squaredNorm());
        }
        return squares;
    }

    void choose_turns(const ConsistencyGraph& graph, int index) {
        std::vector<float> row(place_count() * kFeatureDim);
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

    const ShapeSource& source_;
    bool align_;
    PlacedFeatures& set_;
    SurfaceRows surface_rows_;
    FeatureRows& rows_;  // of the places
    Progress& progress_;
    Point origin_;                    // 0, or amid a reference that is far away
    DeformationGradients gradients_;  // of the surface
    ShapeOutliers outliers_;
    std::vector<ShapeOddities> oddities_;        // (N)
    std::vector<ConsistencySummary> summaries_;  // (N)
};

}  // namespace

VertexPlaces vertex_places(const ShapeSource& source, const std::vector<Point>& reference) {
    check_faces(source, reference);
    CoincidentVertices coincident({reference, source.faces()});
    const Chunks portions{source.shape_count(), 4 * thread_count()};
    for (std::int64_t portion = 0; portion < portions.count() && coincident.any(); ++portion) {
        const std::int64_t begin = portions.begin(portion);
        parallel_for(portions.end(portion) - begin, [&](std::int64_t k) {
            const auto index = static_cast<int>(begin + k);
            const std::vector<Point> shape = source.shape(index);
            check_size(source.names()[at(index)], shape.size(), reference);
            coincident.keep(shape);
        });
    }
    return {coincident.lowest(), source.faces()};
}

PlacedFeatures feature_outline(const ShapeSource& source, const std::vector<Point>& reference,
                               const ExtractOptions& options) {
    PlacedFeatures set;
    set.names = source.names();
    set.reference = {reference, source.faces()};
    set.places = options.places ? *options.places : vertex_places(source, reference);
    const Point origin = origin_for(reference, set.places);
    if (origin != Point{}) {
        for (Point& point : set.reference.vertices) point = minus(point, origin);
    }
    set.weights = to_string(options.weights);
    set.rotation.resize(set.names.size());
    set.translation.resize(set.names.size());
    for (const PerShapeNumber& number : kPerShapeNumbers) {
        (set.*number.member).resize(set.names.size());
    }
    return set;
}

PlacedFeatures extract_features(const ShapeSource& source, const std::vector<Point>& reference,
                                const ExtractOptions& options, FeatureRows& rows,
                                const ExtractProgress& progress) {
    if (source.shape_count() > 0) {
        check_size(source.names()[0], at(source.vertex_count()), reference);
    }
    check_faces(source, reference);
    PlacedFeatures set = feature_outline(source, reference, options);
    if (is_too_small_for_float(set.places.surface(set.reference).vertices)) {
        throw MeshError("the reference is too small for float32; scale all meshes up");
    }
    Progress steps(progress, source.shape_count());
    Extraction(source, options, origin_for(reference, set.places), set, rows, steps).run();
    return set;
}

PlacedFeatures extract_features(const MeshSequence& sequence, const std::vector<Point>& reference,
                                const ExtractOptions& options, const ExtractProgress& progress) {
    const auto values = sequence.shapes.size() * reference.size();
    FeatureSet set;
    set.features.resize(values * kFeatureDim);
    set.vertices.resize(values * 3);
    MemoryRows rows(set);
    PlacedFeatures result =
        extract_features(SequenceSource(sequence), reference, options, rows, progress);
    result.features = std::move(set.features);
    result.vertices = std::move(set.vertices);
    return result;
}

}  // namespace mscomp
