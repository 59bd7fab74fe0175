// SPDX-License-Identifier: MIT
#include "mscomp/report/evaluation.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "component_report.h"
#include "error_curves.h"
#include "evaluation_files.h"
#include "known_units.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/interruption.h"
#include "mscomp/base/output_folder.h"
#include "mscomp/base/paths.h"
#include "mscomp/eval/piece_error.h"
#include "mscomp/eval/shape_measures.h"
#include "mscomp/model/kept_model.h"
#include "mscomp/run/fits.h"
#include "mscomp/run/shape_decoder.h"
#include "truth_report.h"

namespace mscomp {
namespace {

using nlohmann::ordered_json;

FeatureFile opened_features(const std::string& path, const TrainedRun& run) {
    FeatureFile file(path);
    require_mesh_of(run, file);
    return file;
}

std::string features_path(const EvaluationOptions& options, const TrainedRun& run) {
    if (!options.features.empty()) return options.features;
    const std::string& source = run.context().source;
    if (path_exists(source)) return source;
    throw IoError(source,
                  "no such file, but the model was trained on it; if it is elsewhere now, name it "
                  "after the run");
}

/// The split to measure, which has to be of this file.
std::string split_of(const EvaluationOptions& options, const TrainedRun& run,
                     const FeatureFile& file) {
    const bool is_own = file.data_hash() == run.context().source_hash;
    if (options.split.empty()) {
        return is_own && !run.context().test_shapes.empty() ? "test" : "all";
    }
    if (!is_own && options.split != "all") {
        throw UsageError(
            fmt::format("--split {}: {} is not the file the model was trained on, nor the same; "
                        "wanted that file or --split all",
                        options.split, file.path()));
    }
    return options.split;
}

void require_one_of(const char* what, const std::string& value,
                    std::initializer_list<const char*> known) {
    if (std::ranges::find(known, value) != known.end()) return;
    throw UsageError(
        fmt::format("evaluation: {} '{}', wanted one of {}", what, value, fmt::join(known, ", ")));
}

ShapeOrder order_of(const EvaluationOptions& options, const TrainedRun& run) {
    if (options.order == "sequence") return ShapeOrder::sequence;
    if (options.order == "set") return ShapeOrder::set;
    return run.config.data.split.train == SplitKind::every ? ShapeOrder::sequence : ShapeOrder::set;
}

/// One fit measured over all shapes.
struct MeasuredFit {
    Fit fit;
    ShapeMeasures measures;
    PieceRmsError pieces;
    std::vector<double> codes{};  // (n,K)

    void add(const ShapeDecoder& decoder, const FeatureFile& file, std::span<const int> shapes,
             const std::vector<DecodedShape>& decoded) {
        for (std::size_t m = 0; m < shapes.size(); ++m) {
            const auto shape = at(shapes[m]);
            measures.add(file.outline().names[shape], decoder.truth(shapes[m]), decoded[m].vertices,
                         decoder.relative_squared_error_of(shapes[m], decoded[m]),
                         decoder.truth_in_place(shapes[m]));
            pieces.add(decoder.truth(shapes[m]), decoded[m].vertices);
            codes.insert(codes.end(), decoded[m].codes.begin(), decoded[m].codes.end());
        }
    }
};

ordered_json optional_number(const std::optional<double>& value) {
    return value ? ordered_json(*value) : ordered_json(nullptr);
}

ordered_json total_json(const ShapeMeasures& measures, const PieceRmsError& pieces) {
    const SetErrors total = measures.total();
    const bool has_pieces = pieces.piece_count() > 1;
    return {{"rms_error", total.rms_error},
            {"rms_error_pieces", has_pieces ? ordered_json(pieces.value()) : ordered_json(nullptr)},
            {"sted", optional_number(total.sted.value)},
            {"sted_spatial", total.sted.spatial},
            {"sted_temporal", optional_number(total.sted.temporal)},
            {"mean_vertex_distance", total.mean_vertex_distance},
            {"max_vertex_distance", total.max_vertex_distance},
            {"relative_squared_error_max", optional_number(total.relative_squared_error_max)},
            {"relative_squared_error_mean", optional_number(total.relative_squared_error_mean)}};
}

/// A run measured on the shapes of one split of one file.
class Evaluation {
  public:
    explicit Evaluation(const EvaluationOptions& options)
        : options_(options),
          run_(open_run(options.run, ShapeDecoder::kGroup)),
          file_(opened_features(features_path(options, run_), run_)),
          split_(split_of(options, run_, file_)),
          components_(run_.components()),
          acting_(components_),
          asked_(fits_of_run(options.fit, run_)),
          decoder_(decoder(options.kept)),
          by_components_(options.components, acting_, reference().vertices, asked_),
          by_handles_(options.handles, run_, decoder_.training_codes(), acting_),
          undeformed_(reference(), order_of(options, run_)),
          undeformed_pieces_(reference()) {
        shapes_ = shapes_of_split(run_, file_, split_);
        if (!options.units.empty()) units_.emplace(options.units, file_.shape_count());
        if (!options.truth.empty()) truth_.emplace(options.truth, file_, run_, components_);
        for (const Fit fit : asked_) {
            fits_.push_back({fit, ShapeMeasures(reference(), order_of(options, run_)),
                             PieceRmsError(reference())});
        }
    }

