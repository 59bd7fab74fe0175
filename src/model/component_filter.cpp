// SPDX-License-Identifier: MIT
#include "model/component_filter.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "model/change_products.h"
#include "model/refit.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Codes (N,K) counted from those of the reference.
MatrixXd codes_from_reference(const std::vector<Component>& components, const CodeTable& codes) {
    MatrixXd result(codes.shape_count(), static_cast<Index>(components.size()));
    for (Index n = 0; n < result.rows(); ++n) {
        for (std::size_t k = 0; k < components.size(); ++k) {
            result(n, static_cast<Index>(k)) =
                static_cast<double>(codes.shape(static_cast<int>(n))[k]) -
                components[k].code_reference;
        }
    }
    return result;
}

/// Why the papers drop a component of a model whose strongest one has strength `most`; empty where
/// they do not.
std::string reason_of_strength(const Component& component, const FilterConfig& filter,
                               double most) {
    if (component.support == 0) return "no vertex is left in its support";
    if (!(component.strength >= filter.minimum_strength)) {
        return fmt::format("strength {:.3g} is below {:.3g}", component.strength,
                           filter.minimum_strength);
    }
    if (!(component.strength >= filter.minimum_share * most)) {
        return fmt::format("strength {:.3g} is below {:.3g} of the strongest, {:.3g}",
                           component.strength, filter.minimum_share, most);
    }
    return {};
}

/// `error` of the training shapes, as a share of the squares that they move; 0: none, or not known.
std::string reason_of_refit(const RefitStep& step, const std::vector<Component>& components,
                            double error) {
    const Component& component = components[at(step.component)];
    if (step.into >= 0) {
        const bool by_codes = step.likeness.codes > step.likeness.changes;
        return fmt::format(
            "merged into {}: {} {:.3f}", components[at(step.into)].id,
            by_codes ? "their codes predict each other by" : "what they change has the cosine",
            step.likeness.most());
    }
    if (component.support == 0) return "no vertex is left in its support";
    if (component.distance == 0) return "the training shapes do not move it";
    std::string reason =
        fmt::format("without it the others lose {:.2g} % of the motion", 100 * step.cost);
    if (error > 0) reason += fmt::format(", {:.2g} % of the error", 100 * step.cost / error);
    return reason;
}

void drop_weak_ones(std::vector<Component>& components, const FilterConfig& filter, Refit& refit) {
    double most = 0;
    for (const Component& c : components) most = std::max(most, c.strength);
    std::vector<int> weak;
    for (Component& c : components) {
        c.reason = reason_of_strength(c, filter, most);
        if (!c.reason.empty()) weak.push_back(c.code);
    }
    refit.drop_all(weak);
}

void drop_what_others_make_up_for(std::vector<Component>& components, const FilterConfig& filter,
                                  std::optional<double> squared_error, Refit& refit) {
    constexpr double kRounding = 1e-7;  // of single precision, as a share of the motion
    const bool has_error = squared_error && refit.squares() > 0;
    const double error = has_error ? *squared_error / refit.squares() : 0;
    refit.reduce(filter.refit_share * error + kRounding, filter.alike);
    for (const RefitStep& step : refit.steps()) {
        Component& c = components[at(step.component)];
        c.reason = reason_of_refit(step, components, error);
        if (step.into >= 0) c.merged_into = components[at(step.into)].id;
    }
    for (Component& c : components) {
        if (c.merged_into.empty()) continue;
        const auto into = std::ranges::find(components, c.merged_into, &Component::id);
        if (!into->reason.empty()) c.reason += ", which was dropped then";
    }
}

/// What the refitted components are made of.
void describe_kept(std::vector<Component>& components, const Refit& refit) {
    for (const int k : refit.left()) {
        Component& c = components[at(k)];
        c.cost = refit.cost(k);
        const Eigen::VectorXd reading = refit.reading(k), direction = refit.direction(k);
        c.reading.assign(reading.begin(), reading.end());
        for (Index j = 0; j < direction.size(); ++j) {
            if (j != k && direction[j] != 0)
                c.others.push_back({static_cast<int>(j), direction[j]});
        }
    }
}

}  // namespace

void filter_components(std::vector<Component>& components, const CodeTable& codes,
                       const FilterConfig& filter, const ErrorOfRows& error) {
    Refit refit(change_products(components, error.width, error.metric),
                codes_from_reference(components, codes));
    if (filter.rule == FilterRule::strength) {
        drop_weak_ones(components, filter, refit);
    } else {
        drop_what_others_make_up_for(components, filter, error.training_squares, refit);
    }
    for (const RefitStep& step : refit.steps()) components[at(step.component)].cost = step.cost;
    describe_kept(components, refit);
    for (Component& c : components) c.kept = c.reason.empty();
}

}  // namespace mscomp
