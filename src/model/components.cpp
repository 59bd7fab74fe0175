// SPDX-License-Identifier: MIT
#include "mscomp/model/components.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numeric>
#include <utility>

#include "model/component_filter.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

double row_norm(std::span<const float> row) {
    double sum = 0;
    for (const float x : row) sum += static_cast<double>(x) * static_cast<double>(x);
    return std::sqrt(sum);
}

/// Length of every row, in the unit of the model.
std::vector<double> sizes_of(const std::vector<float>& rows, const ShapeModel& model) {
    const auto width = at(row_width(model.rows()));
    std::vector<double> sizes;
    sizes.reserve(rows.size() / width);
    for (std::size_t first = 0; first < rows.size(); first += width) {
        sizes.push_back(row_norm(std::span(rows).subspan(first, width)) / model.unit());
    }
    return sizes;
}

/// [A] eq. 7, and where the component acts.
void measure(Component& component, const ShapeModel& model, const FilterConfig& filter,
             DistanceRows& distances) {
    const std::vector<double> sizes = sizes_of(component.difference, model);
    const double peak = std::max(0.0, *std::ranges::max_element(sizes));
    component.moving = 0;
    component.localization_radius = 0;
    const double threshold = filter.absolute_threshold > 0 ? filter.absolute_threshold
                                                           : filter.relative_threshold * peak;
    const std::span<const double> distance = distances.row(component.center);
    double sum = 0;
    int acting = 0;
    for (std::size_t v = 0; v < sizes.size(); ++v) {
        if (sizes[v] > 0) ++component.moving;
        if (!(sizes[v] > threshold)) continue;
        sum += sizes[v];
        ++acting;
        component.localization_radius = std::max(component.localization_radius, distance[v]);
    }
    component.strength = acting > 0 ? sum / acting : 0;
}

/// What has no parent on a finer level starts with what level it is.
std::string component_id(const Component& component) {
    if (component.level == 0) return fmt::format("{}", component.index);
    if (component.parent.empty()) return fmt::format("L{}.{}", component.level, component.index);
    return fmt::format("{}.{}", component.parent, component.index);
}

/// The codes that the component takes over the rows of `codes` and the reference.
void find_ends(Component& component, const CodeTable& codes) {
    component.code_min = component.code_max = component.code_reference;
    for (int m = 0; m < codes.shape_count(); ++m) {
        const auto code = static_cast<double>(codes.shape(m)[at(component.code)]);
        component.code_min = std::min(component.code_min, code);
        component.code_max = std::max(component.code_max, code);
    }
}

/// Decodes both ends of the component; the one that moves the shape more becomes the end.
void decode_ends(Component& component, const ShapeModel& model,
                 const std::vector<float>& reference) {
    const auto change_at = [&](double code) {
        std::vector<float> codes = reference;
        put_at(codes, component, static_cast<float>(code));
        return model.change(codes, reference);
    };
    component.code_end = component.code_min;
    component.code_other = component.code_max;
    component.difference = change_at(component.code_min);
    component.other_difference = change_at(component.code_max);
    if (row_norm(component.other_difference) > row_norm(component.difference)) {
        std::swap(component.code_end, component.code_other);
        std::swap(component.difference, component.other_difference);
    }
    component.distance = row_norm(component.difference) / model.unit();
}

/// Ids and numbers of all components, in the order of their codes.
std::vector<Component> numbered_components(const ShapeModel& model) {
    const std::vector<LevelSize> levels = model.levels();
    const std::vector<int> parents = model.parents();
    std::vector<Component> components;
    std::map<std::pair<int, int>, int> siblings;  // by level and parent
    for (int l = 0; l < static_cast<int>(levels.size()); ++l) {
        for (int row = 0; row < levels[at(l)].codes(); ++row) {
            Component c;
            c.level = l;
            c.code = static_cast<int>(components.size());
            const int parent = parents[at(c.code)];
            if (parent >= 0) c.parent = components[at(parent)].id;
            c.index = siblings[{l, parent}]++;
            c.id = component_id(c);
            components.push_back(std::move(c));
        }
    }
    return components;
}

