// SPDX-License-Identifier: MIT
// What is odd about single shapes, gathered over all.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "acap/mesh/float_range.h"
#include "check_findings.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

constexpr double kMirrorImage = -0.3;  // bend_agreement: real poses stay above 0.85
constexpr double kFarAway = 10.0;      // centroids apart, in radii
constexpr double kSharpTurn = 150.0 / 180 * std::numbers::pi;

/// Names a unit mix-up where a ratio looks like one.
std::string unit_hint(double ratio) {
    struct Unit {
        double ratio;
        const char* text;
    };
    constexpr std::array<Unit, 7> kUnits{{{10, "as millimetres to centimetres"},
                                          {100, "as centimetres to metres"},
                                          {1000, "as millimetres to metres"},
                                          {2.54, "as centimetres to inches"},
                                          {25.4, "as millimetres to inches"},
                                          {12, "as inches to feet"},
                                          {39.37, "as inches to metres"}}};
    const double larger = std::max(ratio, 1 / ratio);
    for (const Unit& unit : kUnits) {
        if (std::abs(larger / unit.ratio - 1) < 0.05) return std::string(", ") + unit.text;
    }
    return "";
}

class ShapeFinder {
  public:
    ShapeFinder(const std::vector<CheckedFile>& files, const std::vector<int>& face_numbers,
                const FrameFacts& reference, const CheckReport& report)
        : files_(files), numbers_(face_numbers), reference_(reference), report_(report) {}

    void find(std::vector<Finding>& findings) const {
        find_not_finite(findings);
        find_permuted(findings);
        find_strays(findings);
        find_strays_of_reference(findings);
        find_mirror_images(findings);
        find_other_units(findings);
        find_faces_and_folds(findings);
        find_outlier(findings);
        find_far_away(findings);
        find_far_from_origin(findings);
        find_sharp_turns(findings);
    }

  private:
    template <class Visit>
    void for_each(Visit visit) const {
        for (const CheckedFile& file : files_) {
            if (!file.refusal) visit(file);
        }
    }

    static CheckPlace place_in(const CheckedFile& file, std::string_view text) {
        CheckPlace place{.text = fmt::format("{}{}{}", file.label, text.empty() ? "" : ": ", text),
                         .file = file.path};
        return place;
    }
    static CheckPlace vertex_in(const CheckedFile& file, int vertex, std::string_view text) {
        CheckPlace place =
            place_in(file, fmt::format("{}{}vertex {}", text, text.empty() ? "" : " ", vertex + 1));
        place.vertex = vertex + 1;
        return place;
    }

    static bool is_mirror_image(const FrameFacts& facts) {
        return !facts.edges.permuted && facts.bend_agreement < kMirrorImage;
    }
    std::string perhaps_reference(std::int64_t shapes) const {
        if (shapes < 2 || 2 * shapes <= report_.usable) return "";
        return fmt::format(
            " This holds for most shapes, so perhaps it is the reference {} that is "
            "out of line: choose another with --reference.",
            report_.reference);
    }

    void find_not_finite(std::vector<Finding>& findings) const {
        FindingBuilder builder(Severity::error, "not_finite");
        for_each([&](const CheckedFile& file) {
            if (!file.facts.finite) builder.add(place_in(file, ""));
        });
        builder.finish(counted(builder.count(), "shape has", "shapes have") +
                           " coordinates too large to compute with",
                       "Look for a vertex that flew away, or a wrong unit.", findings);
    }

    void find_permuted(std::vector<Finding>& findings) const {
        FindingBuilder builder(Severity::warning, "permuted_vertices");
        for_each([&](const CheckedFile& file) {
            const EdgeStretch& edges = file.facts.edges;
            if (!edges.permuted) return;
            builder.add(vertex_in(file, edges.first_permuted, "the first clearly out of place is"));
        });
        const std::string hint = perhaps_reference(builder.count());
        builder.finish(
            counted(builder.count(), "shape seems", "shapes seem") +
                " to have its vertices in another order than the reference",
            "Neighbours on the mesh lie far apart there, as if the vertices had been renumbered. "
            "Features of such a shape are meaningless: export it again, keeping the order of the "
            "vertices." +
                hint,
            findings);
    }

