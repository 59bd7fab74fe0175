// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>

#include "mscomp/base/error.h"
#include "mscomp/render/plot.h"

namespace mscomp {
namespace {

// Below it powers of ten lose digits.
constexpr double kLeast = 1e-290;

/// mantissa * 10^exponent as the number its text would be read as.
double decimal(int mantissa, int exponent) {
    return exponent < 0 ? mantissa / std::pow(10.0, -exponent)
                        : mantissa * std::pow(10.0, exponent);
}

int exponent_below(double value) { return static_cast<int>(std::floor(std::log10(value))); }

void require_axis(double low, double high, int most) {
    if (!std::isfinite(low) || !std::isfinite(high - low) || low > high || most < 3) {
        throw UsageError("plot: the ends of an axis are not finite or not in order");
    }
}

/// Multiples of mantissa * 10^exponent from the last one <= low to the first one >= high.
std::vector<double> multiples(int mantissa, int exponent, double low, double high) {
    const double step = decimal(mantissa, exponent);
    const auto first = static_cast<long long>(std::floor(low / step));
    std::vector<double> ticks;
    for (long long i = first; ticks.empty() || ticks.back() < high; ++i) {
        // From whole numbers, so that 0.3 is 3 / 10 and not 0.1 + 0.1 + 0.1.
        const double whole = static_cast<double>(i) * mantissa;
        ticks.push_back(exponent < 0 ? whole / std::pow(10.0, -exponent)
                                     : whole * std::pow(10.0, exponent));
    }
    return ticks;
}

/// 1, 2 and 5 times powers of ten around [low, high].
std::vector<double> decade_parts(double low, double high) {
    constexpr std::array<int, 3> kMantissas{1, 2, 5};
    std::vector<double> ticks;
    for (int e = exponent_below(low) - 1; e <= exponent_below(high) + 1; ++e) {
        for (const int m : kMantissas) ticks.push_back(decimal(m, e));
    }
    const auto begin = std::ranges::upper_bound(ticks, low) - 1;
    const auto end = std::ranges::lower_bound(ticks, high);
    return {begin, end + 1};
}

}  // namespace

std::vector<double> round_ticks(double low, double high, int most) {
    require_axis(low, high, most);
    if (high - low < kLeast) {
        const double around = std::abs(low) < kLeast ? 1 : std::abs(low) / 2;
        return round_ticks(low - around, high + around, most);
    }
    for (int exponent = exponent_below((high - low) / most) - 1;; ++exponent) {
        for (const int mantissa : {1, 2, 5}) {
            if ((high - low) / decimal(mantissa, exponent) > most) continue;
            std::vector<double> ticks = multiples(mantissa, exponent, low, high);
            if (static_cast<int>(ticks.size()) <= most) return ticks;
        }
    }
}

std::vector<double> log_ticks(double low, double high, int most) {
    require_axis(low, high, most);
    if (low < kLeast) throw UsageError("plot: a logarithmic axis has no place for numbers <= 0");
    if (low == high) return log_ticks(low / 2, high * 2, most);
    std::vector<double> ticks = decade_parts(low, high);
    if (static_cast<int>(ticks.size()) <= most) return ticks;
    const int first = exponent_below(low);
    for (int stride = 1;; ++stride) {
        ticks.clear();
        for (int e = first; ticks.empty() || ticks.back() < high; e += stride) {
            ticks.push_back(decimal(1, e));
        }
        if (static_cast<int>(ticks.size()) <= most) return ticks;
    }
}

}  // namespace mscomp
