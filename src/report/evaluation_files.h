// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "mscomp/run/fits.h"
#include "mscomp/run/shape_decoder.h"

namespace mscomp {

/// The rows of "per_shape" and "component_list" of an evaluation as CSV, lists and objects within
/// a row spread over columns of their own; cells with commas, quotes or line breaks are quoted.
std::string csv_of(const nlohmann::ordered_json& rows);

/// Draws shapes beside what the fits make of them, one row each, coloured by the distance of the
/// vertices, the same distance in the same colour everywhere. Throws as write_png.
void write_error_picture(const std::string& path, const std::string& title, ShapeDecoder& decoder,
                         const TrainedRun& run, const FeatureFile& file,
                         const std::vector<int>& shapes, std::span<const Fit> fits);

}  // namespace mscomp
