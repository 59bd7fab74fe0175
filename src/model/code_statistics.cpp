// SPDX-License-Identifier: MIT
#include "mscomp/model/code_statistics.h"

#include <cmath>
#include <cstddef>

#include "mscomp/base/index.h"

namespace mscomp {
namespace {

std::vector<double> code_variances(const CodeTable& codes) {
    const auto width = at(codes.code_count), shapes = at(codes.shape_count());
    std::vector<double> variances(width, 0.0);
    if (shapes == 0) return variances;
    for (std::size_t k = 0; k < width; ++k) {
        double sum = 0, squares = 0;
        for (std::size_t m = 0; m < shapes; ++m) sum += codes.values[m * width + k];
        const double mean = sum / static_cast<double>(shapes);
        for (std::size_t m = 0; m < shapes; ++m) {
            const double away = static_cast<double>(codes.values[m * width + k]) - mean;
            squares += away * away;
        }
        variances[k] = squares / static_cast<double>(shapes);
    }
    return variances;
}

}  // namespace

std::vector<float> code_deviations(const CodeTable& codes) {
    std::vector<float> deviations;
    for (const double variance : code_variances(codes)) {
        deviations.push_back(static_cast<float>(std::sqrt(variance)));
    }
    return deviations;
}

double code_deviation(const CodeTable& codes) {
    const std::vector<double> variances = code_variances(codes);
    double sum = 0;
    for (const double variance : variances) sum += variance;
    return std::sqrt(sum / static_cast<double>(variances.size()));
}

}  // namespace mscomp
