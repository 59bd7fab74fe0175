// SPDX-License-Identifier: MIT
// The kernels of autoencoder_kernels.h; included once per instruction set after kernels_impl.h.
// V is the register for lanes, U that for codes.
#pragma once

#include "autoencoder_kernels.h"
#include "kernels_impl.h"

namespace mscomp::nn::MSCOMP_ISA {

template <class V, class T>
inline V load_input(const ActiveRows<T>& rows, int vertex, T mask, int c, int l) {
    const std::int64_t at = (static_cast<std::int64_t>(vertex) * kDim + c) * rows.lanes + l;
    return mask * load<V>(rows.source + at);
}

template <class T>
inline T mask_of(const ActiveRows<T>& rows, int vertex) {
    return rows.mask ? rows.mask[vertex] : T{1};
}

/// Asks for a row that is about to be read. Rows are too long for the processor to guess.
template <class T>
inline void prefetch_row(const T* row, int lanes) {
    for (int i = 0; i < kDim * lanes; i += 64 / static_cast<int>(sizeof(T))) {
        __builtin_prefetch(row + i);
    }
}

/// The last slot of the ring of s, the one that a sweep in rising order has not seen yet; s itself
/// where the ring is empty.
template <class T>
inline int leading_slot(const ActiveRows<T>& rows, int s) {
    const int last = rows.ring_offsets[s + 1] - 1;
    return last < rows.ring_offsets[s] ? s : rows.ring_slots[last];
}

template <class T>
inline const T* source_row(const ActiveRows<T>& rows, int s) {
    return rows.source + static_cast<std::int64_t>(rows.vertices[s]) * kDim * rows.lanes;
}

/// sums[c] = mean of the input over the ring of slot s.
template <class V, class T>
inline void input_mean(const ActiveRows<T>& rows, int s, int l, V* sums) {
    for (int c = 0; c < kDim; ++c) sums[c] = V{};
    for (int at = rows.ring_offsets[s]; at < rows.ring_offsets[s + 1]; ++at) {
        const int vertex = rows.vertices[rows.ring_slots[at]];
        const T mask = mask_of(rows, vertex);
        for (int c = 0; c < kDim; ++c) sums[c] += load_input<V>(rows, vertex, mask, c, l);
    }
    for (int c = 0; c < kDim; ++c) sums[c] *= rows.inverse_degree[s];
}

/// codes_k += sum_c matrix[c][k] values[c].
template <int K, class V, class T>
inline void add_projection(const T* matrix, CodeSizes sizes, const V* values, int lanes, T* codes) {
    const int components = K > 0 ? K : sizes.components;
    for (int k = 0; k < components; ++k) {
        V even = load<V>(codes + k * lanes), odd = matrix[sizes.padded + k] * values[1];
        for (int c = 0; c < kDim; c += 2) even += matrix[c * sizes.padded + k] * values[c];
        for (int c = 3; c < kDim; c += 2) odd += matrix[c * sizes.padded + k] * values[c];
        store(codes + k * lanes, even + odd);
    }
}

/// values[c] += sum_k matrix[c][k] codes_k.
template <int K, class V, class T>
inline void add_expansion(const T* matrix, CodeSizes sizes, const T* codes, int lanes, V* values) {
    const int components = K > 0 ? K : sizes.components;
    for (int k = 0; k < components; ++k) {
        const V code = load<V>(codes + k * lanes);
        for (int c = 0; c < kDim; ++c) values[c] += matrix[c * sizes.padded + k] * code;
    }
}

/// out[c][k] (+)= sum over lanes of row[c] codes[k].
template <class T, class U>
inline void outer_with_codes(const T* row, const T* across, CodeSizes sizes, int lanes,
                             bool accumulate, T* out) {
    for (int k = 0; k < sizes.padded; k += width<T, U>()) {
        U sums[kDim];
        for (int c = 0; c < kDim; ++c) {
            sums[c] = accumulate ? load<U>(out + c * sizes.padded + k) : U{};
        }
        for (int l = 0; l < lanes; ++l) {
            const U code = load<U>(across + l * sizes.padded + k);
            for (int c = 0; c < kDim; ++c) sums[c] += row[c * lanes + l] * code;
        }
        for (int c = 0; c < kDim; ++c) store(out + c * sizes.padded + k, sums[c]);
    }
}

template <class T, class V, int K>
void encode(const ActiveRows<T>& rows, const ConvParameters<T>& conv, const T* components,
            CodeSizes sizes, const int* acting, int begin, int end, T* f, T* codes) {
    const int lanes = rows.lanes;
    for (int n = begin; n < end; ++n) {
        const int s = acting[n], vertex = rows.vertices[s];
        const std::int64_t first = static_cast<std::int64_t>(s) * kDim;
        if (n + 1 < end) prefetch_row(source_row(rows, leading_slot(rows, acting[n + 1])), lanes);
        for (int l = 0; l < lanes; l += width<T, V>()) {
            V own[kDim], mean[kDim], out[kDim];
            input_mean(rows, s, l, mean);
            const T mask = mask_of(rows, vertex);
            for (int c = 0; c < kDim; ++c) own[c] = load_input<V>(rows, vertex, mask, c, l);
            apply_pair<V, T>(conv.own, conv.ring, conv.bias, own, mean, out);
            for (int c = 0; c < kDim; ++c) {
                out[c] = tanh_of<T>(out[c]);
                store(f + (first + c) * lanes + l, out[c]);
            }
            add_projection<K>(components + first * sizes.padded, sizes, out, lanes, codes + l);
        }
    }
}

template <class T, class V, int K>
double decode(const ActiveRows<T>& rows, const T* decoder, const T* bias, CodeSizes sizes,
              const T* codes, const T* lane_weight, int begin, int end, T* e) {
    const int lanes = rows.lanes;
    double total = 0;
    for (int s = begin; s < end; ++s) {
        const int vertex = rows.vertices[s];
        const T mask = mask_of(rows, vertex);
        const std::int64_t first = static_cast<std::int64_t>(s) * kDim;
        if (s + 1 < end) prefetch_row(source_row(rows, s + 1), lanes);
        V error = {};
        for (int l = 0; l < lanes; l += width<T, V>()) {
            V out[kDim];
            for (int c = 0; c < kDim; ++c) out[c] = splat<V>(bias[c]);
            add_expansion<K>(decoder + first * sizes.padded, sizes, codes + l, lanes, out);
            const V weight = load<V>(lane_weight + l);
            for (int c = 0; c < kDim; ++c) {
                const V difference = load_input<V>(rows, vertex, mask, c, l) - tanh_of<T>(out[c]);
                store(e + (first + c) * lanes + l, difference);
                error += weight * difference * difference;
            }
        }
        total += static_cast<double>(horizontal_sum<T>(error));
    }
    return total;
}

template <class T, class V, class U, int K>
void decode_backward(const ActiveRows<T>& rows, T* decoder, CodeSizes sizes, const T* codes_across,
                     const T* lane_weight, T factor, const T* e, const T* output_grad,
                     const T* sum_grad, int begin, int end, T* g, T* codes_grad, T* bias_grad,
                     T* row) {
    const int lanes = rows.lanes;
    V sums[kDim] = {};
    for (int s = begin; s < end; ++s) {
        const int vertex = rows.vertices[s];
        const T mask = mask_of(rows, vertex);
        const std::int64_t first = static_cast<std::int64_t>(s) * kDim;
        T* matrix = decoder + first * sizes.padded;
        const T* of_sum =
            sum_grad ? sum_grad + static_cast<std::int64_t>(vertex) * kDim * lanes : nullptr;
        if (s + 1 < end) {
            prefetch_row(source_row(rows, s + 1), lanes);
            prefetch_row(e + (first + kDim) * lanes, lanes);
        }
        for (int l = 0; l < lanes; l += width<T, V>()) {
            const V weight = factor * load<V>(lane_weight + l);
            V p[kDim];
            for (int c = 0; c < kDim; ++c) {
                const std::int64_t at = (first + c) * lanes + l;
                const V error = load<V>(e + at);
                const V output = load_input<V>(rows, vertex, mask, c, l) - error;
                V descent = weight * error;
                if (output_grad) descent += load<V>(output_grad + at);
                if (g) store(g + at, descent);
                if (of_sum) descent += load<V>(of_sum + c * lanes + l);
                p[c] = descent * output * output - descent;
                store(row + c * lanes + l, p[c]);
                sums[c] += p[c];
            }
            add_projection<K>(matrix, sizes, p, lanes, codes_grad + l);
        }
        outer_with_codes<T, U>(row, codes_across, sizes, lanes, false, matrix);
    }
    for (int c = 0; c < kDim; ++c) bias_grad[c] += horizontal_sum<T>(sums[c]);
}

template <class T, class V, class U, int K>
void encode_backward(int lanes, const T* components, CodeSizes sizes, const T* codes_grad,
                     const T* codes_grad_across, const int* acting, int begin, int end, T* f,
                     T* components_grad, T* bias_grad) {
    V sums[kDim] = {};
    for (int n = begin; n < end; ++n) {
        const std::int64_t first = static_cast<std::int64_t>(acting[n]) * kDim;
        if (n + 1 < end) {
            prefetch_row(f + static_cast<std::int64_t>(acting[n + 1]) * kDim * lanes, lanes);
        }
        outer_with_codes<T, U>(f + first * lanes, codes_grad_across, sizes, lanes, true,
                               components_grad + first * sizes.padded);
        for (int l = 0; l < lanes; l += width<T, V>()) {
            V p[kDim] = {};
            add_expansion<K>(components + first * sizes.padded, sizes, codes_grad + l, lanes, p);
            for (int c = 0; c < kDim; ++c) {
                T* at = f + (first + c) * lanes + l;
                const V out = load<V>(at);
                p[c] -= p[c] * out * out;
                store(at, p[c]);
                sums[c] += p[c];
            }
        }
    }
    for (int c = 0; c < kDim; ++c) bias_grad[c] += horizontal_sum<T>(sums[c]);
}

template <class T, class V>
void autoencoder_conv_backward(const ActiveRows<T>& rows, const ConvParameters<T>& conv, const T* p,
                               int begin, int end, T* scratch, T* input_grad, T* own_grad,
                               T* ring_grad) {
    constexpr int kBlock = 8;  // rows that the sums over 9 x 9 pairs find in the first cache
    const int lanes = rows.lanes;
    const std::int64_t size = static_cast<std::int64_t>(kDim) * lanes;
    T own_t[kDim * kDim], ring_t[kDim * kDim];
    transpose_9x9(conv.own, own_t);
    transpose_9x9(conv.ring, ring_t);
    T* x = scratch;
    T* q = scratch + kBlock * size;
    V own_sums[kDim * kDim] = {}, ring_sums[kDim * kDim] = {};
    for (int block = begin; block < end; block += kBlock) {
        const int stop = block + kBlock < end ? block + kBlock : end;
        for (int s = block; s < stop; ++s) {
            const int vertex = rows.vertices[s];
            const T mask = mask_of(rows, vertex);
            const std::int64_t in_block = (s - block) * size;
            if (s + 1 < end) {
                prefetch_row(p + leading_slot(rows, s + 1) * size, lanes);
                prefetch_row(source_row(rows, s + 1), lanes);
                if (input_grad) prefetch_row(input_grad + (s + 1) * size, lanes);
            }
            for (int l = 0; l < lanes; l += width<T, V>()) {
                V ring[kDim] = {};
                for (int at = rows.ring_offsets[s]; at < rows.ring_offsets[s + 1]; ++at) {
                    const int j = rows.ring_slots[at];
                    const T weight = rows.inverse_degree[j];
                    const T* other = p + j * size + l;
                    for (int c = 0; c < kDim; ++c) ring[c] += weight * load<V>(other + c * lanes);
                }
                for (int c = 0; c < kDim; ++c) {
                    store(q + in_block + c * lanes + l, ring[c]);
                    store(x + in_block + c * lanes + l, load_input<V>(rows, vertex, mask, c, l));
                }
                if (!input_grad) continue;
                V own[kDim], out[kDim];
                for (int c = 0; c < kDim; ++c) own[c] = load<V>(p + s * size + c * lanes + l);
                apply_pair<V, T>(own_t, ring_t, nullptr, own, ring, out);
                for (int c = 0; c < kDim; ++c) {
                    T* target = input_grad + s * size + c * lanes + l;
                    store(target, load<V>(target) + out[c]);
                }
            }
        }
        add_outer_9x9<T, V>(p + block * size, x, stop - block, lanes, own_sums);
        add_outer_9x9<T, V>(q, x, stop - block, lanes, ring_sums);
    }
    for (int i = 0; i < kDim * kDim; ++i) {
        own_grad[i] += horizontal_sum<T>(own_sums[i]);
        ring_grad[i] += horizontal_sum<T>(ring_sums[i]);
    }
}

template <class T, class V>
void moments(const T* source, const T* lane_weight, int lanes, int begin, int end, T* out) {
    for (int v = begin; v < end; ++v) {
        V squares = {};
        for (int c = 0; c < kDim; ++c) {
            V sum = {};
            const T* row = source + (static_cast<std::int64_t>(v) * kDim + c) * lanes;
            for (int l = 0; l < lanes; l += width<T, V>()) {
                const V weighted = load<V>(lane_weight + l) * load<V>(row + l);
                sum += weighted;
                squares += weighted * load<V>(row + l);
            }
            out[v * (kDim + 1) + c] = horizontal_sum<T>(sum);
        }
        out[v * (kDim + 1) + kDim] = horizontal_sum<T>(squares);
    }
}

/// Where a child has no slot its squared error is sum (mask source - constant)^2.
template <class T>
inline T outside_mask_grad(const ChildGradient<T>& child, const T* moments, T mask) {
    T sum = mask * moments[kDim];
    for (int c = 0; c < kDim; ++c) sum -= child.constant[c] * moments[c];
    return child.factor * sum;
}

template <class T, class V>
void gather_children(const T* source, const T* moments, const T* lane_weight, int lanes,
                     const ChildGradient<T>* children, int count, int begin, int end,
                     T* source_grad) {
    const std::int64_t size = static_cast<std::int64_t>(kDim) * lanes;
    for (int v = begin; v < end; ++v) {
        bool has_outside = false;
        T scale = 0, shift[kDim] = {};
        if (v + 1 < end) {
            prefetch_row(source + (v + 1) * size, lanes);
            if (source_grad) prefetch_row(source_grad + (v + 1) * size, lanes);
            for (int k = 0; k < count; ++k) {
                const int slot = children[k].slot_of[v + 1];
                if (slot >= 0) prefetch_row(children[k].input_grad + slot * size, lanes);
            }
        }
        for (int k = 0; k < count; ++k) {
            const ChildGradient<T>& child = children[k];
            const T mask = child.mask ? child.mask[v] : T{1};
            const int slot = child.slot_of[v];
            if (slot < 0) {
                has_outside = true;
                scale += child.factor * mask * mask;
                for (int c = 0; c < kDim; ++c) {
                    shift[c] += child.factor * mask * child.constant[c];
                }
                if (child.mask_grad) {
                    child.mask_grad[v] += outside_mask_grad(child, moments + v * (kDim + 1), mask);
                }
                continue;
            }
            const T* from = child.input_grad + slot * size;
            V sum = {};
            for (std::int64_t i = 0; i < size; i += width<T, V>()) {
                const V g = load<V>(from + i);
                sum += g * load<V>(source + v * size + i);
                if (source_grad) {
                    T* target = source_grad + v * size + i;
                    store(target, load<V>(target) + mask * g);
                }
            }
            if (child.mask_grad) child.mask_grad[v] += horizontal_sum<T>(sum);
        }
        if (!has_outside || !source_grad) continue;
        for (int c = 0; c < kDim; ++c) {
            for (int l = 0; l < lanes; l += width<T, V>()) {
                const std::int64_t at = v * size + c * lanes + l;
                const V g = load<V>(lane_weight + l) * (scale * load<V>(source + at) - shift[c]);
                store(source_grad + at, load<V>(source_grad + at) + g);
            }
        }
    }
}

}  // namespace mscomp::nn::MSCOMP_ISA
