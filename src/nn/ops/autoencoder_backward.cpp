// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cassert>

#include "autoencoder.h"
#include "batch.h"
#include "mscomp/base/index.h"

namespace mscomp::nn {
namespace {

constexpr std::int64_t kScratchRows = 16;

/// Memory of this thread for `count` values.
template <class T>
T* thread_scratch(std::int64_t count) {
    thread_local AlignedVector<T> scratch;
    if (scratch.size() < at(count)) scratch.resize(at(count));
    return scratch.data();
}

/// target += the sum of one member over consecutive tasks, in their order, in double.
template <class T, std::size_t kSize, class Get>
void add_sums(int first, int last, const Get& get, std::span<T, kSize> target) {
    std::array<double, kSize> sums{};
    for (int t = first; t < last; ++t) {
        const auto& of_task = get(at(t));
        for (std::size_t i = 0; i < kSize; ++i) sums[i] += static_cast<double>(of_task[i]);
    }
    for (std::size_t i = 0; i < kSize; ++i) target[i] += static_cast<T>(sums[i]);
}

}  // namespace

template <class T>
void Autoencoder<T>::backward(Tape<T>& tape) {
    assert(revision_ == supports_.revision());
    if (has_sum()) sum_to_gradient(tape);
    decode_backward(tape);
    finish_codes_grad(tape);
    decoder_to_components();
    encode_backward();
    conv_backward(tape);
    if (has_constant_rest_) add_constant_bias_grads(tape);
    add_component_grads(tape);
    add_parameter_grads(tape);
    if (wants_input_grad_) gather_children(tape);
    if (has_sum() && wants_source_grad(tape)) add_sum_to_sources(tape);
}

template <class T>
void Autoencoder<T>::decode_backward(Tape<T>& tape) {
    if (decoded_backward_) {
        const auto weight = static_cast<T>(inputs_.error_weight);
        if (std::ranges::all_of(tape.grad(outputs_.error), [&](T g) { return g == weight; }))
            return;
        expects_backward_ = false;
        apply_decoder();
        decode(tape);
        expects_backward_ = true;
    }
    parallel_for(static_cast<std::int64_t>(slot_tasks_.size()), [&](std::int64_t t) {
        decode_task_backward(tape, t, factor_of(tape, slot_tasks_[at(t)].autoencoder));
    });
}

template <class T>
void Autoencoder<T>::decode_task_backward(Tape<T>& tape, std::int64_t t, T factor) {
    const Task& task = slot_tasks_[at(t)];
    const int a = task.autoencoder;
    const double error = slot_sums_[at(t)].error;
    Sums& sums = slot_sums_[at(t)];
    sums = {};
    sums.error = error;
    T* codes_grad = code_sums_.data() + t * code_size();
    std::fill_n(codes_grad, code_size(), T{0});
    kernels<T>().autoencoder.decode_backward(
        rows_of(tape, a), work_[at(a)].decoder.data(), sizes_, across_.data() + a * across_size(),
        lane_mask_.weight.data(), factor, error_of(tape, a),
        outputs_.residual.valid() ? tape.grad(outputs_.residual).data() + a * source_size()
                                  : nullptr,
        sum_grad(), task.begin, task.end, wants_input_grad_ ? input_grad_of(a) : nullptr,
        codes_grad, sums.decoder_bias.data(), thread_scratch<T>(row_size()));
}

/// Adds what other ops say about the codes and goes through the activation.
template <class T>
void Autoencoder<T>::finish_codes_grad(Tape<T>& tape) {
    std::ranges::copy(tape.grad(outputs_.code), codes_grad_.begin());
    parallel_for(autoencoders_, [&](std::int64_t a) {
        const int first = first_slot_task_[at(a)], last = first_slot_task_[at(a) + 1];
        add_partials(code_sums_.data() + first * code_size(), last - first, code_size(),
                     codes_grad_.data() + a * code_size());
    });
    if (inputs_.latent_activation == Activation::tanh) {
        for (std::size_t i = 0; i < codes_grad_.size(); ++i) {
            const T code = tape.value(outputs_.code)[i];
            codes_grad_[i] *= 1 - code * code;
        }
    }
    spread_all(codes_grad_.data());
}

/// dC = W_own'^T dD + the same of the ring, and the gradients of the matrices themselves.
template <class T>
void Autoencoder<T>::decoder_to_components() {
    parallel_for(static_cast<std::int64_t>(slot_tasks_.size()), [&](std::int64_t t) {
        const Task& task = slot_tasks_[at(t)];
        Work& work = work_[at(task.autoencoder)];
        Sums& sums = slot_sums_[at(t)];
        const std::int64_t packed_row = std::int64_t{kFeatureDim} * sizes_.padded;
        std::fill_n(work.components_grad.data() + task.begin * packed_row,
                    (task.end - task.begin) * packed_row, T{0});
        kernels<T>().conv_backward(
            neighborhood(task.autoencoder), work.components.data(), work.decoder.data(),
            work.decoder_own.data(), work.decoder_ring.data(), sizes_.padded, task.begin, task.end,
            thread_scratch<T>(kVertexChunk * packed_row), work.components_grad.data(),
            sums.decoder_own.data(), sums.decoder_ring.data());
    });
}

template <class T>
void Autoencoder<T>::encode_backward() {
    parallel_for(static_cast<std::int64_t>(acting_tasks_.size()), [&](std::int64_t t) {
        const Task& task = acting_tasks_[at(t)];
        const int a = task.autoencoder;
        Work& work = work_[at(a)];
        bias_sums_[at(t)] = {};
        kernels<T>().autoencoder.encode_backward(
            lanes_, work.components.data(), sizes_, codes_grad_.data() + a * code_size(),
            across_.data() + a * across_size(), supports_.of(a).acting.data(), task.begin, task.end,
            work.encoded.data(), work.components_grad.data(), bias_sums_[at(t)].data());
    });
}

template <class T>
void Autoencoder<T>::conv_backward(Tape<T>& tape) {
    parallel_for(static_cast<std::int64_t>(slot_tasks_.size()), [&](std::int64_t t) {
        const Task& task = slot_tasks_[at(t)];
        const int a = task.autoencoder;
        Sums& sums = slot_sums_[at(t)];
        kernels<T>().autoencoder.conv_backward(
            rows_of(tape, a), encoder_of(tape, a), work_[at(a)].encoded.data(), task.begin,
            task.end, thread_scratch<T>(kScratchRows * row_size()),
            wants_input_grad_ ? input_grad_of(a) : nullptr, sums.own.data(), sums.ring.data());
    });
}

/// d/db' of the closed form: 2 (count lanes constant - sum of mask sums) (1 - constant^2), less
/// what the error of the sum says about the constants.
template <class T>
void Autoencoder<T>::add_constant_bias_grads(Tape<T>& tape) {
    for (int a = 0; a < autoencoders_; ++a) {
        if (supports_.of(a).is_all()) continue;
        const ConstantRest& rest = rest_[at(a)];
        std::array<double, kFeatureDim> sum_grads{};
        for (std::size_t v = 0; v < sum_grads_.size(); ++v) {
            if (supports_.of(a).slot_of[v] >= 0) continue;
            for (std::size_t c = 0; c < kFeatureDim; ++c) sum_grads[c] += sum_grads_[v][c];
        }
        for (std::size_t c = 0; c < kFeatureDim; ++c) {
            const auto constant = static_cast<double>(work_[at(a)].constant[c]);
            const double slope = rest.count * constant - rest.masked_sums[c];
            tape.grad(inputs_.decoder_bias)[at(a) * kFeatureDim + c] +=
                static_cast<T>((static_cast<double>(factor_of(tape, a)) * slope - sum_grads[c]) *
                               (1 - constant * constant));
        }
    }
}

template <class T>
void Autoencoder<T>::add_component_grads(Tape<T>& tape) {
    T* grads = tape.grad(inputs_.component_weights).data();
    parallel_for(static_cast<std::int64_t>(acting_tasks_.size()), [&](std::int64_t t) {
        const Task& task = acting_tasks_[at(t)];
        const ActiveVertices& active = supports_.of(task.autoencoder);
        const T* packed = work_[at(task.autoencoder)].components_grad.data();
        for (int k = 0; k < sizes_.components; ++k) {
            T* component = grads + (std::int64_t{task.autoencoder} * sizes_.components + k) *
                                       vertices_ * kFeatureDim;
            for (int n = task.begin; n < task.end; ++n) {
                const int s = active.acting[at(n)];
                const T* from = packed + std::int64_t{s} * kFeatureDim * sizes_.padded + k;
                T* to = component + std::int64_t{active.vertices[at(s)]} * kFeatureDim;
                for (int c = 0; c < kFeatureDim; ++c) to[c] += from[c * sizes_.padded];
            }
        }
    });
}

template <class T>
void Autoencoder<T>::add_parameter_grads(Tape<T>& tape) {
    const auto slice = [&]<std::size_t kSize>(Var var, int a) {
        return std::span<T, kSize>(tape.grad(var).data() + at(a) * kSize, kSize);
    };
    for (int a = 0; a < autoencoders_; ++a) {
        const int first = first_slot_task_[at(a)], last = first_slot_task_[at(a) + 1];
        const auto add = [&](auto member, auto target) {
            add_sums(
                first, last, [&](std::size_t t) -> const auto& { return slot_sums_[t].*member; },
                target);
        };
        add(&Sums::own, slice.template operator()<kMatrix>(inputs_.w_own, a));
        add(&Sums::ring, slice.template operator()<kMatrix>(inputs_.w_ring, a));
        add(&Sums::decoder_bias, slice.template operator()<kFeatureDim>(inputs_.decoder_bias, a));
        const auto add_applied = [&](auto member, Var var) {
            Matrix sum{};
            add(member, std::span<T, kMatrix>(sum));
            const auto target = slice.template operator()<kMatrix>(var, a);
            for (std::size_t o = 0; o < kFeatureDim; ++o) {
                for (std::size_t c = 0; c < kFeatureDim; ++c) {
                    const std::size_t i = o * kFeatureDim + c, j = c * kFeatureDim + o;
                    target[inputs_.transposed_decoder ? j : i] += sum[i];
                }
            }
        };
        add_applied(&Sums::decoder_own, inputs_.decoder_w_own);
        add_applied(&Sums::decoder_ring, inputs_.decoder_w_ring);
        add_sums(
            first_acting_task_[at(a)], first_acting_task_[at(a) + 1],
            [&](std::size_t t) -> const auto& { return bias_sums_[t]; },
            slice.template operator()<kFeatureDim>(inputs_.bias, a));
    }
}

template <class T>
void Autoencoder<T>::gather_children(Tape<T>& tape) {
    const int siblings = autoencoders_ / parents_;
    T* source_grad = tape.needs_grad(inputs_.source) ? tape.grad(inputs_.source).data() : nullptr;
    T* mask_grad = inputs_.mask.valid() && tape.needs_grad(inputs_.mask)
                       ? tape.grad(inputs_.mask).data()
                       : nullptr;
    children_.clear();
    for (int a = 0; a < autoencoders_; ++a) {
        children_.push_back({supports_.of(a).slot_of.data(), input_grad_of(a),
                             rows_of(tape, a).mask, mask_grad ? mask_grad + a * vertices_ : nullptr,
                             work_[at(a)].constant.data(), factor_of(tape, a)});
    }
    for_each_chunk(parents_, vertices_, [&](std::int64_t p, std::int64_t, int b, int e) {
        kernels<T>().autoencoder.gather_children(
            tape.value(inputs_.source).data() + p * source_size(),
            moments_.data() + (has_constant_rest_ ? p * vertices_ * (kFeatureDim + 1) : 0),
            lane_mask_.weight.data(), lanes_, children_.data() + p * siblings, siblings, b, e,
            source_grad ? source_grad + p * source_size() : nullptr);
    });
}

template <class T>
T* Autoencoder<T>::input_grad_of(int a) {
    return outputs_.residual.valid() ? work_[at(a)].input_grad.data() : work_[at(a)].error.data();
}

template void Autoencoder<float>::backward(Tape<float>&);
template void Autoencoder<double>::backward(Tape<double>&);
template void Autoencoder<float>::decode_task_backward(Tape<float>&, std::int64_t, float);
template void Autoencoder<double>::decode_task_backward(Tape<double>&, std::int64_t, double);

}  // namespace mscomp::nn
