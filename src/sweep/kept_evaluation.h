// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace mscomp {

/// The evaluation that the file `path` keeps, if it was made from `made_from`. None where there is
/// no such file, where it is of something else, or not what keep_evaluation() writes. Throws
/// IoError.
std::optional<nlohmann::ordered_json> kept_evaluation(const std::string& path,
                                                      const nlohmann::ordered_json& made_from);

/// Keeps `evaluation` in the file `path` and returns it as it will be read: null where a number is
/// not finite. Throws IoError.
nlohmann::ordered_json keep_evaluation(const std::string& path,
                                       const nlohmann::ordered_json& made_from,
                                       const nlohmann::ordered_json& evaluation);

}  // namespace mscomp
