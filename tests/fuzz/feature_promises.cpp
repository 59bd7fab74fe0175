// SPDX-License-Identifier: MIT
#include "fuzz/feature_promises.h"

#include <cmath>

#include "acap/feature_format.h"
#include "fuzz/promises.h"

namespace mscomp::fuzz {
namespace {

template <class Numbers>
void check_finite(const Numbers& numbers) {
    for (const auto x : numbers) require(std::isfinite(x), "numbers are finite");
}

}  // namespace

void check_sound(const FeatureSet& set) {
    const auto n = static_cast<std::size_t>(set.shape_count());
    const auto v = static_cast<std::size_t>(set.vertex_count());
    require(n > 0 && v > 0 && !set.reference.faces.empty(), "a set has shapes, vertices and faces");
    require(set.features.size() == n * v * kFeatureDim && set.vertices.size() == n * v * 3 &&
                set.rotation.size() == n && set.translation.size() == n,
            "counts agree");
    check_finite(set.features);
    check_finite(set.vertices);
    check_finite(flat(set.reference.vertices));
    check_finite(flat(set.rotation));
    check_finite(flat(set.translation));
    for (const int corner : flat(set.reference.faces)) {
        require(corner >= 0 && corner < set.vertex_count(), "faces refer to vertices");
    }
    for (const PerShapeNumber& number : kPerShapeNumbers) {
        const std::vector<double>& values = set.*number.member;
        require(values.empty() || values.size() == n, "one number for every shape");
        for (const double x : values) {
            require(std::isfinite(x) || (number.may_be_nan && std::isnan(x)), "numbers are finite");
        }
    }
}

void check_same(const FeatureSet& read, const FeatureSet& written) {
    require(read.names == written.names && read.weights == written.weights, "names survive");
    require(same_bits(read.features, written.features) &&
                same_bits(read.vertices, written.vertices) &&
                same_bits(read.reference.vertices, written.reference.vertices) &&
                read.reference.faces == written.reference.faces &&
                same_bits(read.rotation, written.rotation) &&
                same_bits(read.translation, written.translation),
            "a set survives, bit for bit");
    for (const PerShapeNumber& number : kPerShapeNumbers) {
        require(same_bits(read.*number.member, written.*number.member),
                "numbers per shape survive");
    }
}

}  // namespace mscomp::fuzz
