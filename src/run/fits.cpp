// SPDX-License-Identifier: MIT
#include "mscomp/run/fits.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "mscomp/base/error.h"

namespace mscomp {
namespace {

constexpr Fit kEveryFit[] = {Fit::features, Fit::codes, Fit::vertices};

}  // namespace

const char* name_of(Fit fit) {
    if (fit == Fit::features) return "features";
    return fit == Fit::codes ? "codes" : "vertices";
}

std::vector<std::string> fit_names() {
    std::vector<std::string> names;
    for (const Fit fit : kEveryFit) names.emplace_back(name_of(fit));
    return names;
}

std::vector<std::string> fit_choices() {
    std::vector<std::string> names = fit_names();
    names.insert(names.end(), {"both", "all"});
    return names;
}

std::vector<Fit> fits_named(const std::string& choice) {
    if (choice == "both") return {Fit::features, Fit::vertices};
    if (choice == "all") return {std::begin(kEveryFit), std::end(kEveryFit)};
    for (const Fit fit : kEveryFit) {
        if (choice == name_of(fit)) return {fit};
    }
    throw UsageError(fmt::format("evaluation: fit '{}', wanted one of {}", choice,
                                 fmt::join(fit_choices(), ", ")));
}

std::vector<Fit> fits_of_run(const std::string& choice, const TrainedRun& run) {
    std::vector<Fit> fits = fits_named(choice);
    if (run.model->rows() == ShapeRows::features) return fits;
    if (choice == name_of(Fit::codes)) {
        throw UsageError(
            fmt::format("--fit codes: a model of kind {} decodes to positions and has no features "
                        "to fit codes to; wanted --fit features or vertices",
                        run.config.kind));
    }
    std::erase(fits, Fit::codes);
    return fits;
}

std::vector<DecodedShape> fitted(Fit fit, ShapeDecoder& decoder, std::span<const int> shapes,
                                 std::span<const DecodedShape> starts,
                                 const std::vector<int>& moving) {
    if (fit == Fit::codes) return decoder.fit_features(shapes, starts, moving);
    if (fit == Fit::vertices) return decoder.fit(shapes, starts, {moving, {}});
    return {starts.begin(), starts.end()};
}

}  // namespace mscomp
