// SPDX-License-Identifier: MIT
// Shapes that occur more than once, exactly or moved as a whole.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "acap/edge_weights.h"
#include "check_findings.h"
#include "mscomp/acap/alignment.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"

namespace mscomp {
namespace {

// What files with few decimals round away, in radii of the reference.
constexpr double kCopyRounding = 1e-5;
constexpr std::size_t kLeadersTried = 3;

/// A shape, and the earlier ones that it may be a rigid copy of.
struct Candidate {
    std::size_t file;
    std::vector<std::size_t> leaders;
    std::optional<std::size_t> found;
};

double largest_distance(const std::vector<Point>& a, const std::vector<Point>& b) {
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        largest = std::max(largest, (as_vector(a[i]) - as_vector(b[i])).norm());
    }
    return largest;
}

/// Shapes whose invariants agree with those of earlier ones. Shapes with an agreeing earlier one
/// are still leaders themselves only if no copy is found, so chains are not followed.
std::vector<Candidate> candidates_of(const std::vector<CheckedFile>& files,
                                     const std::vector<std::size_t>& distinct, double tolerance) {
    std::multimap<double, std::size_t> by_first_invariant;
    std::vector<Candidate> candidates;
    for (const std::size_t file : distinct) {
        const auto& invariant = files[file].facts.invariant;
        Candidate candidate{file, {}, {}};
        const auto end = by_first_invariant.upper_bound(invariant[0] + tolerance);
        for (auto place = by_first_invariant.lower_bound(invariant[0] - tolerance); place != end;
             ++place) {
            const auto& other = files[place->second].facts.invariant;
            bool agrees = true;
            for (std::size_t k = 1; k < kInvariants; ++k) {
                agrees = agrees && std::abs(other[k] - invariant[k]) <= tolerance;
            }
            if (agrees) candidate.leaders.push_back(place->second);
        }
        std::sort(candidate.leaders.begin(), candidate.leaders.end());
        candidate.leaders.resize(std::min(candidate.leaders.size(), kLeadersTried));
        by_first_invariant.emplace(invariant[0], file);
        if (!candidate.leaders.empty()) candidates.push_back(std::move(candidate));
    }
    return candidates;
}

void confirm(Candidate& candidate, const MeshFiles& source, double tolerance) {
    try {
        const std::vector<Point> shape = source.shape(static_cast<int>(candidate.file) + 1);
        for (const std::size_t leader : candidate.leaders) {
            const std::vector<Point> target = source.shape(static_cast<int>(leader) + 1);
            const RigidMotion motion = best_rigid_motion(shape, target);
            if (!(largest_distance(moved(shape, motion), target) <= tolerance)) continue;
            candidate.found = leader;
            return;
        }
    } catch (const Error&) {
        // Read a minute ago and gone now: not a finding of this kind.
    }
}

CheckPlace pair_place(const CheckedFile& copy, const CheckedFile& original) {
    return {.text = fmt::format("{} = {}", copy.label, original.label),
            .file = copy.path,
            .other_file = original.path};
}

void find_rigid_copies(const std::vector<CheckedFile>& files,
                       const std::vector<std::size_t>& distinct, const MeshFiles& source,
                       double radius, std::vector<Finding>& findings) {
    // Errors of rounding average out in the invariants, which are means over the vertices.
    const double tolerance = kCopyRounding * radius;
    const double averaged =
        2 * tolerance * std::min(1.0, 5 / std::sqrt(static_cast<double>(source.vertex_count())));
    std::vector<Candidate> candidates = candidates_of(files, distinct, averaged);
    parallel_for(static_cast<std::int64_t>(candidates.size()),
                 [&](std::int64_t k) { confirm(candidates[at(k)], source, tolerance); });
    FindingBuilder copies(Severity::warning, "rigid_copies");
    for (const Candidate& candidate : candidates) {
        if (candidate.found) copies.add(pair_place(files[candidate.file], files[*candidate.found]));
    }
    copies.finish(counted(copies.count(), "shape is", "shapes are") +
                      " an earlier one again, turned or shifted as a whole",
                  "With alignment (the default) their features are the same. Remove the copies, or "
                  "they count double in training and may be in the training and the test set at "
                  "once.",
                  findings);
}

}  // namespace

void find_copies(const std::vector<CheckedFile>& files, const MeshFiles& source,
                 const FrameFacts& reference, double radius, std::vector<Finding>& findings) {
    std::map<std::array<std::uint64_t, 2>, std::size_t> first_with;
    std::vector<std::size_t> distinct;
    FindingBuilder repeated(Severity::warning, "repeated_frames");
    FindingBuilder same(Severity::note, "same_as_reference");
    const std::string& reference_path = source.paths().front();
    for (std::size_t i = 0; i < files.size(); ++i) {
        if (files[i].refusal) continue;
        const auto [place, fresh] = first_with.try_emplace(files[i].facts.hash, i);
        if (fresh) {
            distinct.push_back(i);
        } else {
            repeated.add(pair_place(files[i], files[place->second]));
        }
        if (files[i].facts.hash == reference.hash && files[i].path != reference_path) {
            same.add({.text = files[i].label, .file = files[i].path, .other_file = reference_path});
        }
    }
    repeated.finish(
        counted(repeated.count(), "shape repeats", "shapes repeat") + " an earlier one exactly",
        "Remove the repetitions, or they count double in training and may be in the "
        "training and the test set at once.",
        findings);
    find_rigid_copies(files, distinct, source, radius, findings);
    same.finish(counted(same.count(), "shape is", "shapes are") + " equal to the reference",
                "Such a shape has no deformation to learn from. Usual where a motion starts at "
                "rest.",
                findings);
}

}  // namespace mscomp
