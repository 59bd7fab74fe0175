// SPDX-License-Identifier: MIT
#include "truth_report.h"

#include <algorithm>
#include <array>
#include <utility>

#include "mscomp/acap/extract.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

using nlohmann::ordered_json;

constexpr std::array kScaleNames{"coarse", "fine"};

/// Changes of features (V,9) that components make, one after the other: of a model of positions
/// those of the shapes that its components make of the reference.
class FeatureChanges {
  public:
    FeatureChanges(const TrainedRun& run, const std::vector<Component>& components) {
        if (run.model->rows() == ShapeRows::features) {
            for (const Component& c : components) changes_.emplace_back(c.difference);
            return;
        }
        if (components.empty()) return;
        extract(run, components);
        const std::size_t row = at(run.reference().vertex_count()) * kFeatureDim;
        for (std::size_t k = 0; k < components.size(); ++k) {
            changes_.emplace_back(std::span(extracted_).subspan(k * row, row));
        }
    }
    std::span<const std::span<const float>> all() const { return changes_; }

  private:
    void extract(const TrainedRun& run, const std::vector<Component>& components) {
        MeshSequence shapes;
        shapes.faces = run.reference().faces;
        for (const Component& c : components) {
            shapes.names.push_back(c.id);
            std::vector<Point>& shape = shapes.shapes.emplace_back(run.reference().vertices);
            for (std::size_t i = 0; i < c.difference.size(); ++i) {
                shape[i / 3][i % 3] += static_cast<double>(c.difference[i]);
            }
        }
        const ExtractOptions options{parse_edge_weights(run.context().weights), false,
                                     VertexPlaces{}};
        extracted_ = extract_features(shapes, run.reference().vertices, options).features;
        for (std::size_t i = 0; i < extracted_.size(); ++i) {
            extracted_[i] -= kReferenceFeature[i % kFeatureDim];
        }
    }

    std::vector<float> extracted_;
    std::vector<std::span<const float>> changes_;
};

SupportMatches overlaps_of(const std::string& path, const TrueComponents& truth,
                           const TrainedRun& run, const std::vector<Component>& components) {
    const ModelContext& context = run.context();
    const int vertices = context.mesh().vertex_count();
    const std::vector<float> of_files = read_true_supports(path, truth.names, vertices);
    std::vector<float> supports;
    for (int u = 0; u < truth.count(); ++u) {
        const std::vector<float> row = context.places.of_places(
            std::span(of_files).subspan(at(u) * at(vertices), at(vertices)));
        supports.insert(supports.end(), row.begin(), row.end());
    }
    return support_matches(FeatureChanges(run, components).all(), supports,
                           context.reference.vertex_count());
}

ordered_json mean_of(double sum, std::size_t count) {
    return count == 0 ? ordered_json(nullptr) : ordered_json(sum / static_cast<double>(count));
}

}  // namespace

TruthReport::TruthReport(const std::string& path, const FeatureFile& file, const TrainedRun& run,
                         const std::vector<Component>& components)
    : path_(path),
      truth_(read_true_components(path)),
      weights_(truth_.names, weights_of_shapes(truth_, path, file.outline().names, file.path())),
      components_(components),
      level_count_(static_cast<int>(run.model->levels().size())),
      overlaps_(overlaps_of(true_supports_path(path), truth_, run, components)) {}

ordered_json TruthReport::component_json(int truth, int component) const {
    if (component < 0) {
        return {{"component", nullptr}, {"level", nullptr}, {"iou", 0.0}, {"soft_iou", 0.0}};
    }
    const SupportOverlap& overlap = overlaps_.at(component, truth);
    return {{"component", components_[at(component)].id},
            {"level", components_[at(component)].level},
            {"iou", overlap.iou},
            {"soft_iou", overlap.soft_iou}};
}

ordered_json TruthReport::scale_json(int scale, std::span<const Found> found,
                                     bool has_correlations) const {
    std::size_t count = 0;
    double iou = 0, soft = 0, correlation = 0;
    int matched = 0, at_scale = 0;
    std::vector<int> per_level(at(level_count_), 0);
    for (std::size_t u = 0; u < found.size(); ++u) {
        if (truth_.scales[u] != scale) continue;
        ++count;
        if (found[u].component < 0) continue;
        const SupportOverlap& overlap = overlaps_.at(found[u].component, static_cast<int>(u));
        iou += overlap.iou;
        soft += overlap.soft_iou;
        correlation += found[u].correlation;
        matched += found[u].correlation >= KnownUnits::kThreshold ? 1 : 0;
        const int level = components_[at(found[u].component)].level;
        ++per_level[at(level)];
        at_scale += (2 * level < level_count_ ? 0 : 1) == scale ? 1 : 0;
    }
    ordered_json result{
        {"components", count}, {"iou", mean_of(iou, count)}, {"soft_iou", mean_of(soft, count)}};
    if (has_correlations) {
        result["correlation"] = mean_of(correlation, count);
        result["matched_one_to_one"] = matched;
    }
    result["per_level"] = per_level;
    // One level says nothing about scale.
    result["at_scale"] = level_count_ > 1 ? ordered_json(at_scale) : ordered_json(nullptr);
    return result;
}

ordered_json TruthReport::by_overlap(std::span<const int> shapes) const {
    std::vector<Found> found;
    ordered_json list = ordered_json::array();
    for (int u = 0; u < truth_.count(); ++u) {
        found.push_back({overlaps_.one_to_one[at(u)]});
        ordered_json entry{{"unit", truth_.names[at(u)]},
                           {"scale", kScaleNames.at(at(truth_.scales[at(u)]))}};
        entry.update(component_json(u, found.back().component));
        list.push_back(entry);
    }
    ordered_json overlap = ordered_json::object();
    for (std::size_t scale = 0; scale < kScaleNames.size(); ++scale) {
        overlap[kScaleNames[scale]] = scale_json(static_cast<int>(scale), found, false);
    }
    overlap["list"] = list;
    return {{"file", path_},
            {"components", truth_.count()},
            {"varying", weights_.varying_count(shapes)},
            {"threshold", KnownUnits::kThreshold},
            {"support_threshold", kSupportThreshold},
            {"by_overlap", overlap}};
}

ordered_json TruthReport::by_correlation(std::span<const int> shapes,
                                         std::span<const double> codes) const {
    const UnitMatches matches = weights_.correlations(shapes, codes);
    ordered_json result = weights_.matches(matches, components_);
    std::vector<Found> found;
    for (std::size_t u = 0; u < matches.best.size(); ++u) {
        const int truth = static_cast<int>(u);
        ordered_json& entry = result["list"][u];
        entry["scale"] = kScaleNames.at(at(truth_.scales[u]));
        entry["best"].update(component_json(truth, matches.best[u].code));
        entry["one_to_one"].update(component_json(truth, matches.one_to_one[u].code));
        const int overlapping = overlaps_.one_to_one[u];
        ordered_json by_overlap = component_json(truth, overlapping);
        const double correlation = overlapping < 0 ? 0.0 : matches.at(overlapping, truth);
        by_overlap["correlation"] = correlation;
        entry["by_overlap"] = by_overlap;
        found.push_back({matches.one_to_one[u].code, matches.one_to_one[u].correlation});
    }
    for (std::size_t scale = 0; scale < kScaleNames.size(); ++scale) {
        result[kScaleNames[scale]] = scale_json(static_cast<int>(scale), found, true);
    }
    return result;
}

}  // namespace mscomp
