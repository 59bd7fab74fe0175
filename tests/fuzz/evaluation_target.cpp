// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "fuzz/memory_file.h"
#include "fuzz/promises.h"
#include "fuzz/targets.h"
#include "sweep/kept_evaluation.h"
#include "sweep/sweep_table.h"

namespace mscomp::fuzz {

void check_evaluation(std::span<const std::byte> input) {
    static const MemoryFile memory;
    const nlohmann::ordered_json made_from{{"checkpoint", "0"}, {"fit", "both"}};
    const auto kept = kept_evaluation(memory.filled_with(input), made_from);
    if (!kept) return;
    const auto measures = measures_of(*kept);
    for (const auto& [column, value] : measures)
        require(std::isfinite(value), "measures are finite");
    SweepFile sweep;
    sweep.keys = {"train.epochs"};
    const std::string table = markdown_table(sweep, {{"point", {"1"}, measures, ""}});
    require(std::ranges::count(table, '\n') == 3, "a point is a row of the table");
    json_table(sweep, {{"point", {"1"}, measures, ""}});
}

}  // namespace mscomp::fuzz
