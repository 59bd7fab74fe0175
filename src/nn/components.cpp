// SPDX-License-Identifier: MIT
#include "mscomp/nn/components.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <utility>

#include "mscomp/base/index.h"

namespace mscomp::nn {
namespace {

double row_norm(std::span<const float> rows, std::int64_t vertex) {
    double sum = 0;
    for (std::int64_t c = 0; c < kFeatureDim; ++c) {
        const double x = rows[at(vertex * kFeatureDim + c)];
        sum += x * x;
    }
    return std::sqrt(sum);
}

double total_norm(const std::vector<float>& difference) {
    double sum = 0;
    for (const float x : difference) sum += static_cast<double>(x) * static_cast<double>(x);
    return std::sqrt(sum);
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
std::string parent_id(const Model<float>& model, const std::vector<LevelSize>& levels, int level,
                      int a) {
    if (level == 0 || !model.refines_components()) return {};
    const int components = levels[at(level - 1)].components;
    const std::string above = parent_id(model, levels, level - 1, a / components);
    return above.empty() ? fmt::format("{}", a % components)
                         : fmt::format("{}.{}", above, a % components);
}

/// Without attention a level refines the whole, so its ids start with what level it is.
std::string component_id(const Component& component, bool refines) {
    if (component.level == 0) return fmt::format("{}", component.index);
    if (!refines) return fmt::format("L{}.{}", component.level, component.index);
    return fmt::format("{}.{}", component.parent, component.index);
}

/// Where the component weights (V,d) of a component are.
void find_support(Component& component, std::span<const float> weights, int vertices) {
    const std::size_t width = weights.size() / at(vertices);
    double largest = 0;
    for (int v = 0; v < vertices; ++v) {
        double square = 0;
        for (const float x : weights.subspan(at(v) * width, width)) {
            square += static_cast<double>(x) * static_cast<double>(x);
        }
        if (square > 0) ++component.support;
        if (square > largest) {
            largest = square;
            component.longest = v;
        }
    }
}

/// The codes that entry `index` takes over the rows of `codes` (n,width) and the reference.
void find_ends(Component& component, std::span<const float> codes, std::size_t index,
               std::size_t width) {
    component.code_min = component.code_max = component.code_reference;
    for (std::size_t m = index; m < codes.size(); m += width) {
        component.code_min = std::min(component.code_min, static_cast<double>(codes[m]));
        component.code_max = std::max(component.code_max, static_cast<double>(codes[m]));
    }
}

/// Decodes both ends of code `index`; the one that moves the shape more becomes the end.
void decode_ends(Component& component, const CodeDecoder& decoder, std::vector<float> codes,
                 std::size_t index, const std::vector<float>& base,
                 const std::array<double, kFeatureDim>& factor) {
    const auto at_code = [&](double code) {
        codes[index] = static_cast<float>(code);
        return feature_change(decoder, codes, base, factor);
    };
    component.code_end = component.code_min;
    component.code_other = component.code_max;
    component.difference = at_code(component.code_min);
    component.other_difference = at_code(component.code_max);
    if (total_norm(component.other_difference) > total_norm(component.difference)) {
        std::swap(component.code_end, component.code_other);
        std::swap(component.difference, component.other_difference);
    }
    component.distance = total_norm(component.difference);
}

}  // namespace

std::vector<float> feature_change(const CodeDecoder& decoder, std::span<const float> codes,
                                  std::span<const float> base,
                                  const std::array<double, kFeatureDim>& factor) {
    std::vector<float> difference = decoder.decode(codes);
    for (std::size_t i = 0; i < difference.size(); ++i) {
        const double f = factor[i % kFeatureDim];
        const double change = static_cast<double>(difference[i]) - static_cast<double>(base[i]);
        difference[i] = f != 0 ? static_cast<float>(change / f) : 0.0F;
    }
    return difference;
}

std::vector<int> strongest_first(const std::vector<Component>& components) {
    std::vector<int> order(components.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, [&](int a, int b) {
        const Component &x = components[at(a)], &y = components[at(b)];
        return x.level != y.level ? x.level < y.level : x.distance > y.distance;
    });
    return order;
}

std::vector<Component> extract_components(Model<float>& model,
                                          const std::vector<std::vector<float>>& codes,
                                          std::span<const float> reference,
                                          const std::array<double, kFeatureDim>& factor,
                                          const FilterConfig& filter, DistanceRows& distances) {
    const std::array<int, 1> first{0};
    model.load_batch(reference, std::span<const int>(first));
    model.forward();
    const std::vector<LevelSize> levels = model.level_sizes();
    std::vector<float> reference_codes;
    for (int l = 0; l < static_cast<int>(levels.size()); ++l) {
        const std::vector<float> of_level = model.codes(l);
        reference_codes.insert(reference_codes.end(), of_level.begin(), of_level.end());
    }
    const std::unique_ptr<CodeDecoder> decoder = model.decoder();
    const std::vector<float> base = decoder->decode(reference_codes);

    std::vector<Component> components;
    for (int l = 0; l < static_cast<int>(levels.size()); ++l) {
        const LevelSize level = levels[at(l)];
        const int entry = model.component_weights(l);
        const std::vector<float> weights =
            model.to_user_order(entry, std::as_const(model).parameters().value(entry));
        const std::size_t size = weights.size() / at(level.codes());
        const std::vector<int> centers = model.centers(l);
        distances.prepare(centers);
        for (int row = 0; row < level.codes(); ++row) {
            const std::size_t code = components.size();
            Component c;
            c.level = l;
            c.code = static_cast<int>(code);
            c.autoencoder = row / level.components;
            c.index = row % level.components;
            c.parent = parent_id(model, levels, l, c.autoencoder);
            c.id = component_id(c, model.refines_components());
            c.center = centers[at(row)];
            find_support(c, std::span(weights).subspan(at(row) * size, size), model.vertex_count());
            c.code_reference = reference_codes[code];
            find_ends(c, codes[at(l)], at(row), at(level.codes()));
            decode_ends(c, *decoder, reference_codes, code, base, factor);
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
