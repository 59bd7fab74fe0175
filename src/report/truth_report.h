// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "known_units.h"
#include "mscomp/acap/feature_file.h"
#include "mscomp/eval/support_overlap.h"
#include "mscomp/run/trained_run.h"
#include "true_components.h"

namespace mscomp {

/// The components of a run beside those that a generated set is made of: which lies where a true
/// one does, which has its weights, and whether coarse and fine ones are found as such.
class TruthReport {
  public:
    /// Reads the truth at `path` and the supports beside it for the shapes of `file` and the mesh
    /// of `run`. Borrows the components. Throws as read_true_components, read_true_supports and
    /// weights_of_shapes do.
    TruthReport(const std::string& path, const FeatureFile& file, const TrainedRun& run,
                const std::vector<Component>& components);

    /// "file", "components", "varying", thresholds and "by_overlap": the component of each truth
    /// by the overlap of supports, one to one, and for each scale means and counts.
    nlohmann::ordered_json by_overlap(std::span<const int> shapes) const;
    /// Of the codes (n,K) of n `shapes`: as KnownUnits::matches, each match with the overlap of its
    /// component, the correlation of the one found by overlap, and for each scale means and counts.
    nlohmann::ordered_json by_correlation(std::span<const int> shapes,
                                          std::span<const double> codes) const;

  private:
    /// What a truth was found as; -1: as nothing.
    struct Found {
        int component = -1;
        double correlation = 0;
    };
    nlohmann::ordered_json component_json(int truth, int component) const;
    nlohmann::ordered_json scale_json(int scale, std::span<const Found> found,
                                      bool has_correlations) const;

    std::string path_;
    TrueComponents truth_;
    KnownUnits weights_;  // of all shapes of the file
    const std::vector<Component>& components_;
    int level_count_;
    SupportMatches overlaps_;
};

}  // namespace mscomp
