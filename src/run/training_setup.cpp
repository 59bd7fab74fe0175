// SPDX-License-Identifier: MIT
#include "training_setup.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "make_model.h"
#include "mscomp/acap/area_metric.h"
#include "mscomp/acap/shape_outliers.h"
#include "mscomp/base/error.h"
#include "mscomp/base/parallel.h"
#include "mscomp/config/config_file.h"
#include "mscomp/geodesic/heat_geodesics.h"
#include "mscomp/run/split.h"

namespace mscomp {

namespace {

/// The context of a model of these features as far as they say.
ModelContext context_of(const FeatureFile& features) {
    const PlacedFeatures& outline = features.outline();
    ModelContext context;
    context.source = features.path();
    context.source_hash = features.data_hash();
    context.weights = outline.weights;
    context.places = outline.places;
    context.reference = outline.places.surface(outline.reference);
    if (!outline.places.are_all_vertices()) context.reference_of_files = outline.reference;
    return context;
}

/// What is odd about whole shapes of a set; files of other programs went through no other hands.
std::vector<std::string> odd_shapes(const SurfaceShapes& shapes, const ModelContext& context,
                                    const std::vector<std::string>& names) {
    ShapeOutliers outliers(context.reference, shapes.shape_count());
    parallel_for(shapes.shape_count(), [&](std::int64_t n) {
        const auto index = static_cast<int>(n);
        outliers.look_at(index, points_of(shapes.vertices(index)), shapes.shape(index));
        shapes.forget(index);
    });
    return outliers.warnings(names);
}

FeatureScale feature_scale(Scale scale) {
    switch (scale) {
        case Scale::separate:
            return FeatureScale::separate;
        case Scale::robust:
            return FeatureScale::robust;
        default:
            return FeatureScale::shared;
    }
}

}  // namespace

TrainingSetup::TrainingSetup(const Config& of)
    : config(of),
      features(of.data.features),
      context(context_of(features)),
      shapes(features, context.places) {
    const FeatureSet& outline = features.outline();
    Split split = resolve_split(config.data.split, outline.shape_count(), "");
    if (split.train.empty()) throw UsageError("data.split leaves no shape to train on");
    warnings = odd_shapes(shapes, context, outline.names);
    std::vector<float> roots;
    if (config.data.metric == FeatureMetric::area) roots = area_metric(context.reference);
    const FeatureRanges ranges(shapes, split.train, std::move(roots));
    scaler = ranges.scaler(
        config.data.center == Scaling::minmax ? FeatureCenter::minmax : FeatureCenter::reference,
        feature_scale(config.data.scale));
    if (std::ranges::all_of(scaler.factor, [](double f) { return f == 0; })) {
        throw UsageError(fmt::format("{}: the training shapes do not differ from the reference",
                                     config.data.features));
    }

    HeatGeodesics geodesics(context.reference);
    const GeodesicNormalizer normalizer = geodesic_normalizer(geodesics);
    distances =
        std::make_unique<NormalizedGeodesics>(std::move(geodesics), normalizer.largest_distance);
    context.config = write_config(config, false);
    context.scale = scaler;
    context.minmax = ranges.scaler(FeatureCenter::minmax);
    context.largest_distance = normalizer.largest_distance;
    context.largest_distance_exact = normalizer.exact;
    context.train_shapes = std::move(split.train);
    context.test_shapes = std::move(split.test);
    model = make_model(config, context, *distances, ModelUse::training,
                       static_cast<int>(context.train_shapes.size()));
}

}  // namespace mscomp
