// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "../kernels/kernels.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "nn/fused.h"

namespace mscomp::nn {

/// The op behind autoencoder() of fused.h. Its passes, each parallel over fixed chunks of slots:
///
/// forward: pack C per slot, D = W_own' C + W_ring' mean C | encode | codes | decode | the constant
/// rest. backward: decode, which leaves dD in the place of D | codes | dC from dD | encode | the
/// encoder's convolution | gradients of parameters, of the source and of the mask.
template <class T>
class Autoencoder final : public Op<T> {
  public:
    Autoencoder(Tape<T>& tape, const RingTable<T>& rings, const AutoencoderInputs& inputs,
                const LaneMask<T>& lane_mask, const LevelSupports& supports);

    std::string_view name() const override { return "autoencoder"; }
    Var output() const override { return outputs_.error; }
    const AutoencoderOutputs& outputs() const { return outputs_; }

    /// Says that backward follows the next forward passes. Where there is no residual to wait for,
    /// they then do the decoder's part of it at once, while its rows are in the cache, for
    /// gradients of the error equal to the error weight; with others backward does it again.
    /// reconstruction and add_output have nothing to read then.
    void expect_backward(bool expected) { expects_backward_ = expected; }

    void forward(Tape<T>& tape) override;
    void backward(Tape<T>& tape) override;
    std::vector<T> reference(Tape<T>& tape) const override;

    /// Adds the output of autoencoder `a` to rows (V,9,lanes); between forward and backward.
    void add_output(Tape<T>& tape, int a, std::span<T> rows) const;

    /// Gradient of the component weights of autoencoder `a` at every vertex, whether it acts or
    /// not, packed (V,9,padded), of the error and what came through the codes. After backward, and
    /// at the price of the gradient of the source, whose memory it uses.
    void full_component_grads(Tape<T>& tape, int a, AlignedVector<T>& grads) const;
    int padded_components() const { return sizes_.padded; }

  private:
    static constexpr int kMatrix = kFeatureDim * kFeatureDim;
    using Matrix = std::array<T, kMatrix>;

    /// What one autoencoder works on.
    struct Work {
        AlignedVector<T> inverse_degree;   // (slots)
        AlignedVector<T> components;       // C, (slots,9,padded)
        AlignedVector<T> decoder;          // D, then its gradient
        AlignedVector<T> components_grad;  // (slots,9,padded)
        AlignedVector<T> encoded;          // f, then the gradient before its tanh, (slots,9,lanes)
        AlignedVector<T> error;            // e, (slots,9,lanes); empty where the residual holds it
        AlignedVector<T> input_grad;       // (slots,9,lanes); empty where not wanted, or is error
        Matrix decoder_own, decoder_ring;  // as applied
        std::array<T, kFeatureDim> constant;  // tanh(bias of the decoder)
    };
    /// A piece of one autoencoder.
    struct Task {
        int autoencoder;
        int begin, end;
    };
    /// Partial sums of one task over slots.
    struct Sums {
        std::array<T, kFeatureDim> decoder_bias{};
        Matrix own{}, ring{}, decoder_own{}, decoder_ring{};
        double error = 0;
    };

    /// Of the vertices without a slot.
    struct ConstantRest {
        double count = 0;  // times active lanes
        std::array<double, kFeatureDim> masked_sums{};
    };

    void follow_supports();
    void fill_shared(Tape<T>& tape);
    void pack(Tape<T>& tape);
    void apply_decoder();
    void encode(Tape<T>& tape);
    void decode(Tape<T>& tape);
    void add_constant_errors(Tape<T>& tape);
    /// sign times the output of autoencoder `a` at the vertices [begin, end) to rows (V,9,lanes).
    void add_output(Tape<T>& tape, int a, T sign, int begin, int end, T* rows) const;
    void add_up(Tape<T>& tape);

    void sum_to_gradient(Tape<T>& tape);
    void decode_backward(Tape<T>& tape);
    void decode_task_backward(Tape<T>& tape, std::int64_t task, T factor);
    void finish_codes_grad(Tape<T>& tape);
    void decoder_to_components();
    void encode_backward();
    void conv_backward(Tape<T>& tape);
    void add_constant_bias_grads(Tape<T>& tape);
    void add_component_grads(Tape<T>& tape);
    void add_parameter_grads(Tape<T>& tape);
    void gather_children(Tape<T>& tape);
    void add_sum_to_sources(Tape<T>& tape);

    ActiveRows<T> rows_of(Tape<T>& tape, int a) const;
    Neighborhood<T> neighborhood(int a) const;
    ConvParameters<T> encoder_of(Tape<T>& tape, int a) const;
    std::int64_t row_size() const { return std::int64_t{kFeatureDim} * lanes_; }
    std::int64_t source_size() const { return vertices_ * row_size(); }
    std::int64_t code_size() const { return std::int64_t{sizes_.components} * lanes_; }
    T* error_of(Tape<T>& tape, int a);
    T* input_grad_of(int a);
    T factor_of(Tape<T>& tape, int a) const { return factor(tape.grad(outputs_.error)[at(a)]); }
    T factor(T error_grad) const { return 2 * error_grad / static_cast<T>(lane_mask_.active); }
    const T* moments_of(int a) const;
    bool has_sum() const { return outputs_.sum_error.valid(); }
    const T* sum_grad() const { return has_sum() ? sum_.data() : nullptr; }
    bool wants_source_grad(Tape<T>& tape) const {
        return inputs_.joint && tape.needs_grad(inputs_.source);
    }
    std::int64_t across_size() const { return std::int64_t{lanes_} * sizes_.padded; }
    void spread_across(const T* codes, T* across) const;  // of one autoencoder
    void spread_all(const T* codes);

    const RingTable<T>& rings_;
    AutoencoderInputs inputs_;
    const LaneMask<T>& lane_mask_;
    const LevelSupports& supports_;
    int autoencoders_, parents_, lanes_;
    std::int64_t vertices_;
    CodeSizes sizes_;
    bool wants_input_grad_;
    bool expects_backward_ = false;
    bool decoded_backward_ = false;  // the last forward did the decoder's part of backward
    AutoencoderOutputs outputs_;

    int revision_ = -1;  // of the supports that the following belongs to
    bool has_constant_rest_ = false;
    std::vector<Work> work_;  // (A)
    std::vector<Task> slot_tasks_, acting_tasks_;
    std::vector<int> first_slot_task_, first_acting_task_;  // (A+1)
    std::vector<Sums> slot_sums_;                           // per task over slots
    std::vector<std::array<T, kFeatureDim>> bias_sums_;     // per task over acting slots
    AlignedVector<T> code_sums_;                            // (tasks,K,lanes)
    AlignedVector<T> across_;                               // (A,lanes,padded)
    AlignedVector<T> codes_grad_;                           // (A,K,lanes)
    AlignedVector<T> moments_;                              // (parents,V,10)
    /// sum_p source_p - sum_a output_a, (V,9,lanes); from the start of backward minus the gradient
    /// of its squared error with respect to each output.
    AlignedVector<T> sum_;
    std::vector<double> sum_squares_;                         // per chunk of vertices
    std::vector<std::array<double, kFeatureDim>> sum_grads_;  // (V) of sum_, over the lanes
    std::vector<ConstantRest> rest_;                          // (A)
    std::vector<ChildGradient<T>> children_;                  // (A)
};

}  // namespace mscomp::nn
