// SPDX-License-Identifier: MIT
#include "error_curves.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"
#include "mscomp/eval/farthest_points.h"

namespace mscomp {
namespace {

constexpr std::size_t kMostStarts = 100;

std::vector<float> reference_codes(const std::vector<Component>& components) {
    std::vector<float> codes;
    for (const Component& c : components) codes.push_back(static_cast<float>(c.code_reference));
    return codes;
}

std::vector<Point> gathered(const std::vector<Point>& points, std::span<const int> which) {
    std::vector<Point> result;
    for (const int i : which) result.push_back(points[at(i)]);
    return result;
}

double squared_distance(const std::vector<Point>& truth, const std::vector<Point>& result) {
    const std::vector<Point> aligned = aligned_to(truth, result);
    double sum = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double away = aligned[i][axis] - truth[i][axis];
            sum += away * away;
        }
    }
    return sum;
}

}  // namespace

ErrorCurve::ErrorCurve(std::vector<int> of, const char* option, int least, int most,
                       const std::vector<Point>& reference)
    : numbers(std::move(of)) {
    for (const int n : numbers) {
        if (n < least || n > most) {
            throw UsageError(fmt::format("{}: got {}, wanted {} to {}", option, n, least, most));
        }
        errors.emplace_back(reference);
    }
}

nlohmann::ordered_json ErrorCurve::json() const {
    nlohmann::ordered_json result = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        result.push_back({{"n", numbers[i]}, {"rms_error", errors[i].value()}});
    }
    return result;
}

ComponentCurve::ComponentCurve(const std::vector<int>& numbers,
                               const std::vector<Component>& components,
                               const std::vector<Point>& reference, std::vector<Fit> fits)
    : reference_codes_(reference_codes(components)),
      farthest_first_(farthest_first(components)),
      numbers_(numbers),
      fits_(std::move(fits)),
      errors_(fits_.size(), ErrorCurve(numbers, "--components", 1,
                                       static_cast<int>(components.size()), reference)) {}

void ComponentCurve::add(ShapeDecoder& decoder, std::span<const int> shapes,
                         std::span<const DecodedShape> encoded) {
    for (std::size_t i = 0; i < numbers_.size(); ++i) {
        const std::vector<int> acting(farthest_first_.begin(),
                                      farthest_first_.begin() + numbers_[i]);
        std::vector<std::vector<float>> codes(shapes.size(), reference_codes_);
        for (std::size_t m = 0; m < shapes.size(); ++m) {
            for (const int k : acting) codes[m][at(k)] = encoded[m].codes[at(k)];
        }
        const std::vector<DecodedShape> starts = decoder.decode(shapes, std::move(codes));
        for (std::size_t f = 0; f < fits_.size(); ++f) {
            const std::vector<DecodedShape> result =
                fitted(fits_[f], decoder, shapes, starts, acting);
            for (std::size_t m = 0; m < shapes.size(); ++m) {
                errors_[f].errors[i].add(decoder.truth(shapes[m]), result[m].vertices);
            }
        }
    }
}

HandleCurve::HandleCurve(const std::vector<int>& numbers, const TrainedRun& run,
                         const CodeTable& table, const std::vector<Component>& components)
    : errors_(numbers, "--handles", 3, run.context().reference.vertex_count(),
              run.context().reference.vertices) {
    if (numbers.empty()) return;
    handles_ = farthest_point_samples(run.context().reference.vertices, std::ranges::max(numbers));
    starts_.push_back({reference_codes(components), {}});
    const std::size_t shapes = at(table.shape_count());
    const std::size_t step = (shapes + kMostStarts - 1) / kMostStarts;
    for (std::size_t m = 0; m < shapes; m += step) {
        Start start;
        const std::span<const float> codes = table.shape(static_cast<int>(m));
        start.codes.assign(codes.begin(), codes.end());
        starts_.push_back(std::move(start));
    }
}

void HandleCurve::place_starts(ShapeDecoder& decoder) {
    for (Start& start : starts_) {
        start.handles = gathered(decoder.positions(start.codes), handles_);
    }
    is_placed_ = true;
}

const std::vector<float>& HandleCurve::nearest_start(const std::vector<Point>& truth) const {
    double least = std::numeric_limits<double>::infinity();
    const Start* nearest = &starts_.front();
    for (const Start& start : starts_) {
        const std::vector<Point> handles(
            start.handles.begin(),
            start.handles.begin() + static_cast<std::ptrdiff_t>(truth.size()));
        const double distance = squared_distance(truth, handles);
        if (distance >= least) continue;
        least = distance;
        nearest = &start;
    }
    return nearest->codes;
}

void HandleCurve::add(ShapeDecoder& decoder, std::span<const int> shapes) {
    if (!is_placed_) place_starts(decoder);
    for (std::size_t i = 0; i < errors_.numbers.size(); ++i) {
        const std::vector<int> known(handles_.begin(), handles_.begin() + errors_.numbers[i]);
        std::vector<DecodedShape> starts(shapes.size());
        parallel_for(static_cast<std::int64_t>(shapes.size()), [&](std::int64_t m) {
            starts[at(m)].codes = nearest_start(gathered(decoder.truth(shapes[at(m)]), known));
        });
        const std::vector<DecodedShape> fitted = decoder.fit(shapes, starts, {{}, known});
        for (std::size_t m = 0; m < shapes.size(); ++m) {
            errors_.errors[i].add(decoder.truth(shapes[m]), fitted[m].vertices);
        }
    }
}

}  // namespace mscomp
