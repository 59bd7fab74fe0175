// SPDX-License-Identifier: MIT
#include "mscomp/model/kept_model.h"

#include <algorithm>
#include <map>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

/// Adds `ratio` times a column to `sum`, values by vertex.
void add_column(const CodeColumn& column, double ratio, int width,
                std::map<int, std::vector<double>>& sum) {
    const std::size_t size = at(width);
    for (std::size_t n = 0; n < column.vertices.size(); ++n) {
        std::vector<double>& row = sum.try_emplace(column.vertices[n], size, 0.0).first->second;
        for (std::size_t c = 0; c < size; ++c) {
            row[c] += ratio * static_cast<double>(column.values[n * size + c]);
        }
    }
}

/// What a code that others follow changes.
CodeColumn together(const Component& component, const std::vector<CodeColumn>& columns, int width) {
    std::map<int, std::vector<double>> sum;
    add_column(columns[at(component.code)], 1, width, sum);
    for (const FollowingCode& other : component.others) {
        add_column(columns[at(other.code)], other.ratio, width, sum);
    }
    CodeColumn result;
    for (const auto& [vertex, row] : sum) {
        result.vertices.push_back(vertex);
        for (const double x : row) result.values.push_back(static_cast<float>(x));
    }
    return result;
}

}  // namespace

KeptModel::KeptModel(ShapeModel& model, const std::vector<Component>& components)
    : model_(model), all_reference_(model.reference_codes()) {
    for (const Component& c : components) {
        if (!c.kept) continue;
        acting_.push_back(c);
        acting_.back().difference = acting_.back().other_difference = {};
        components_.push_back(c);
        components_.back().code = static_cast<int>(reference_.size());
        components_.back().others.clear();
        components_.back().reading.clear();
        reference_.push_back(static_cast<float>(c.code_reference));
    }
    if (acting_.empty()) throw UsageError("--kept: the run has no kept component");
}

CodeTable KeptModel::refitted(const CodeTable& codes) const {
    CodeTable result{static_cast<int>(acting_.size()), {}};
    for (int n = 0; n < codes.shape_count(); ++n) {
        for (const Component& c : acting_) {
            double code = c.code_reference;
            for (std::size_t k = 0; k < all_reference_.size(); ++k) {
                code += c.reading[k] * (static_cast<double>(codes.shape(n)[k]) -
                                        static_cast<double>(all_reference_[k]));
            }
            result.values.push_back(static_cast<float>(code));
        }
    }
    return result;
}

std::vector<LevelSize> KeptModel::levels() const {
    std::vector<LevelSize> levels(model_.levels().size(), LevelSize{1, 0});
    for (const Component& c : acting_) ++levels[at(c.level)].components;
    return levels;
}

std::vector<int> KeptModel::parents() const {
    std::vector<int> parents;
    for (const Component& c : acting_) {
        const auto parent = std::ranges::find(acting_, c.parent, &Component::id);
        parents.push_back(parent == acting_.end() ? -1
                                                  : static_cast<int>(parent - acting_.begin()));
    }
    return parents;
}

CodeTable KeptModel::encode(const ShapeSet& shapes, std::span<const int> which) {
    return refitted(model_.encode(shapes, which));
}

std::vector<float> KeptModel::decode(std::span<const float> codes, int levels) const {
    return model_.decode(all_codes(codes), levels);
}

std::vector<float> KeptModel::change(std::span<const float> codes,
                                     std::span<const float> from) const {
    return model_.change(all_codes(codes), all_codes(from));
}

std::vector<CodeColumn> KeptModel::derivatives(std::span<const float> codes) const {
    std::vector<CodeColumn> all = model_.derivatives(all_codes(codes));
    std::vector<CodeColumn> result;
    for (const Component& c : acting_) {
        result.push_back(c.others.empty() ? std::move(all[at(c.code)])
                                          : together(c, all, row_width(rows())));
    }
    return result;
}

std::vector<ComponentPlace> KeptModel::places() const {
    const std::vector<ComponentPlace> all = model_.places();
    std::vector<ComponentPlace> result;
    for (const Component& c : acting_) {
        result.push_back(all[at(c.code)]);
        result.back().support = c.support;
    }
    return result;
}

std::vector<ComponentTrust> KeptModel::trust() const {
    const std::vector<ComponentTrust> all = model_.trust();
    std::vector<ComponentTrust> result;
    if (all.empty()) return result;
    for (const Component& c : acting_) result.push_back(all[at(c.code)]);
    return result;
}

std::vector<float> KeptModel::all_codes(std::span<const float> codes) const {
    std::vector<float> all = all_reference_;
    for (std::size_t i = 0; i < acting_.size(); ++i) put_at(all, acting_[i], codes[i]);
    return all;
}

}  // namespace mscomp
