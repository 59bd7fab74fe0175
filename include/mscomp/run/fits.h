// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

#include "mscomp/run/shape_decoder.h"

namespace mscomp {

/// How the codes of a shape are found (docs/evaluate.md).
enum class Fit {
    features,  // the encoder reads them
    codes,     // joint codes: fitted to the features from there
    vertices   // fitted to the vertices from there
};

/// As `--fit` and the keys of reports have it.
const char* name_of(Fit fit);
/// All of them by name, in the order of the enumeration.
std::vector<std::string> fit_names();
/// These, and names for several: both (features and vertices) and all.
std::vector<std::string> fit_choices();
/// The fits that a choice asks for, in the order of the enumeration. Throws UsageError for another
/// name.
std::vector<Fit> fits_named(const std::string& choice);
/// The same of a model of the run: `all` leaves out what it cannot do. Throws UsageError for
/// `codes` where the model does not decode to features.
std::vector<Fit> fits_of_run(const std::string& choice, const TrainedRun& run);

/// What a fit makes of shapes that encode() or decode() made `starts` of; only the codes `moving`
/// move, empty meaning all.
std::vector<DecodedShape> fitted(Fit fit, ShapeDecoder& decoder, std::span<const int> shapes,
                                 std::span<const DecodedShape> starts,
                                 const std::vector<int>& moving = {});

}  // namespace mscomp
