// SPDX-License-Identifier: MIT
#include "extract_warnings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <string_view>

#include "acap/mesh/float_range.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

/// How places and faces are called in the file.
struct FileNumbers {
    const VertexPlaces& places;
    const std::vector<int>& face_numbers;  // (F) from 1, or empty

    /// In words: where something was found first.
    std::string first_place(const Occurrences& found, std::string_view kind) const {
        if (kind == "vertex") return fmt::format("vertex {}", places.vertex(found.first) + 1);
        return fmt::format("{} {}", kind,
                           face_numbers.empty() ? found.first + 1 : face_numbers[at(found.first)]);
    }
};

void warn_of_places(PlacedFeatures& set) {
    const VertexPlaces& places = set.places;
    const std::vector<int>& place = places.place_of_vertex();
    if (const int count = places.coincident_count(); count > 0) {
        set.warnings.push_back(
            fmt::format("{} vertices coincide with others in every shape: they are one place of "
                        "the surface with them and get the same feature",
                        count));
    }
    if (const int count = places.unused_count(); count > 0) {
        const auto first = std::distance(place.begin(), std::ranges::find(place, -1));
        set.warnings.push_back(
            fmt::format("reference: {} vertices without faces get the identity and have no part in "
                        "alignment and scale (first: vertex {})",
                        count, first + 1));
    }
}

void warn_of_reference(const DeformationGradients& gradients, const FileNumbers& numbers,
                       PlacedFeatures& set) {
    const auto warn = [&](const Occurrences& found, const char* what, const char* kind) {
        if (found.count == 0) return;
        set.warnings.push_back(fmt::format("reference: {} {} (first: {})", found.count, what,
                                           numbers.first_place(found, kind)));
    };
    warn(gradients.zero_area_faces(), "faces without area carry no weight", "face");
    warn_of_places(set);
    warn(gradients.folded_rings(),
         "rings whose normals cancel use the direction of their least spread", "vertex");
    warn(gradients.degenerate_rings(), "rings without width take the mean of their neighbours",
         "vertex");
}

/// One sentence for all shapes together: totals, and where it happened first.
void warn_of_shapes(const std::vector<ShapeOddities>& shapes, const FileNumbers& numbers,
                    PlacedFeatures& set, Occurrences ShapeOddities::*member, const char* what,
                    const char* kind) {
    std::int64_t total = 0;
    Occurrences affected;
    for (std::size_t n = 0; n < shapes.size(); ++n) {
        const int count = (shapes[n].*member).count;
        total += count;
        if (count > 0) affected.add(static_cast<int>(n));
    }
    if (total == 0) return;
    const auto first = at(affected.first);
    set.warnings.push_back(fmt::format(
        "{} {} in {} of {} shapes (first: {} of '{}')", total, what, affected.count, shapes.size(),
        numbers.first_place(shapes[first].*member, kind), set.names[first]));
}

void warn_of_far_shapes(const std::vector<ShapeOddities>& shapes, PlacedFeatures& set) {
    const auto is_far = [](const ShapeOddities& shape) { return shape.far_from_origin; };
    const auto first = std::ranges::find_if(shapes, is_far);
    if (first == shapes.end()) return;
    set.warnings.push_back(fmt::format(
        "{} of {} shapes lie over {} times their size from the reference (first: '{}'); float32 "
        "keeps few digits of such positions: leave out --no-align, or move the meshes",
        std::ranges::count_if(shapes, is_far), shapes.size(), kFarFromOrigin,
        set.names[at(first - shapes.begin())]));
}

}  // namespace

void warn_of_oddities(const DeformationGradients& gradients,
                      const std::vector<ShapeOddities>& shapes,
                      const std::vector<int>& face_numbers, PlacedFeatures& set) {
    const FileNumbers numbers{set.places, face_numbers};
    warn_of_reference(gradients, numbers, set);
    warn_of_shapes(shapes, numbers, set, &ShapeOddities::zero_area_faces, "faces without area",
                   "face");
    warn_of_shapes(shapes, numbers, set, &ShapeOddities::folded_rings, "rings whose normals cancel",
                   "vertex");
    warn_of_shapes(shapes, numbers, set, &ShapeOddities::mirrored,
                   "vertices are mirrored (det T < 0: S has a negative eigenvalue)", "vertex");
    warn_of_far_shapes(shapes, set);
}

void warn_of_moved_origin(const Point& origin, PlacedFeatures& set) {
    set.warnings.push_back(
        fmt::format("the reference lies over {} times its size from the origin, where float32 "
                    "keeps few digits: everything is kept relative to ({:.17g}, {:.17g}, {:.17g}), "
                    "and 'acapfeat reconstruct' puts it back",
                    kFarFromOrigin, origin[0], origin[1], origin[2]));
}

}  // namespace mscomp
