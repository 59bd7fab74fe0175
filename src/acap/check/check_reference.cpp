// SPDX-License-Identifier: MIT
// What is odd about the shape of the reference itself.
#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

#include "check_findings.h"
#include "mscomp/base/index.h"

namespace mscomp {

void find_reference_geometry(const FrameMeter& meter, const std::vector<int>& face_numbers,
                             const std::string& path, std::vector<Finding>& findings) {
    const auto find = [&](const Occurrences& found, const char* kind, bool is_face,
                          std::string sentence, const char* advice) {
        if (found.count == 0) return;
        FindingBuilder builder(Severity::warning, kind);
        CheckPlace place{.file = path};
        if (is_face) {
            place.face = face_numbers[at(found.first)];
            place.text = fmt::format("the first is face {}", place.face);
        } else {
            place.vertex = meter.vertex(found.first) + 1;
            place.text = fmt::format("the first is vertex {}", place.vertex);
        }
        builder.add(std::move(place), found.count);
        builder.finish("reference: " + std::move(sentence), advice, findings);
    };
    const DeformationGradients& gradients = meter.gradients();
    find(gradients.zero_area_faces(), "reference_zero_area_faces", true,
         counted(gradients.zero_area_faces().count, "face has", "faces have") + " no area",
         "They carry no weight. A few do no harm; many mean that positions were rounded too "
         "coarsely.");
    find(gradients.folded_rings(), "reference_folded_rings", false,
         counted(gradients.folded_rings().count, "vertex lies", "vertices lie") +
             " in a fold where the normals cancel",
         "The direction in which the ring spreads least is used instead. A reference without "
         "folds is better.");
    find(gradients.degenerate_rings(), "reference_rings_without_width", false,
         "around " + counted(gradients.degenerate_rings().count, "vertex", "vertices") +
             " the surface has no width",
         "The mean of the neighbours is used. Another reference may be better.");
}

}  // namespace mscomp
