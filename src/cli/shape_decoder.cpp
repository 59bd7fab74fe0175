// SPDX-License-Identifier: MIT
#include "shape_decoder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"
#include "mscomp/eval/measures.h"

namespace mscomp {
namespace {

/// Standard deviation of every code over the training shapes, all levels one after the other.
std::vector<float> code_deviations(const TrainedRun& run) {
    std::vector<float> result;
    const std::size_t shapes = run.context().train_shapes.size();
    for (const std::vector<float>& codes : run.file.codes()) {
        const std::size_t width = shapes > 0 ? codes.size() / shapes : 0;
        for (std::size_t k = 0; k < width; ++k) {
            double sum = 0, squares = 0;
            for (std::size_t m = 0; m < shapes; ++m) sum += codes[m * width + k];
            const double mean = sum / static_cast<double>(shapes);
            for (std::size_t m = 0; m < shapes; ++m) {
                const double away = static_cast<double>(codes[m * width + k]) - mean;
                squares += away * away;
            }
            result.push_back(static_cast<float>(std::sqrt(squares / static_cast<double>(shapes))));
        }
    }
    return result;
}

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
    : run_(run),
      file_(file),
      check_stop_(std::move(check_stop)),
      scaler_(run.scaler()),
      lossless_(run.context().reference, parse_edge_weights(run.context().weights)),
      decoder_(run.model->decoder()) {
    minmax_.offset = run.context().minmax_offset;
    minmax_.factor = run.context().minmax_factor;
}

std::vector<Point> ShapeDecoder::solved(int shape, const std::vector<float>& features) const {
    check_stop_();
    return lossless_.solve(features, truth(shape)).vertices;
}

std::vector<DecodedShape> ShapeDecoder::encode(std::span<const int> shapes, int levels) {
    run_.model->load_batch(nn::ScaledFeatures{file_, scaler_.offset, scaler_.factor}, shapes);
    run_.model->forward();
    const int count = static_cast<int>(run_.model->level_sizes().size());
    std::vector<float> decoded = run_.model->reconstruction(levels == 0 ? count : levels);
    scaler_.unscale(decoded);
    std::vector<DecodedShape> result(shapes.size());
    for (int l = 0; l < count; ++l) {
        const std::vector<float> codes = run_.model->codes(l);
        const std::size_t width = codes.size() / shapes.size();
        for (std::size_t m = 0; m < shapes.size(); ++m) {
            const auto row = codes.begin() + static_cast<std::ptrdiff_t>(m * width);
            result[m].codes.insert(result[m].codes.end(), row,
                                   row + static_cast<std::ptrdiff_t>(width));
        }
    }
    const std::size_t size = decoded.size() / shapes.size();
    parallel_for(static_cast<std::int64_t>(shapes.size()), [&](std::int64_t m) {
        const auto row = decoded.begin() + static_cast<std::ptrdiff_t>(at(m) * size);
        result[at(m)].features.assign(row, row + static_cast<std::ptrdiff_t>(size));
        result[at(m)].vertices = solved(shapes[at(m)], result[at(m)].features);
    });
    return result;
}

std::vector<DecodedShape> ShapeDecoder::decode(std::span<const int> shapes,
                                               std::vector<std::vector<float>> codes) const {
    std::vector<DecodedShape> result(shapes.size());
    parallel_for(static_cast<std::int64_t>(shapes.size()), [&](std::int64_t m) {
        DecodedShape& decoded = result[at(m)];
        decoded.codes = std::move(codes[at(m)]);
        decoded.features = decoder_->decode(decoded.codes);
        scaler_.unscale(decoded.features);
        decoded.vertices = solved(shapes[at(m)], decoded.features);
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
        result[m].features = decoder_->decode(fitted.codes);
        scaler_.unscale(result[m].features);
        result[m].codes = std::move(fitted.codes);
        result[m].vertices = std::move(fitted.vertices);
    };
    parallel_for(static_cast<std::int64_t>(shapes.size()), [&](std::int64_t m) {
        check_stop_();
        const std::vector<Point> goal = truth(shapes[at(m)]);
        take(at(m), poisson.fit(goal, starts[at(m)].codes, subset));
        if (!knows_all) return;
        RmsError error(run_.context().reference.vertices);
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

std::vector<Point> ShapeDecoder::positions(std::span<const float> codes) {
    return made(poisson_fit_, {}).positions(codes);
}

const VertexFit& ShapeDecoder::made(std::unique_ptr<VertexFit>& fit, VertexFitOptions options) {
    if (!fit) {
        options.code_deviations = code_deviations(run_);
        fit = std::make_unique<VertexFit>(*decoder_, scaler_, run_.context().reference,
                                          parse_edge_weights(run_.context().weights), options);
    }
    return *fit;
}

std::optional<double> ShapeDecoder::relative_squared_error_of(int shape,
                                                              const DecodedShape& decoded) const {
    const std::span<const float> features = file_.shape(shape);
    if (is_reference(features)) return std::nullopt;
    std::vector<float> truth(features.begin(), features.end());
    std::vector<float> result = decoded.features;
    minmax_.scale(truth);
    minmax_.scale(result);
    return relative_squared_error(truth, result);
}

void require_mesh_of(const TrainedRun& run, const FeatureFile& file) {
    const TriangleMesh& reference = run.context().reference;
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
