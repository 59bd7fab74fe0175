// SPDX-License-Identifier: MIT
#include "mscomp/report/component_sheets.h"

#include <fmt/format.h>

#include <algorithm>

#include "mscomp/render/render.h"

namespace mscomp {
namespace {

/// The reference and `shapes` of one view, as many in a row as fit `sheet_width` pixels.
Image tiled(const std::string& title, const std::vector<std::string>& headings,
            const TriangleMesh& reference, const std::vector<ColoredShape>& shapes,
            const std::vector<SheetTile>& labels, int longer_side, int sheet_width) {
    const SheetView view = common_view(reference, shapes, longer_side);
    std::vector<SheetTile> tiles{{picture_of({reference, {}, 0}, view), "reference", 0}};
    for (std::size_t i = 0; i < shapes.size(); ++i) {
        tiles.push_back(labels[i]);
        tiles.back().image = picture_of(shapes[i], view);
    }
    const int columns = std::clamp(sheet_width / view.width, 1, static_cast<int>(tiles.size()));
    return contact_sheet(tiles, headings, title, columns);
}

}  // namespace

Image shapes_sheet(const std::string& title, const std::string& heading,
                   const TriangleMesh& reference, const std::vector<ColoredShape>& shapes,
                   const std::vector<std::string>& names, int longer_side) {
    constexpr int kSheetWidth = 2000;
    std::vector<SheetTile> labels;
    for (const std::string& name : names) labels.push_back({{}, name, 0});
    return tiled(title, {heading}, reference, shapes, labels, longer_side, kSheetWidth);
}

void SynthesisSheet::add_row(const Component& component, const std::vector<double>& weights) {
    std::vector<ColoredShape> row;
    float farthest = 0;
    for (const double weight : weights) {
        const std::vector<ComponentWeight> one{{component.code, weight}};
        ColoredShape shape{meshes_.mesh(synthesis_.change(synthesis_.codes(one))), {}, 0};
        shape.amount = meshes_.displacement(shape.mesh);
        farthest = std::max(farthest, *std::ranges::max_element(shape.amount));
        row.push_back(std::move(shape));
        labels_.push_back(fmt::format("weight {:g}", weight));
    }
    for (ColoredShape& shape : row) shape.full_blue = farthest;
    all_.insert(all_.end(), row.begin(), row.end());
    headings_.push_back(
        fmt::format("{} (level {}), support {:.0f} %, moves {:.3g}", component.id, component.level,
                    100.0 * component.support / reference_.vertex_count(), farthest));
}

Image SynthesisSheet::draw(const std::string& title, int longer_side) const {
    const SheetView view = common_view(reference_, all_, longer_side);
    const std::size_t columns = all_.size() / headings_.size();
    std::vector<SheetTile> tiles;
    for (std::size_t i = 0; i < all_.size(); ++i) {
        tiles.push_back({picture_of(all_[i], view), labels_[i], static_cast<int>(i / columns)});
    }
    return contact_sheet(tiles, headings_, title, static_cast<int>(columns));
}

}  // namespace mscomp
