// SPDX-License-Identifier: MIT
#include "training_progress.h"

#include <fmt/format.h>

namespace mscomp {

std::string describe_loss(const EpochReport& report, const std::vector<std::string>& terms) {
    std::string text = fmt::format("loss {:.4g} ", report.total);
    for (std::size_t i = 0; i < terms.size(); ++i) {
        text += fmt::format(" {} {:.3g}", terms[i], report.terms[i]);
    }
    return text +
           fmt::format("  {:.0f} ms/step, {:.0f} % touched", report.step_ms, 100 * report.touched);
}

}  // namespace mscomp
