// SPDX-License-Identifier: MIT
#include "mscomp/acap/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <optional>
#include <span>

#include "acap/coincident_vertices.h"
#include "acap/mesh/float_range.h"
#include "acap/mesh/polygon_mesh.h"
#include "check_findings.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"

namespace mscomp {
namespace {

Refusal refusal_of(const Error& error) {
    if (const auto* input = dynamic_cast<const InputError*>(&error)) {
        return {"malformed_file", error.what(), input->where()};
    }
    return {"unreadable_file", error.what(), {}};
}

/// Why `path` cannot be used beside a reference with `vertex_count` vertices: it cannot be read by
/// itself, or it is another mesh.
Refusal refusal_of(const Error& error, const std::string& path, int vertex_count) {
    Refusal refusal = refusal_of(error);
    try {
        const PolygonMesh mesh = read_polygons(path);
        const auto own = static_cast<int>(mesh.vertices.size());
        refusal.kind = own == vertex_count ? "other_faces" : "other_vertex_count";
        refusal.vertex_count = own == vertex_count ? 0 : own;
    } catch (const Error&) {
        // Then what was thrown first says it.
    }
    return refusal;
}

class Checker {
  public:
    Checker(const std::vector<std::string>& paths, const CheckOptions& options) {
        if (paths.empty()) throw UsageError("no mesh files given");
        const auto index = at(options.reference_index);
        if (options.reference_index < 0 || index >= paths.size()) {
            throw UsageError(fmt::format("--reference: got {}, wanted 0 to {}, or a mesh file",
                                         options.reference_index, paths.size() - 1));
        }
        files_ = checked_files(paths);
        report_.files = static_cast<int>(paths.size());
        open_reference(options.reference_file.empty() ? paths[index] : options.reference_file);
    }

    CheckReport run(const std::function<void(int, int)>& progress) {
        if (meshes_) {
            measure_reference();
            look_at_files(progress);
            find_oddities_of_reference();
        }
        find_refusals(files_, report_, report_.findings);
        if (coincident_) {
            find_coincident(coincident_->lowest(), report_.reference, report_.findings);
        }
        if (meter_) {
            find_in_shapes(files_, face_numbers_, reference_, report_, report_.findings);
            find_copies(files_, *meshes_, reference_, meter_->radius(), report_.findings);
        }
        if (meshes_) find_passed_over();
        find_numbering(files_, report_.findings);
        find_single_shape();
        std::stable_sort(
            report_.findings.begin(), report_.findings.end(),
            [](const Finding& a, const Finding& b) { return a.severity < b.severity; });
        return std::move(report_);
    }

  private:
    /// `chosen`, or the first file that can be read.
    void open_reference(const std::string& chosen) {
        std::vector<std::string> paths(1);
        for (const CheckedFile& file : files_) paths.push_back(file.path);
        const auto open = [&](const std::string& path) -> std::optional<Refusal> {
            paths.front() = path;
            try {
                meshes_.emplace(paths);
                face_numbers_ = meshes_->face_numbers();
                report_.reference = path;
                return std::nullopt;
            } catch (const Error& error) {
                meshes_.reset();
                return refusal_of(error);
            }
        };
        const std::optional<Refusal> refusal = open(chosen);
        if (!refusal) return;
        for (CheckedFile& file : files_) {
            if (file.path == chosen) {
                file.refusal = refusal;
            } else if (!meshes_) {
                file.refusal = open(file.path);
            }
        }
        FindingBuilder builder(Severity::error, "unreadable_reference");
        CheckPlace place{.text = refusal->message, .file = chosen};
        place.line = refusal->where.line;
        place.column = refusal->where.column;
        builder.add(std::move(place));
        builder.finish(
            "the reference cannot be read",
            meshes_ ? fmt::format("The shapes are compared with {} instead.", report_.reference)
                    : "No other file can be read either.",
            report_.findings);
    }

    void measure_reference() {
        const TriangleMesh mesh{meshes_->shape(0), meshes_->faces()};
        coincident_ = std::make_unique<CoincidentVertices>(mesh);
        std::vector<int> own(mesh.vertices.size());
        std::iota(own.begin(), own.end(), 0);
        const VertexPlaces used(own, mesh.faces);
        const std::vector<Point> points = used.of_places(std::span(mesh.vertices));
        if (points.empty()) return refuse_reference_without_area("it has no faces");
        report_.vertices = meshes_->vertex_count();
        report_.faces = *std::max_element(face_numbers_.begin(), face_numbers_.end());
        report_.lowest = report_.highest = points.front();
        const Point center = centroid_of(points);
        double farthest = 0;
        for (const Point& point : points) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                report_.lowest[axis] = std::min(report_.lowest[axis], point[axis]);
                report_.highest[axis] = std::max(report_.highest[axis], point[axis]);
            }
            farthest = std::max(farthest, std::hypot(point[0] - center[0], point[1] - center[1],
                                                     point[2] - center[2]));
        }
        report_.unit_ball_scale = farthest > 0 ? 1 / farthest : 0;
        if (is_too_small_for_float(points)) return refuse_small_reference();
        try {
            meter_ = std::make_unique<FrameMeter>(mesh, used);
            StretchHistogram unused;
            reference_ = meter_->measure(mesh.vertices, unused);
        } catch (const MeshError& error) {
            refuse_reference_without_area(error.what());
        }
    }

