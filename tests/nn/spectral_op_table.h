// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "mscomp/nn/spectral_ops.h"
#include "op_table.h"
#include "shapes.h"

namespace mscomp::nn {

/// A tape with one spectral op on random inputs; keeps alive what the op borrows.
template <class T>
struct SpectralFixture {
    std::unique_ptr<ScaledLaplacian<T>> laplacian;
    std::unique_ptr<LineDistances> distances;
    std::unique_ptr<ComponentCenters<T>> centers;
    std::unique_ptr<BatchTerms<T>> terms;
    LaneMask<T> lanes;
    Tape<T> tape;
    std::vector<Var> inputs;  // all that the op gives a gradient
    Var output;
};

template <class T>
struct SpectralOpCase {
    std::string name;
    std::function<void(SpectralFixture<T>&)> build;
    friend void PrintTo(const SpectralOpCase& op_case, std::ostream* out) { *out << op_case.name; }
};

/// The table of the ops of the spectral VAE, like op_table.
template <class T>
std::vector<SpectralOpCase<T>> spectral_op_table();

/// The fixture of a case; one of the vertices is in no face.
template <class T>
std::unique_ptr<SpectralFixture<T>> make_spectral_fixture(const SpectralOpCase<T>& op_case,
                                                          FixtureSize size = FixtureSize::narrow);

}  // namespace mscomp::nn
