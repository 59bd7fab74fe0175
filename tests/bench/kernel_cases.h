// SPDX-License-Identifier: MIT
// Every kernel beside its plain loop on the same data, for the benchmark and for the test that
// watches their ratio.
#pragma once

#include <deque>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "base/aligned.h"
#include "plain_kernels.h"

namespace mscomp::nn {

/// One kernel on all vertices.
struct KernelCase {
    std::string name;
    double flops = 0;  // of one run; tanh, square root and division count as one
    double bytes = 0;  // least traffic of one run: every array read or written once
    std::function<void(const Kernels<float>&)> fast;
    std::function<void()> plain;
    std::function<void()> reset;  // brings all outputs back to where a run starts from
    /// What fast and plain fill, array for array.
    std::vector<const AlignedVector<float>*> fast_outputs, plain_outputs;
};

/// Random arrays for all kernels, on a sphere in the order of reverse Cuthill-McKee.
class KernelCases {
  public:
    explicit KernelCases(const plain::Sizes& sizes);
    KernelCases(const KernelCases&) = delete;
    KernelCases& operator=(const KernelCases&) = delete;

    const std::deque<KernelCase>& all() const { return cases_; }
    const KernelCase& at(std::string_view name) const;

  private:
    /// Makes an output twice, of `start` or of zeros, and registers it with the last case.
    struct Twice {
        AlignedVector<float>& fast;
        AlignedVector<float>& plain;
    };
    Twice output(std::size_t count, const AlignedVector<float>* start = nullptr);
    KernelCase& add(std::string name, double flops, double bytes);
    AlignedVector<float>& random(std::size_t count);
    void add_convolution();
    void add_codes();
    void add_losses();
    void add_elementwise();

    /// What the kernels of a whole autoencoder share; every vertex has a slot and acts.
    struct Autoencoder {
        ActiveRows<float> rows;
        CodeSizes codes;
        std::size_t packed;  // numbers in component weights [slot][9][padded]
        const int* acting;
        const float* lane_weight;
    };
    Autoencoder autoencoder();
    AlignedVector<float>& random_components(const Autoencoder& shared, std::size_t rows);
    void add_encoder(const Autoencoder& shared);
    void add_decoder(const Autoencoder& shared);
    void add_input_gradient(const Autoencoder& shared);
    void add_children(const Autoencoder& shared);
    void add_spectral_convolution();
    void add_spectral_codes();
    void add_spectral_elementwise();
    void add_spectral_sparsity();

    plain::Sizes sizes_;
    std::size_t rows_;  // numbers in rows of all vertices
    std::vector<int> offsets_, neighbors_;
    std::vector<float> inverse_degree_;
    Neighborhood<float> rings_;
    std::deque<AlignedVector<float>> arrays_;  // references stay valid, here and below
    std::deque<std::vector<int>> indices_;
    std::deque<std::vector<ChildGradient<float>>> children_;
    std::vector<double> distances_;  // (vertices * lanes)
    std::deque<KernelCase> cases_;
};

/// Runs both once from the same start: the largest difference over the largest value of the plain
/// loop's, the worst of all outputs; NaN where any number is.
double difference(const KernelCase& what, const Kernels<float>& kernels);

}  // namespace mscomp::nn