    void measure() {
        const auto count = static_cast<std::int64_t>(shapes_.size());
        const auto fitted_ones = static_cast<std::size_t>(
            std::ranges::count_if(asked_, [](Fit fit) { return fit != Fit::features; }));
        const auto passes = static_cast<std::int64_t>(1 + fitted_ones + options_.handles.size() +
                                                      (options_.components.empty() ? 0 : 1));
        std::int64_t done = 0;
        for (std::size_t first = 0; first < shapes_.size(); first += ShapeDecoder::kGroup) {
            const std::span<const int> group = std::span<const int>(shapes_).subspan(
                first, std::min<std::size_t>(ShapeDecoder::kGroup, shapes_.size() - first));
            const auto finish = [&](std::size_t steps) {
                if (steps == 0) return;
                done += static_cast<std::int64_t>(steps * group.size());
                if (options_.on_progress) options_.on_progress(done / passes, count);
            };
            add_undeformed(group);
            const std::vector<DecodedShape> encoded = decoder_.encode(group);
            finish(1);
            for (MeasuredFit& measured : fits_) {
                measured.add(decoder_, file_, group,
                             fitted(measured.fit, decoder_, group, encoded));
                finish(measured.fit == Fit::features ? 0 : 1);
            }
            if (!options_.components.empty()) {
                by_components_.add(decoder_, group, encoded);
                finish(1);
            }
            by_handles_.add(decoder_, group);
            finish(options_.handles.size());
            for (const int shape : group) file_.forget(shape);
        }
    }

    ordered_json report() {
        const int levels = static_cast<int>(run_.model->levels().size());
        const ComponentReport of_components = component_report(components_, levels, run_.context());
        ordered_json report{
            {"run", options_.run},
            {"set", std::filesystem::path(file_.path()).stem().string()},
            {"features_file", file_.path()},
            {"split", split_},
            {"shapes", shapes_.size()},
            {"shapes_in_set", file_.shape_count()},
            {"kind", run_.config.kind},
            {"order", order_of(options_, run_) == ShapeOrder::set ? "set" : "sequence"},
            {"kept_only", options_.kept},
            {"components", of_components.kept_per_level}};
        for (std::size_t f = 0; f < fits_.size(); ++f) {
            ordered_json& entry = report[name_of(asked_[f])] =
                total_json(fits_[f].measures, fits_[f].pieces);
            entry["support_mean"] = of_components.support_mean;
            if (!options_.components.empty()) {
                entry["by_components"] = by_components_.errors()[f].json();
            }
        }
        report["reference"] = total_json(undeformed_, undeformed_pieces_);
        if (!options_.handles.empty()) report["by_handles"] = by_handles_.errors().json();
        if (units_) report["units"] = units_json();
        if (truth_) report["truth"] = truth_json();
        report["worst"] = worst_json();
        report["per_shape"] = shapes_json();
        report["component_list"] = of_components.list;
        report["cosine"] = of_components.cosine;
        return report;
    }

    void write_files(const ordered_json& report) {
        OutputFolder output(options_.output);
        output.drop(kPicture);
        write_file(output.path("table.csv"), csv_of(report["per_shape"]));
        write_file(output.path("components.csv"), csv_of(report["component_list"]));
        std::vector<int> worst;
        for (const int n : worst_shapes(fits_.back().measures.shapes(), options_.worst)) {
            worst.push_back(shapes_[at(n)]);
        }
        if (!worst.empty()) {
            write_error_picture(output.path(kPicture),
                                fmt::format("{}: the worst of {} shapes by the {} fit",
                                            options_.run, shapes_.size(), name_of(asked_.back())),
                                decoder_, run_, file_, worst, asked_);
        }
        output.commit();
    }

