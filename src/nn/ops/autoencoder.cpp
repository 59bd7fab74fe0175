// SPDX-License-Identifier: MIT
#include "autoencoder.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "batch.h"
#include "mscomp/base/index.h"

namespace mscomp::nn {
namespace {

/// Output of the decoder where nothing acts.
template <class T>
std::array<T, kFeatureDim> constant_output(const T* bias) {
    std::array<T, kFeatureDim> constant;
    for (std::size_t c = 0; c < kFeatureDim; ++c) constant[c] = std::tanh(bias[c]);
    return constant;
}

}  // namespace

template <class T>
Autoencoder<T>::Autoencoder(Tape<T>& tape, const RingTable<T>& rings,
                            const AutoencoderInputs& inputs, const LaneMask<T>& lane_mask,
                            const LevelSupports& supports)
    : rings_(rings),
      inputs_(inputs),
      lane_mask_(lane_mask),
      supports_(supports),
      autoencoders_(static_cast<int>(tape.extents(inputs.component_weights)[0])),
      parents_(static_cast<int>(tape.extents(inputs.source)[0])),
      lanes_(static_cast<int>(tape.extents(inputs.source)[3])),
      vertices_(rings.vertex_count()) {
    assert(supports.count() == autoencoders_ && autoencoders_ % parents_ == 0);
    sizes_.components = static_cast<int>(tape.extents(inputs.component_weights)[1]);
    sizes_.padded = (sizes_.components + 7) / 8 * 8;
    wants_input_grad_ = inputs.joint && (tape.needs_grad(inputs.source) ||
                                         (inputs.mask.valid() && tape.needs_grad(inputs.mask)));
    outputs_.code = tape.result("codes", {autoencoders_, sizes_.components, lanes_}, true);
    outputs_.error = tape.result("autoencoder", {autoencoders_}, true);
    if (inputs.keeps_residual) {
        outputs_.residual =
            tape.result("residual", {autoencoders_, vertices_, kFeatureDim, lanes_}, true);
    }
    if (inputs.keeps_sum_error) outputs_.sum_error = tape.result("sum_error", {1}, true);
    work_.resize(at(autoencoders_));
    codes_grad_.resize(at(autoencoders_ * code_size()));
    across_.assign(at(std::int64_t{autoencoders_} * lanes_ * sizes_.padded), T{0});
}

template <class T>
void Autoencoder<T>::follow_supports() {
    if (revision_ == supports_.revision()) return;
    revision_ = supports_.revision();
    has_constant_rest_ = false;
    slot_tasks_.clear();
    acting_tasks_.clear();
    first_slot_task_.assign(1, 0);
    first_acting_task_.assign(1, 0);
    const auto cut = [](std::vector<Task>& tasks, int a, std::size_t count) {
        const Chunks chunks{static_cast<std::int64_t>(count), kVertexChunk};
        for (std::int64_t i = 0; i < chunks.count(); ++i) {
            tasks.push_back(
                {a, static_cast<int>(chunks.begin(i)), static_cast<int>(chunks.end(i))});
        }
    };
    for (int a = 0; a < autoencoders_; ++a) {
        const ActiveVertices& active = supports_.of(a);
        has_constant_rest_ = has_constant_rest_ || !active.is_all();
        cut(slot_tasks_, a, active.vertices.size());
        cut(acting_tasks_, a, active.acting.size());
        first_slot_task_.push_back(static_cast<int>(slot_tasks_.size()));
        first_acting_task_.push_back(static_cast<int>(acting_tasks_.size()));

        Work& work = work_[at(a)];
        work.inverse_degree.clear();
        for (const int v : active.vertices) {
            work.inverse_degree.push_back(rings_.inverse_degree[at(v)]);
        }
        // Zeros stay behind the last component, and in rows where a slot does not act.
        const std::size_t packed = active.vertices.size() * kFeatureDim * at(sizes_.padded);
        for (auto* each : {&work.components, &work.decoder, &work.components_grad}) {
            each->assign(packed, T{0});
        }
        const std::size_t rows = active.vertices.size() * at(row_size());
        work.encoded.assign(rows, T{0});
        work.error.resize(outputs_.residual.valid() ? 0 : rows);
        work.input_grad.resize(outputs_.residual.valid() && wants_input_grad_ ? rows : 0);
        assert(active.is_all() || !outputs_.residual.valid());
    }
    slot_sums_.resize(slot_tasks_.size());
    bias_sums_.resize(acting_tasks_.size());
    code_sums_.resize(std::max(slot_tasks_.size(), acting_tasks_.size()) * at(code_size()));
    rest_.resize(at(autoencoders_));
    moments_.resize(has_constant_rest_ ? at(parents_ * vertices_ * (kFeatureDim + 1)) : 0);
}

template <class T>
void Autoencoder<T>::forward(Tape<T>& tape) {
    follow_supports();
    fill_shared(tape);
    pack(tape);
    encode(tape);
    decode(tape);
    if (has_constant_rest_) add_constant_errors(tape);
    if (has_sum()) add_up(tape);
}

template <class T>
void Autoencoder<T>::fill_shared(Tape<T>& tape) {
    for (int a = 0; a < autoencoders_; ++a) {
        Work& work = work_[at(a)];
        const auto apply = [&](Var matrices, Matrix& applied) {
            const T* w = tape.value(matrices).data() + a * kMatrix;
            for (int o = 0; o < kFeatureDim; ++o) {
                for (int c = 0; c < kFeatureDim; ++c) {
                    applied[at(o * kFeatureDim + c)] = inputs_.transposed_decoder
                                                           ? w[c * kFeatureDim + o]
                                                           : w[o * kFeatureDim + c];
                }
            }
        };
        apply(inputs_.decoder_w_own, work.decoder_own);
        apply(inputs_.decoder_w_ring, work.decoder_ring);
        work.constant = constant_output(tape.value(inputs_.decoder_bias).data() + a * kFeatureDim);
    }
}

template <class T>
void Autoencoder<T>::pack(Tape<T>& tape) {
    const T* weights = tape.value(inputs_.component_weights).data();
    parallel_for(static_cast<std::int64_t>(slot_tasks_.size()), [&](std::int64_t t) {
        const Task& task = slot_tasks_[at(t)];
        T* packed = work_[at(task.autoencoder)].components.data();
        const int* vertices = supports_.of(task.autoencoder).vertices.data();
        for (int k = 0; k < sizes_.components; ++k) {
            const T* component =
                weights +
                (std::int64_t{task.autoencoder} * sizes_.components + k) * vertices_ * kFeatureDim;
            for (int s = task.begin; s < task.end; ++s) {
                const T* from = component + std::int64_t{vertices[s]} * kFeatureDim;
                T* to = packed + std::int64_t{s} * kFeatureDim * sizes_.padded + k;
                for (int c = 0; c < kFeatureDim; ++c) to[c * sizes_.padded] = from[c];
            }
        }
    });
    apply_decoder();
}

/// D = W_own' C + W_ring' mean C.
template <class T>
void Autoencoder<T>::apply_decoder() {
    parallel_for(static_cast<std::int64_t>(slot_tasks_.size()), [&](std::int64_t t) {
        const Task& task = slot_tasks_[at(t)];
        Work& work = work_[at(task.autoencoder)];
        constexpr T kNoBias[kFeatureDim] = {};
        kernels<T>().conv_forward(neighborhood(task.autoencoder), work.components.data(),
                                  work.decoder_own.data(), work.decoder_ring.data(), kNoBias, false,
                                  sizes_.padded, task.begin, task.end, work.decoder.data());
    });
}

template <class T>
void Autoencoder<T>::encode(Tape<T>& tape) {
    parallel_for(static_cast<std::int64_t>(acting_tasks_.size()), [&](std::int64_t t) {
        const Task& task = acting_tasks_[at(t)];
        const int a = task.autoencoder;
        T* sums = code_sums_.data() + t * code_size();
        std::fill_n(sums, code_size(), T{0});
        kernels<T>().autoencoder.encode(
            rows_of(tape, a), encoder_of(tape, a), work_[at(a)].components.data(), sizes_,
            supports_.of(a).acting.data(), task.begin, task.end, work_[at(a)].encoded.data(), sums);
    });
    const std::span<T> codes = tape.value(outputs_.code);
    std::ranges::fill(codes, T{0});
    parallel_for(autoencoders_, [&](std::int64_t a) {
        const int first = first_acting_task_[at(a)], last = first_acting_task_[at(a) + 1];
        add_partials(code_sums_.data() + first * code_size(), last - first, code_size(),
                     codes.data() + a * code_size());
    });
    if (inputs_.latent_activation == Activation::tanh) {
        kernels<T>().tanh_forward(codes.data(), static_cast<std::int64_t>(codes.size()),
                                  codes.data());
    }
    spread_all(codes.data());
}

template <class T>
void Autoencoder<T>::decode(Tape<T>& tape) {
    const T* codes = tape.value(outputs_.code).data();
    decoded_backward_ = expects_backward_ && !outputs_.residual.valid() && !has_sum();
    parallel_for(static_cast<std::int64_t>(slot_tasks_.size()), [&](std::int64_t t) {
        const Task& task = slot_tasks_[at(t)];
        const int a = task.autoencoder;
        slot_sums_[at(t)].error = kernels<T>().autoencoder.decode(
            rows_of(tape, a), work_[at(a)].decoder.data(),
            tape.value(inputs_.decoder_bias).data() + a * kFeatureDim, sizes_,
            codes + a * code_size(), lane_mask_.weight.data(), task.begin, task.end,
            error_of(tape, a));
        if (decoded_backward_) {
            decode_task_backward(tape, t, factor(static_cast<T>(inputs_.error_weight)));
        }
    });
    for (int a = 0; a < autoencoders_; ++a) {
        double sum = 0;
        for (int t = first_slot_task_[at(a)]; t < first_slot_task_[at(a) + 1]; ++t) {
            sum += slot_sums_[at(t)].error;
        }
        tape.value(outputs_.error)[at(a)] = static_cast<T>(sum / lane_mask_.active);
    }
}

/// sum of (mask source - constant)^2 = sum of mask^2 squares - 2 <constant, sum of mask sums> +
/// count lanes constant^2 over the vertices without a slot, from what backward needs too.
template <class T>
void Autoencoder<T>::add_constant_errors(Tape<T>& tape) {
    for_each_chunk(parents_, vertices_, [&](std::int64_t p, std::int64_t, int b, int e) {
        kernels<T>().autoencoder.moments(tape.value(inputs_.source).data() + p * source_size(),
                                         lane_mask_.weight.data(), lanes_, b, e,
                                         moments_.data() + p * vertices_ * (kFeatureDim + 1));
    });
    parallel_for(autoencoders_, [&](std::int64_t index) {
        const int a = static_cast<int>(index);
        const ActiveVertices& active = supports_.of(a);
        if (active.is_all()) return;
        const ActiveRows<T> rows = rows_of(tape, a);
        ConstantRest& rest = rest_[at(a)];
        rest = {};
        double squares = 0;
        for (std::int64_t v = 0; v < vertices_; ++v) {
            if (active.slot_of[at(v)] >= 0) continue;
            const T* moments = moments_of(a) + v * (kFeatureDim + 1);
            const T mask = rows.mask ? rows.mask[v] : T{1};
            for (std::size_t c = 0; c < kFeatureDim; ++c) {
                rest.masked_sums[c] += static_cast<double>(mask * moments[c]);
            }
            squares += static_cast<double>(mask * mask * moments[kFeatureDim]);
        }
        const auto count = static_cast<double>((vertices_ - active.slot_count()) *
                                               std::int64_t{lane_mask_.active});
        double error = squares;
        for (std::size_t c = 0; c < kFeatureDim; ++c) {
            const auto constant = static_cast<double>(work_[at(a)].constant[c]);
            error += constant * (count * constant - 2 * rest.masked_sums[c]);
        }
        rest.count = count;
        // Rounding of the moments must not make it negative.
        tape.value(outputs_.error)[at(a)] +=
            static_cast<T>(std::max(error, 0.0) / lane_mask_.active);
    });
}

template <class T>
ActiveRows<T> Autoencoder<T>::rows_of(Tape<T>& tape, int a) const {
    const ActiveVertices& active = supports_.of(a);
    const int parent = a / (autoencoders_ / parents_);
    return {active.vertices.data(),
            active.ring_offsets.data(),
            active.ring_slots.data(),
            work_[at(a)].inverse_degree.data(),
            tape.value(inputs_.source).data() + parent * source_size(),
            inputs_.mask.valid() ? tape.value(inputs_.mask).data() + a * vertices_ : nullptr,
            lanes_};
}

template <class T>
Neighborhood<T> Autoencoder<T>::neighborhood(int a) const {
    const ActiveVertices& active = supports_.of(a);
    return {active.ring_offsets.data(), active.ring_slots.data(),
            work_[at(a)].inverse_degree.data()};
}

template <class T>
ConvParameters<T> Autoencoder<T>::encoder_of(Tape<T>& tape, int a) const {
    return {tape.value(inputs_.w_own).data() + a * kMatrix,
            tape.value(inputs_.w_ring).data() + a * kMatrix,
            tape.value(inputs_.bias).data() + a * kFeatureDim};
}

template <class T>
T* Autoencoder<T>::error_of(Tape<T>& tape, int a) {
    return outputs_.residual.valid() ? tape.value(outputs_.residual).data() + a * source_size()
                                     : work_[at(a)].error.data();
}

template <class T>
const T* Autoencoder<T>::moments_of(int a) const {
    const int parent = a / (autoencoders_ / parents_);
    return moments_.data() + parent * vertices_ * (kFeatureDim + 1);
}

template <class T>
void Autoencoder<T>::spread_across(const T* codes, T* across) const {
    for (int k = 0; k < sizes_.components; ++k) {
        for (int l = 0; l < lanes_; ++l) {
            across[l * sizes_.padded + k] = codes[k * lanes_ + l];
        }
    }
}

template <class T>
void Autoencoder<T>::spread_all(const T* codes) {
    for (int a = 0; a < autoencoders_; ++a) {
        spread_across(codes + a * code_size(), across_.data() + a * across_size());
    }
}

template <class T>
void Autoencoder<T>::add_output(Tape<T>& tape, int a, std::span<T> rows) const {
    for_each_chunk(1, vertices_, [&](std::int64_t, std::int64_t, int b, int e) {
        add_output(tape, a, T{1}, b, e, rows.data());
    });
}

template <class T>
void Autoencoder<T>::add_output(Tape<T>& tape, int a, T sign, int begin, int end, T* rows) const {
    const ActiveVertices& active = supports_.of(a);
    const ActiveRows<T> input = rows_of(tape, a);
    const T* errors = outputs_.residual.valid()
                          ? tape.value(outputs_.residual).data() + a * source_size()
                          : work_[at(a)].error.data();
    for (int v = begin; v < end; ++v) {
        const int slot = active.slot_of[at(v)];
        T* sum = rows + v * row_size();
        if (slot < 0) {
            for (int c = 0; c < kFeatureDim; ++c) {
                const T constant = sign * work_[at(a)].constant[at(c)];
                for (int l = 0; l < lanes_ && constant != 0; ++l) sum[c * lanes_ + l] += constant;
            }
            continue;
        }
        const T mask = input.mask ? input.mask[v] : T{1};
        const T* source = input.source + v * row_size();
        const T* error = errors + slot * row_size();
        for (std::int64_t i = 0; i < row_size(); ++i)
            sum[i] += sign * (mask * source[i] - error[i]);
    }
}

template <class T>
AutoencoderOutputs autoencoder(Tape<T>& tape, const RingTable<T>& rings,
                               const AutoencoderInputs& inputs, const LaneMask<T>& lane_mask,
                               const LevelSupports& supports) {
    auto op = std::make_unique<Autoencoder<T>>(tape, rings, inputs, lane_mask, supports);
    const AutoencoderOutputs outputs = op->outputs();
    tape.record(std::move(op));
    return outputs;
}

template class Autoencoder<float>;
template class Autoencoder<double>;
template AutoencoderOutputs autoencoder(Tape<float>&, const RingTable<float>&,
                                        const AutoencoderInputs&, const LaneMask<float>&,
                                        const LevelSupports&);
template AutoencoderOutputs autoencoder(Tape<double>&, const RingTable<double>&,
                                        const AutoencoderInputs&, const LaneMask<double>&,
                                        const LevelSupports&);

}  // namespace mscomp::nn