/// The same of a component with others: codes, ends and what is measured of them are of all.
void find_ends_together(Component& component, const ShapeModel& model, const CodeTable& codes,
                        const std::vector<float>& reference) {
    component.code_min = component.code_max = component.code_reference;
    for (int m = 0; m < codes.shape_count(); ++m) {
        double code = component.code_reference;
        for (std::size_t k = 0; k < reference.size(); ++k) {
            code += component.reading[k] *
                    (static_cast<double>(codes.shape(m)[k]) - static_cast<double>(reference[k]));
        }
        code = static_cast<double>(static_cast<float>(code));
        component.code_min = std::min(component.code_min, code);
        component.code_max = std::max(component.code_max, code);
    }
    decode_ends(component, model, reference);
}

}  // namespace

void put_at(std::span<float> codes, const Component& component, float code) {
    codes[at(component.code)] = code;
    const double moved = static_cast<double>(code) - component.code_reference;
    for (const FollowingCode& other : component.others) {
        codes[at(other.code)] += static_cast<float>(other.ratio * moved);
    }
}

std::vector<int> farthest_first(const std::vector<Component>& components) {
    std::vector<int> order(components.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, [&](int a, int b) {
        return components[at(a)].distance > components[at(b)].distance;
    });
    return order;
}

std::vector<int> strongest_first(const std::vector<Component>& components) {
    std::vector<int> order = farthest_first(components);
    std::ranges::stable_sort(order, {}, [&](int i) { return components[at(i)].level; });
    return order;
}

std::vector<Component> extract_components(ShapeModel& model, const CodeTable& codes,
                                          const FilterConfig& filter, DistanceRows& distances,
                                          const MetricScale& metric,
                                          std::optional<double> squared_error) {
    const std::vector<float> reference = model.reference_codes();
    const std::vector<ComponentPlace> places = model.places();
    const std::vector<ComponentTrust> trust = model.trust();
    std::vector<Component> components = numbered_components(model);
    std::vector<int> centers;
    for (const ComponentPlace& place : places) centers.push_back(place.center);
    distances.prepare(centers);
    for (Component& c : components) {
        c.center = places[at(c.code)].center;
        c.longest = places[at(c.code)].longest;
        c.support = places[at(c.code)].support;
        if (!trust.empty()) c.trust = trust[at(c.code)];
        c.code_reference = static_cast<double>(reference[at(c.code)]);
        find_ends(c, codes);
        decode_ends(c, model, reference);
        measure(c, model, filter, distances);
    }
    const bool has_features = model.rows() == ShapeRows::features;
    filter_components(components, codes, filter,
                      {row_width(model.rows()), has_features ? &metric : nullptr, squared_error});
    for (Component& c : components) {
        if (c.others.empty()) continue;
        find_ends_together(c, model, codes, reference);
        measure(c, model, filter, distances);
        c.support = c.moving;
    }
    return components;
}

namespace {

/// Mean share of the vertices that those components act on of which `counts` says so.
template <class Counts>
double mean_share(const std::vector<Component>& components, int vertex_count,
                  const Counts& counts) {
    double sum = 0;
    int count = 0;
    for (const Component& c : components) {
        if (!counts(c)) continue;
        sum += static_cast<double>(c.support) / vertex_count;
        ++count;
    }
    return count > 0 ? sum / count : 0;
}

}  // namespace

double mean_support(const std::vector<Component>& components, int level, int vertex_count) {
    return mean_share(components, vertex_count,
                      [level](const Component& c) { return c.level == level; });
}

double mean_support_of_kept(const std::vector<Component>& components, int vertex_count) {
    return mean_share(components, vertex_count, [](const Component& c) { return c.kept; });
}

}  // namespace mscomp
