// SPDX-License-Identifier: MIT
#include "mscomp/nn/components.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace mscomp::nn {
namespace {

std::size_t at(std::int64_t index) { return static_cast<std::size_t>(index); }

double row_norm(std::span<const float> rows, std::int64_t vertex) {
    double sum = 0;
    for (std::int64_t c = 0; c < kFeatureDim; ++c) {
        const double x = rows[at(vertex * kFeatureDim + c)];
        sum += x * x;
    }
    return std::sqrt(sum);
}

/// Unscaled features at `code` minus those at `base`.
std::vector<float> unscaled_difference(StackedModel<float>& model, const Component& component,
                                       std::vector<float> code, const std::vector<float>& base,
                                       const std::array<double, kFeatureDim>& factor) {
    const std::vector<float> from = model.decode(component.level, component.autoencoder, base);
    std::vector<float> difference = model.decode(component.level, component.autoencoder, code);
    for (std::size_t i = 0; i < difference.size(); ++i) {
        const double f = factor[i % kFeatureDim];
        difference[i] =
            f != 0 ? static_cast<float>(
                         (static_cast<double>(difference[i]) - static_cast<double>(from[i])) / f)
                   : 0.0F;
    }
    return difference;
}

double total_norm(const std::vector<float>& difference) {
    double sum = 0;
    for (const float x : difference) sum += static_cast<double>(x) * static_cast<double>(x);
    return sum;
}

/// [A] eq. 7 and the filter.
void judge(Component& component, const FilterConfig& filter, DistanceRows& distances) {
    const auto vertices = static_cast<std::int64_t>(component.difference.size()) / kFeatureDim;
    double peak = 0;
    for (std::int64_t v = 0; v < vertices; ++v) {
        peak = std::max(peak, row_norm(component.difference, v));
    }
    const double threshold = filter.absolute_threshold > 0 ? filter.absolute_threshold
                                                           : filter.relative_threshold * peak;
    const std::span<const double> distance = distances.row(component.center);
    double sum = 0;
    std::int64_t acting = 0;
    for (std::int64_t v = 0; v < vertices; ++v) {
        const double size = row_norm(component.difference, v);
        if (size > 0) ++component.moving;
        if (!(size > threshold)) continue;
        sum += size;
        ++acting;
        component.localization_radius = std::max(component.localization_radius, distance[at(v)]);
    }
    component.strength = acting > 0 ? sum / static_cast<double>(acting) : 0;
    component.kept = component.strength >= filter.minimum_strength;
    if (!component.kept) {
        component.reason = component.support == 0
                               ? "no vertex is left in its support"
                               : fmt::format("strength {:.3g} is below {:.3g}", component.strength,
                                             filter.minimum_strength);
    }
}

/// Id of the component that autoencoder `a` of `level` refines; empty at level 0.
std::string parent_id(const StackedModel<float>& model, int level, int a) {
    if (level == 0 || !model.config().attention) return {};
    const int components = model.levels()[at(level - 1)].components;
    const std::string above = parent_id(model, level - 1, a / components);
    return above.empty() ? fmt::format("{}", a % components)
                         : fmt::format("{}.{}", above, a % components);
}

/// Without attention a level refines the whole, so its ids start with what level it is.
std::string component_id(const Component& component, bool attention) {
    if (component.level == 0) return fmt::format("{}", component.index);
    if (!attention) return fmt::format("L{}.{}", component.level, component.index);
    return fmt::format("{}.{}", component.parent, component.index);
}

}  // namespace

std::vector<Component> extract_components(StackedModel<float>& model,
                                          const std::vector<std::vector<float>>& codes,
                                          std::span<const float> reference,
                                          const std::array<double, kFeatureDim>& factor,
                                          const FilterConfig& filter, DistanceRows& distances) {
    const std::array<int, 1> first{0};
    model.load_batch(reference, std::span<const int>(first));
    model.forward();
    std::vector<Component> components;
    for (int l = 0; l < static_cast<int>(model.levels().size()); ++l) {
        const auto& level = model.levels()[at(l)];
        const std::vector<float> reference_codes = model.codes(l);
        const std::vector<float> weights = model.to_user_order(
            level.weights, std::as_const(model).parameters().value(level.weights));
        const int rows = level.autoencoders * level.components;
        const std::vector<int> centers = model.centers(l);
        distances.prepare(centers);
        for (int row = 0; row < rows; ++row) {
            Component c;
            c.level = l;
            c.autoencoder = row / level.components;
            c.index = row % level.components;
            c.parent = parent_id(model, l, c.autoencoder);
            c.id = component_id(c, model.config().attention);
            c.center = centers[at(row)];
            double largest = 0;
            for (int v = 0; v < model.vertex_count(); ++v) {
                const double length =
                    row_norm(weights, std::int64_t{row} * model.vertex_count() + v);
                if (length > 0) ++c.support;
                if (length > largest) {
                    largest = length;
                    c.longest = v;
                }
            }
            const std::vector<float> base(
                reference_codes.begin() + c.autoencoder * level.components,
                reference_codes.begin() + (c.autoencoder + 1) * level.components);
            c.code_reference = base[at(c.index)];
            c.code_min = c.code_max = c.code_reference;
            for (std::size_t m = at(row); m < codes[at(l)].size(); m += at(rows)) {
                c.code_min = std::min(c.code_min, static_cast<double>(codes[at(l)][m]));
                c.code_max = std::max(c.code_max, static_cast<double>(codes[at(l)][m]));
            }
            for (const double end : {c.code_min, c.code_max}) {
                std::vector<float> code = base;
                code[at(c.index)] = static_cast<float>(end);
                std::vector<float> difference =
                    unscaled_difference(model, c, std::move(code), base, factor);
                if (c.difference.empty() || total_norm(difference) > total_norm(c.difference)) {
                    c.difference = std::move(difference);
                    c.code_end = end;
                }
            }
            judge(c, filter, distances);
            components.push_back(std::move(c));
        }
    }
    return components;
}

double mean_support(const std::vector<Component>& components, int level, int vertex_count) {
    double sum = 0;
    int count = 0;
    for (const Component& c : components) {
        if (c.level != level) continue;
        sum += static_cast<double>(c.support) / vertex_count;
        ++count;
    }
    return count > 0 ? sum / count : 0;
}

}  // namespace mscomp::nn