    /// Once all shapes have said which vertices are one place.
    void find_oddities_of_reference() {
        if (report_.vertices > 0) {
            const VertexPlaces places(coincident_->lowest(), meshes_->faces());
            find_connectivity(meshes_->vertex_count(), meshes_->faces(), face_numbers_, places,
                              report_, report_.findings);
        }
        if (!meter_) return;
        find_reference_geometry(*meter_, face_numbers_, report_.reference, report_.findings);
    }

    void refuse_reference_without_area(std::string text) {
        FindingBuilder builder(Severity::error, "reference_without_area");
        builder.add({.text = std::move(text), .file = report_.reference});
        builder.finish("the reference has no face with an area",
                       "Features need a surface. Is this a point cloud, or was everything scaled "
                       "to zero?",
                       report_.findings);
    }

    void refuse_small_reference() {
        FindingBuilder builder(Severity::error, "reference_too_small");
        builder.add({.text = "all of it is smaller than 1e-30", .file = report_.reference});
        builder.finish("the reference is too small for float32",
                       "Its positions would be stored as 0 or lose their digits. Scale all meshes "
                       "up.",
                       report_.findings);
    }

    /// In portions, so that there is something between the shapes: progress, and a place to stop.
    void look_at_files(const std::function<void(int, int)>& progress) {
        const Chunks portions{report_.files, 4 * thread_count()};
        StretchHistogram total;
        for (std::int64_t portion = 0; portion < portions.count(); ++portion) {
            const std::int64_t begin = portions.begin(portion), end = portions.end(portion);
            std::vector<StretchHistogram> histograms(at(end - begin));
            parallel_for(end - begin,
                         [&](std::int64_t k) { look_at(begin + k, histograms[at(k)]); });
            // Counts, so their sum is the same however they are grouped.
            for (const StretchHistogram& histogram : histograms) total.add(histogram);
            if (progress) progress(static_cast<int>(end), report_.files);
        }
        report_.stretch.most_below = total.quantile(kMostStretches);
        for (const CheckedFile& file : files_) {
            if (file.refusal) continue;
            ++report_.usable;
            if (!(file.facts.largest_stretch > report_.stretch.largest)) continue;
            report_.stretch.largest = file.facts.largest_stretch;
            report_.stretch.file = file.path;
            report_.stretch.vertex = file.facts.largest_stretch_vertex + 1;
        }
    }

    void look_at(std::int64_t index, StretchHistogram& histogram) {
        CheckedFile& file = files_[at(index)];
        if (file.refusal) return;
        std::vector<Point> shape;
        try {
            shape = meshes_->shape(static_cast<int>(index) + 1);
        } catch (const Error& error) {
            file.refusal = refusal_of(error, file.path, meshes_->vertex_count());
            return;
        }
        coincident_->keep(shape);
        if (meter_) file.facts = meter_->measure(shape, histogram);
    }

    void find_passed_over() {
        FindingBuilder builder(Severity::warning, "passed_over");
        for (const std::string& sentence : meshes_->warnings()) {
            builder.add({.text = sentence, .file = report_.reference});
        }
        builder.finish("the files hold something that no mesh has",
                       "It is passed over. Export again without it if it should be there.",
                       report_.findings);
    }

    void find_single_shape() {
        if (report_.files != 1) return;
        FindingBuilder builder(Severity::note, "single_shape");
        builder.add({.text = files_.front().label, .file = files_.front().path});
        builder.finish("there is one shape only",
                       "Deformation is learnt from several shapes of one mesh.", report_.findings);
    }

    std::vector<CheckedFile> files_;
    std::optional<MeshFiles> meshes_;  // shape 0 is the reference, shape i+1 is file i
    std::vector<int> face_numbers_;    // (F) of every triangle, in the file
    std::unique_ptr<CoincidentVertices> coincident_;
    std::unique_ptr<FrameMeter> meter_;
    FrameFacts reference_;
    CheckReport report_;
};

}  // namespace

std::string to_string(Severity severity) {
    switch (severity) {
        case Severity::error:
            return "error";
        case Severity::warning:
            return "warning";
        case Severity::note:
            break;
    }
    return "note";
}

int CheckReport::count(Severity severity) const {
    return static_cast<int>(
        std::count_if(findings.begin(), findings.end(),
                      [severity](const Finding& found) { return found.severity == severity; }));
}

CheckReport check_meshes(const std::vector<std::string>& paths, const CheckOptions& options,
                         const std::function<void(int, int)>& progress) {
    return Checker(paths, options).run(progress);
}

}  // namespace mscomp