    void find_strays(std::vector<Finding>& findings) const {
        FindingBuilder builder(Severity::warning, "stray_vertices");
        for_each([&](const CheckedFile& file) {
            for (const int vertex : file.facts.edges.stray) {
                builder.add(vertex_in(file, vertex, ""));
            }
        });
        builder.finish(
            counted(builder.count(), "vertex lies", "vertices lie") +
                " far from all neighbours, like a spike",
            "Usually a fault of scanning or tracking. One such vertex spoils the scaling "
            "of all features: mend it or leave the shape out.",
            findings);
    }

    void find_strays_of_reference(std::vector<Finding>& findings) const {
        std::map<int, int> shapes_with;
        for_each([&](const CheckedFile& file) {
            for (const int vertex : file.facts.edges.shrunk) ++shapes_with[vertex];
        });
        FindingBuilder builder(Severity::warning, "reference_stray_vertices");
        for (const auto& [vertex, shapes] : shapes_with) {
            if (2 * shapes <= report_.usable - 1) continue;
            CheckPlace place{.text = fmt::format("vertex {}", vertex + 1),
                             .file = report_.reference};
            place.vertex = vertex + 1;
            place.count = shapes;
            builder.add(std::move(place));
        }
        builder.finish("reference: " + counted(builder.count(), "vertex lies", "vertices lie") +
                           " far from all neighbours, like a spike, but not in the other shapes",
                       "Mend the reference or choose another with --reference.", findings);
    }

    void find_mirror_images(std::vector<Finding>& findings) const {
        FindingBuilder frames(Severity::warning, "mirrored_frames");
        FindingBuilder vertices(Severity::warning, "mirrored_vertices");
        for_each([&](const CheckedFile& file) {
            if (is_mirror_image(file.facts)) {
                frames.add(place_in(file, ""));
            } else if (!file.facts.edges.permuted && file.facts.mirrored.count > 0) {
                const Occurrences& found = file.facts.mirrored;
                CheckPlace place =
                    vertex_in(file, found.first, fmt::format("{}, the first is", found.count));
                place.count = found.count;
                vertices.add(std::move(place), found.count);
            }
        });
        const std::string hint = perhaps_reference(frames.count());
        frames.finish(counted(frames.count(), "shape is", "shapes are") +
                          " a mirror image: what bulges in the reference is hollow there",
                      "Usually an axis was flipped on export. Flip it back, or the features "
                      "describe a shape turned inside out." +
                          hint,
                      findings);
        vertices.finish(
            fmt::format("around {} in {} the surface is turned over",
                        counted(vertices.count(), "vertex", "vertices"),
                        counted(vertices.places_added(), "shape", "shapes")),
            "The surface is folded or passes through itself there (det T < 0). Extraction works; S "
            "has a negative eigenvalue there.",
            findings);
    }

    void find_other_units(std::vector<Finding>& findings) const {
        FindingBuilder builder(Severity::warning, "other_scale");
        for_each([&](const CheckedFile& file) {
            if (!file.facts.edges.is_other_unit()) return;
            const double ratio = file.facts.edges.median_ratio;
            builder.add(place_in(
                file, ratio > 1 ? fmt::format("{:.4g} times as large{}", ratio, unit_hint(ratio))
                      : ratio > 0
                          ? fmt::format("{:.4g} times smaller{}", 1 / ratio, unit_hint(ratio))
                          : "all vertices in one point"));
        });
        const std::string hint = perhaps_reference(builder.count());
        builder.finish(counted(builder.count(), "shape has", "shapes have") +
                           " another size than the reference",
                       "Size is taken for deformation, and a wrong unit drowns all other "
                       "deformation. Bring all files to one unit." +
                           hint,
                       findings);
    }

    /// Those of the reference itself are a finding of their own and mostly come back everywhere.
    void find_faces_and_folds(std::vector<Finding>& findings) const {
        FindingBuilder areas(Severity::warning, "zero_area_faces");
        FindingBuilder folds(Severity::warning, "folded_rings");
        for_each([&](const CheckedFile& file) {
            if (const Occurrences& found = file.facts.zero_area_faces;
                found.count > reference_.zero_area_faces.count) {
                const int face = numbers_[at(found.first)];
                CheckPlace place =
                    place_in(file, fmt::format("{}, the first is face {}", found.count, face));
                place.face = face;
                place.count = found.count;
                areas.add(std::move(place), found.count);
            }
            if (const Occurrences& found = file.facts.folded_rings;
                found.count > reference_.folded_rings.count) {
                CheckPlace place =
                    vertex_in(file, found.first, fmt::format("{}, the first is", found.count));
                place.count = found.count;
                folds.add(std::move(place), found.count);
            }
        });
        const auto more_in_shapes = [](const FindingBuilder& builder) {
            return fmt::format(" in {}, more than in the reference",
                               counted(builder.places_added(), "shape", "shapes"));
        };
        areas.finish(
            counted(areas.count(), "face", "faces") + " without area" + more_in_shapes(areas),
            "They have no normal and are passed over. A few do no harm.", findings);
        folds.finish(counted(folds.count(), "ring", "rings") +
                         " folded so that the normals cancel" + more_in_shapes(folds),
                     "The direction in which the ring spreads least is used instead. A few do no "
                     "harm.",
                     findings);
    }

