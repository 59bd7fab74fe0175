// SPDX-License-Identifier: MIT
#include "mscomp/run/shape_decoder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "mscomp/acap/alignment.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"
#include "mscomp/edit/feature_fit.h"
#include "mscomp/eval/measures.h"
#include "mscomp/model/code_statistics.h"

namespace mscomp {
namespace {

/// Few vertices leave more to the start, and the way from there is longer.
VertexFitOptions handle_options() {
    VertexFitOptions options;
    options.prior = 1e-2;
    options.max_steps = 40;
    return options;
}

bool is_reference(std::span<const float> features) {
    for (std::size_t i = 0; i < features.size(); ++i) {
        if (!(std::abs(features[i] - kReferenceFeature[i % kFeatureDim]) < 1e-6F)) return false;
    }
    return true;
}

}  // namespace

ShapeDecoder::ShapeDecoder(TrainedRun& run, const FeatureFile& file,
                           std::function<void()> check_stop)
    : ShapeDecoder(run, *run.model, run.file.codes(), file, std::move(check_stop)) {}

ShapeDecoder::ShapeDecoder(TrainedRun& run, ShapeModel& model, CodeTable codes,
                           const FeatureFile& file, std::function<void()> check_stop)
    : run_(run),
      model_(model),
      training_codes_(std::move(codes)),
      file_(file),
      shapes_(file, run.context().places),
      check_stop_(check_stop ? std::move(check_stop) : [] {}),
      lossless_(model, run.reference(), parse_edge_weights(run.context().weights),
                VertexSolver::lossless) {}

std::vector<DecodedShape> ShapeDecoder::encode(std::span<const int> shapes, int levels) {
    const CodeTable table = model_.encode(shapes_, shapes);
    std::vector<std::vector<float>> codes;
    for (int m = 0; m < table.shape_count(); ++m) {
        codes.emplace_back(table.shape(m).begin(), table.shape(m).end());
    }
    return decode(shapes, std::move(codes), levels);
}

std::vector<DecodedShape> ShapeDecoder::decode(std::span<const int> shapes,
                                               std::vector<std::vector<float>> codes,
                                               int levels) const {
    std::vector<DecodedShape> result(shapes.size());
    parallel_for(static_cast<std::int64_t>(shapes.size()), [&](std::int64_t m) {
        check_stop_();
        DecodedShape& decoded = result[at(m)];
        decoded.codes = std::move(codes[at(m)]);
        decoded.rows = lossless_.rows(decoded.codes, levels);
        decoded.vertices = lossless_.positions(decoded.rows, truth(shapes[at(m)]));
    });
    return result;
}

std::vector<DecodedShape> ShapeDecoder::fit(std::span<const int> shapes,
                                            std::span<const DecodedShape> starts,
                                            const FitSubset& subset) {
    const bool knows_all = subset.vertices.empty();
    const VertexFit& poisson =
        knows_all ? made(poisson_fit_, {}) : made(handle_fit_, handle_options());
    std::vector<DecodedShape> result(shapes.size());
    std::vector<char> is_farther(shapes.size(), 0);
    const auto take = [&](std::size_t m, FittedShape fitted) {
        result[m].rows = lossless_.rows(fitted.codes);
        result[m].codes = std::move(fitted.codes);
        result[m].vertices = std::move(fitted.vertices);
    };
    parallel_for(static_cast<std::int64_t>(shapes.size()), [&](std::int64_t m) {
        check_stop_();
        const std::vector<Point> goal = truth(shapes[at(m)]);
        take(at(m), poisson.fit(goal, starts[at(m)].codes, subset));
        if (!knows_all) return;
        RmsError error(run_.reference().vertices);
        const double start = error.add(goal, starts[at(m)].vertices);
        is_farther[at(m)] = error.add(goal, result[at(m)].vertices) <= start ? 0 : 1;
    });
    if (std::ranges::none_of(is_farther, [](char x) { return x != 0; })) return result;
    VertexFitOptions exactly;
    exactly.solver = VertexSolver::lossless;
    const VertexFit& lossless = made(lossless_fit_, exactly);
    parallel_for(static_cast<std::int64_t>(shapes.size()), [&](std::int64_t m) {
        if (is_farther[at(m)] == 0) return;
        check_stop_();
        take(at(m), lossless.fit(truth(shapes[at(m)]), starts[at(m)].codes, subset));
    });
    return result;
}

std::vector<DecodedShape> ShapeDecoder::fit_features(std::span<const int> shapes,
                                                     std::span<const DecodedShape> starts,
                                                     std::span<const int> moving) const {
    FeatureFitOptions options;
    options.scale = run_.context().scale;
    const FeatureFit features(model_, options);
    std::vector<std::vector<float>> codes(shapes.size());
    parallel_for(static_cast<std::int64_t>(shapes.size()), [&](std::int64_t m) {
        check_stop_();
        codes[at(m)] =
            features.fit(shapes_.shape(shapes[at(m)]), starts[at(m)].codes, moving).codes;
    });
    return decode(shapes, std::move(codes));
}

std::vector<Point> ShapeDecoder::positions(std::span<const float> codes) {
    return made(poisson_fit_, {}).positions(codes);
}

const VertexFit& ShapeDecoder::made(std::unique_ptr<VertexFit>& fit, VertexFitOptions options) {
    if (!fit) {
        options.code_deviations = code_deviations(training_codes_);
        fit = std::make_unique<VertexFit>(model_, run_.reference(),
                                          parse_edge_weights(run_.context().weights), options);
    }
    return *fit;
}

std::vector<Point> ShapeDecoder::truth_in_place(int shape) const {
    const FeatureSet& set = file_.outline();
    // aligned = rotation * input + translation
    RigidMotion back;
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> rotation(
        set.rotation[at(shape)].data());
    back.rotation = rotation.transpose();
    back.translation =
        -(back.rotation * Eigen::Map<const Eigen::Vector3d>(set.translation[at(shape)].data()));
    return moved(truth(shape), back);
}

std::optional<double> ShapeDecoder::relative_squared_error_of(int shape,
                                                              const DecodedShape& decoded) const {
    return relative_squared_error_of(shape, decoded.rows);
}

std::optional<double> ShapeDecoder::relative_squared_error_of_reference(int shape) const {
    std::vector<float> rows;
    for (int v = 0; v < run_.reference().vertex_count(); ++v) {
        rows.insert(rows.end(), kReferenceFeature.begin(), kReferenceFeature.end());
    }
    return relative_squared_error_of(shape, std::move(rows));
}

std::optional<double> ShapeDecoder::relative_squared_error_of(int shape,
                                                              std::vector<float> result) const {
    if (model_.rows() != ShapeRows::features) return std::nullopt;
    const std::span<const float> features = shapes_.shape(shape);
    if (is_reference(features)) return std::nullopt;
    const MetricScale& minmax = run_.context().minmax;
    std::vector<float> truth(features.begin(), features.end());
    minmax.scale(truth);
    minmax.scale(result);
    return relative_squared_error(truth, result);
}

void require_mesh_of(const TrainedRun& run, const FeatureFile& file) {
    const TriangleMesh& reference = run.context().mesh();
    const FeatureSet& set = file.outline();
    if (set.vertex_count() != reference.vertex_count()) {
        throw InputError({file.path()}, fmt::format("{} vertices, but the model was trained on {}",
                                                    set.vertex_count(), reference.vertex_count()));
    }
    if (set.reference.faces != reference.faces) {
        throw InputError({file.path()}, "other faces than the model was trained on");
    }
}

std::vector<int> shapes_of_split(const TrainedRun& run, const FeatureFile& file,
                                 const std::string& split) {
    std::vector<int> shapes;
    if (split == "all") {
        shapes.resize(at(file.shape_count()));
        std::iota(shapes.begin(), shapes.end(), 0);
        return shapes;
    }
    shapes = split == "train" ? run.context().train_shapes : run.context().test_shapes;
    if (shapes.empty()) throw UsageError(fmt::format("--split {}: has no shapes", split));
    if (shapes.back() >= file.shape_count()) {
        throw InputError({file.path()}, fmt::format("{} shapes, but --split {} names shape {}",
                                                    file.shape_count(), split, shapes.back()));
    }
    return shapes;
}

}  // namespace mscomp
