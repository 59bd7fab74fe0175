// SPDX-License-Identifier: MIT
#include <algorithm>
#include <numeric>

#include "autoencoder.h"
#include "batch.h"
#include "mscomp/base/index.h"

namespace mscomp::nn {

/// As if every vertex acted: what backward left of the decoder's gradient at the slots, the same of
/// the constant output elsewhere, and the encoder evaluated everywhere.
template <class T>
void Autoencoder<T>::full_component_grads(Tape<T>& tape, int a, AlignedVector<T>& grads) const {
    const std::int64_t packed_row = std::int64_t{kFeatureDim} * sizes_.padded;
    const ActiveVertices& active = supports_.of(a);
    const Work& work = work_[at(a)];
    const T* codes = tape.value(outputs_.code).data() + a * code_size();
    const T* codes_grad = codes_grad_.data() + a * code_size();
    AlignedVector<T> decoder_grads(at(vertices_ * packed_row));
    // The gradient of the source has been used up, and is large.
    AlignedVector<T> own_rows(wants_source_grad(tape) ? 0 : at(source_size()));
    T* const rows = wants_source_grad(tape) ? tape.grad(inputs_.source).data() : own_rows.data();
    AlignedVector<T> across(at(across_size()));
    spread_across(codes, across.data());
    std::vector<int> vertices(at(vertices_));
    std::iota(vertices.begin(), vertices.end(), 0);
    ActiveRows<T> all = rows_of(tape, a);
    all.vertices = vertices.data();
    all.ring_offsets = rings_.rings.offsets.data();
    all.ring_slots = rings_.rings.neighbors.data();
    all.inverse_degree = rings_.inverse_degree.data();
    const Neighborhood<T> rings{all.ring_offsets, all.ring_slots, all.inverse_degree};

    for_each_chunk(1, vertices_, [&](std::int64_t, std::int64_t, int b, int e) {
        // Sums that only backward needs.
        AlignedVector<T> unused(at(code_size() + kFeatureDim + row_size()));
        kernels<T>().autoencoder.decode(all, decoder_grads.data(),
                                        tape.value(inputs_.decoder_bias).data() + a * kFeatureDim,
                                        sizes_, codes, lane_mask_.weight.data(), b, e, rows);
        kernels<T>().autoencoder.decode_backward(
            all, decoder_grads.data(), sizes_, across.data(), lane_mask_.weight.data(),
            factor_of(tape, a), rows, nullptr, sum_grad(), b, e, nullptr,
            unused.data() + row_size(), unused.data() + row_size() + code_size(), unused.data());
        for (int v = b; v < e; ++v) {
            const int slot = active.slot_of[at(v)];
            if (slot < 0) continue;
            std::copy_n(work.decoder.data() + slot * packed_row, packed_row,
                        decoder_grads.data() + v * packed_row);
        }
    });
    grads.assign(at(vertices_ * packed_row), T{0});
    for_each_chunk(1, vertices_, [&](std::int64_t, std::int64_t, int b, int e) {
        AlignedVector<T> scratch(at((e - b) * packed_row));
        AlignedVector<T> unused(at(code_size() + 2 * kMatrix + kFeatureDim));
        T* const matrices = unused.data() + code_size();
        kernels<T>().conv_backward(rings, decoder_grads.data(), decoder_grads.data(),
                                   work.decoder_own.data(), work.decoder_ring.data(), sizes_.padded,
                                   b, e, scratch.data(), grads.data(), matrices,
                                   matrices + kMatrix);
        kernels<T>().autoencoder.encode(all, encoder_of(tape, a), decoder_grads.data(), sizes_,
                                        vertices.data(), b, e, rows, unused.data());
        kernels<T>().autoencoder.encode_backward(
            lanes_, decoder_grads.data(), sizes_, codes_grad, across_.data() + a * across_size(),
            vertices.data(), b, e, rows, grads.data(), matrices + 2 * kMatrix);
    });
}

template void Autoencoder<float>::full_component_grads(Tape<float>&, int,
                                                       AlignedVector<float>&) const;
template void Autoencoder<double>::full_component_grads(Tape<double>&, int,
                                                        AlignedVector<double>&) const;

}  // namespace mscomp::nn