    void find_outlier(std::vector<Finding>& findings) const {
        const StretchRange& range = report_.stretch;
        if (!is_stretch_outlier(range.largest, range.most_below)) return;
        FindingBuilder of_shapes(Severity::warning, "stretch_outlier");
        FindingBuilder of_reference(Severity::warning, "reference_pinched");
        for_each([&](const CheckedFile& file) {
            const FrameFacts& facts = file.facts;
            if (!is_stretch_outlier(facts.largest_stretch, range.most_below)) return;
            (facts.opens_a_pinch ? of_reference : of_shapes)
                .add(vertex_in(file, facts.largest_stretch_vertex,
                               fmt::format("{:.4g} at", facts.largest_stretch)));
        });
        const std::string sentence = fmt::format(
            "the largest stretch is {:.4g}, but 99.9 % of the vertices stay below {:.3g}",
            range.largest, range.most_below);
        of_shapes.finish(sentence,
                         "One scale serves all shapes, so this vertex makes everything else small "
                         "for the network. Mend it or leave the shape out.",
                         findings);
        of_reference.finish(
            "the reference is pinched where shapes are not: " + sentence,
            "One scale serves all shapes, so this makes everything else small for the network. "
            "Nothing is wrong with the shapes: choose a reference that is open there with "
            "--reference.",
            findings);
    }

    void find_far_away(std::vector<Finding>& findings) const {
        FindingBuilder builder(Severity::note, "far_away");
        for_each([&](const CheckedFile& file) {
            if (!(file.facts.offset > kFarAway)) return;
            builder.add(place_in(file, fmt::format("{:.3g} radii", file.facts.offset)));
        });
        builder.finish(
            counted(builder.count(), "shape lies", "shapes lie") + " far from the reference",
            "Alignment, the default, takes care of it.", findings);
    }

    void find_far_from_origin(std::vector<Finding>& findings) const {
        FindingBuilder builder(Severity::warning, "far_from_origin");
        for_each([&](const CheckedFile& file) {
            const double distance = file.facts.origin_distance;
            if (distance > kFarFromOrigin) {
                builder.add(place_in(file, fmt::format("{:.3g} times its size", distance)));
            }
        });
        builder.finish(
            counted(builder.count(), "shape lies", "shapes lie") + " very far from the origin",
            "Positions are stored as float32, which keeps about seven digits, few of "
            "them of the shape there. Move all meshes to the origin first.",
            findings);
    }

    void find_sharp_turns(std::vector<Finding>& findings) const {
        FindingBuilder builder(Severity::note, "sharp_turns");
        for_each([&](const CheckedFile& file) {
            if (file.facts.edges.permuted || !(file.facts.sharpest_turn > kSharpTurn)) return;
            builder.add(vertex_in(file, file.facts.sharpest_turn_vertex,
                                  fmt::format("{:.0f} degrees at",
                                              file.facts.sharpest_turn / std::numbers::pi * 180)));
        });
        builder.finish("in " + counted(builder.count(), "shape", "shapes") +
                           " neighbouring vertices turn by more than 150 degrees against each "
                           "other",
                       "Usually a small fold or a tangle of the surface there. It widens the range "
                       "of the rotations; a few do no harm.",
                       findings);
    }

    const std::vector<CheckedFile>& files_;
    const std::vector<int>& numbers_;
    const FrameFacts& reference_;
    const CheckReport& report_;
};

}  // namespace

void find_in_shapes(const std::vector<CheckedFile>& files, const std::vector<int>& face_numbers,
                    const FrameFacts& reference, const CheckReport& report,
                    std::vector<Finding>& findings) {
    ShapeFinder(files, face_numbers, reference, report).find(findings);
}

}  // namespace mscomp