  private:
    static constexpr const char* kPicture = "errors.png";

    const TriangleMesh& reference() const { return run_.context().reference; }
    /// Of all components, or of the kept ones, which then are those that act.
    ShapeDecoder decoder(bool of_kept) {
        const auto check = [] { throw_if_interrupted("interrupted; nothing was written"); };
        if (!of_kept) return {run_, file_, check};
        kept_ = std::make_unique<KeptModel>(*run_.model, components_);
        acting_ = kept_->components();
        return {run_, *kept_, kept_->refitted(run_.file.codes()), file_, check};
    }
    /// What a result has to stay below to be worth anything.
    void add_undeformed(std::span<const int> shapes) {
        for (const int shape : shapes) {
            undeformed_.add(file_.outline().names[at(shape)], decoder_.truth(shape),
                            reference().vertices,
                            decoder_.relative_squared_error_of_reference(shape),
                            decoder_.truth_in_place(shape));
            undeformed_pieces_.add(decoder_.truth(shape), reference().vertices);
        }
    }

    ordered_json units_json() const {
        ordered_json result{{"file", options_.units},
                            {"units", units_->unit_count()},
                            {"varying", units_->varying_count(shapes_)},
                            {"threshold", KnownUnits::kThreshold}};
        for (const MeasuredFit& fit : fits_) {
            result[name_of(fit.fit)] = units_->matches(shapes_, fit.codes, acting_);
        }
        return result;
    }

    ordered_json truth_json() const {
        ordered_json result = truth_->by_overlap(shapes_);
        for (const MeasuredFit& fit : fits_) {
            result[name_of(fit.fit)] = truth_->by_correlation(shapes_, fit.codes);
        }
        return result;
    }

    ordered_json worst_json() const {
        ordered_json result = ordered_json::object();
        for (const MeasuredFit& fit : fits_) {
            ordered_json worst = ordered_json::array();
            for (const int n : worst_shapes(fit.measures.shapes(), options_.worst)) {
                worst.push_back(shape_json(fit, at(n)));
            }
            result[name_of(fit.fit)] = worst;
        }
        return result;
    }

    ordered_json shapes_json() const {
        ordered_json rows = ordered_json::array();
        for (std::size_t n = 0; n < shapes_.size(); ++n) {
            ordered_json row = shape_names(n);
            for (const MeasuredFit& fit : fits_) {
                row[name_of(fit.fit)] = shape_errors(fit.measures.shapes()[n]);
            }
            rows.push_back(row);
        }
        return rows;
    }

    ordered_json shape_names(std::size_t n) const {
        return {{"shape", shapes_[n]}, {"name", fits_.front().measures.shapes()[n].name}};
    }
    ordered_json shape_errors(const ShapeErrors& errors) const {
        return {{"rms_error", errors.rms_error},
                {"mean_vertex_distance", errors.mean_vertex_distance},
                {"max_vertex_distance", errors.max_vertex_distance},
                {"worst_vertex", run_.context().places.vertex(errors.worst_vertex)},
                {"relative_squared_error", optional_number(errors.relative_squared_error)}};
    }
    ordered_json shape_json(const MeasuredFit& fit, std::size_t n) const {
        ordered_json result = shape_names(n);
        result.update(shape_errors(fit.measures.shapes()[n]));
        return result;
    }

    const EvaluationOptions& options_;
    TrainedRun run_;
    FeatureFile file_;
    std::string split_;
    std::vector<Component> components_;
    std::unique_ptr<KeptModel> kept_;  // of what is measured, if only kept ones act
    std::vector<Component> acting_;
    std::vector<Fit> asked_;
    ShapeDecoder decoder_;
    ComponentCurve by_components_;
    HandleCurve by_handles_;
    std::vector<int> shapes_;
    std::optional<KnownUnits> units_;
    std::optional<TruthReport> truth_;
    std::vector<MeasuredFit> fits_;  // those asked for
    ShapeMeasures undeformed_;       // of the reference as the result for every shape
    PieceRmsError undeformed_pieces_;
};

}  // namespace

nlohmann::ordered_json evaluation_report(const EvaluationOptions& options) {
    fits_named(options.fit);
    require_one_of("order", options.order, {"auto", "sequence", "set"});
    require_one_of("split", options.split, {"", "all", "train", "test"});
    Evaluation evaluation(options);
    evaluation.measure();
    ordered_json report = evaluation.report();
    if (!options.output.empty()) evaluation.write_files(report);
    return report;
}

}  // namespace mscomp
