// SPDX-License-Identifier: MIT
// The table of the kernels of one instruction set; see kernels_impl.h for what has to be defined.
#include "autoencoder_impl.h"
#include "kernels_impl.h"

namespace mscomp::nn::MSCOMP_ISA {

/// The full register where lanes fill it, eight elements of it otherwise (lanes are a multiple of
/// 8).
template <class T>
constexpr int full_width() {
    return MSCOMP_VECTOR_BYTES / static_cast<int>(sizeof(T));
}
template <class T>
using Full = typename VectorOf<T, full_width<T>()>::type;
template <class T>
using Half = typename VectorOf<T, (full_width<T>() > 8 ? 8 : full_width<T>())>::type;

// Chooses the register by the number of lanes: an argument list with `lanes` in it, twice.
#define MSCOMP_BY_LANES(name, ...) \
    (lanes % full_width<T>() == 0 ? name<T, Full<T>>(__VA_ARGS__) : name<T, Half<T>>(__VA_ARGS__))

/// Calls run.operator()<V, U, K>(): registers for lanes and for codes, and the number of components
/// where it is compiled apart (0: any).
template <class T, class Run>
auto with_registers([[maybe_unused]] int lanes, CodeSizes sizes, const Run& run) {
    const auto with_components = [&]<class V, class U>() {
        switch (sizes.components) {
            case 5:
                return run.template operator()<V, U, 5>();
            case 10:
                return run.template operator()<V, U, 10>();
            default:
                return run.template operator()<V, U, 0>();
        }
    };
    if constexpr (full_width<T>() <= 8) {
        return with_components.template operator()<Full<T>, Full<T>>();
    } else {
        const bool full_codes = sizes.padded % full_width<T>() == 0;
        if (lanes % full_width<T>() == 0) {
            return full_codes ? with_components.template operator()<Full<T>, Full<T>>()
                              : with_components.template operator()<Full<T>, Half<T>>();
        }
        return full_codes ? with_components.template operator()<Half<T>, Full<T>>()
                          : with_components.template operator()<Half<T>, Half<T>>();
    }
}

template <class T>
AutoencoderKernels<T> autoencoder_table() {
    AutoencoderKernels<T> t;
    t.encode = [](const ActiveRows<T>& rows, const ConvParameters<T>& conv, const T* components,
                  CodeSizes sizes, const int* acting, int begin, int end, T* f, T* codes) {
        with_registers<T>(rows.lanes, sizes, [&]<class V, class, int K>() {
            encode<T, V, K>(rows, conv, components, sizes, acting, begin, end, f, codes);
        });
    };
    t.decode = [](const ActiveRows<T>& rows, const T* decoder, const T* bias, CodeSizes sizes,
                  const T* codes, const T* lane_weight, int begin, int end, T* e) {
        return with_registers<T>(rows.lanes, sizes, [&]<class V, class, int K>() {
            return decode<T, V, K>(rows, decoder, bias, sizes, codes, lane_weight, begin, end, e);
        });
    };
    t.decode_backward = [](const ActiveRows<T>& rows, T* decoder, CodeSizes sizes,
                           const T* codes_across, const T* lane_weight, T factor, const T* e,
                           const T* output_grad, const T* sum_grad, int begin, int end, T* g,
                           T* codes_grad, T* bias_grad, T* scratch) {
        with_registers<T>(rows.lanes, sizes, [&]<class V, class U, int K>() {
            decode_backward<T, V, U, K>(rows, decoder, sizes, codes_across, lane_weight, factor, e,
                                        output_grad, sum_grad, begin, end, g, codes_grad, bias_grad,
                                        scratch);
        });
    };
    t.encode_backward = [](int lanes, const T* components, CodeSizes sizes, const T* codes_grad,
                           const T* codes_grad_across, const int* acting, int begin, int end, T* f,
                           T* components_grad, T* bias_grad) {
        with_registers<T>(lanes, sizes, [&]<class V, class U, int K>() {
            encode_backward<T, V, U, K>(lanes, components, sizes, codes_grad, codes_grad_across,
                                        acting, begin, end, f, components_grad, bias_grad);
        });
    };
    t.conv_backward = [](const ActiveRows<T>& rows, const ConvParameters<T>& conv, const T* p,
                         int begin, int end, T* scratch, T* input_grad, T* own_grad, T* ring_grad) {
        const int lanes = rows.lanes;
        MSCOMP_BY_LANES(autoencoder_conv_backward, rows, conv, p, begin, end, scratch, input_grad,
                        own_grad, ring_grad);
    };
    t.moments = [](const T* source, const T* lane_weight, int lanes, int begin, int end, T* out) {
        MSCOMP_BY_LANES(moments, source, lane_weight, lanes, begin, end, out);
    };
    t.gather_children = [](const T* source, const T* moments, const T* lane_weight, int lanes,
                           const ChildGradient<T>* children, int count, int begin, int end,
                           T* source_grad) {
        MSCOMP_BY_LANES(gather_children, source, moments, lane_weight, lanes, children, count,
                        begin, end, source_grad);
    };
    return t;
}

template <class T>
Kernels<T> table() {
    Kernels<T> t;
    t.instruction_set = MSCOMP_ISA_NAME;
    t.conv_forward = [](const Neighborhood<T>& rings, const T* x, const T* mp, const T* mn,
                        const T* bias, bool use_tanh, int lanes, int begin, int end, T* y) {
        MSCOMP_BY_LANES(conv_forward, rings, x, mp, mn, bias, use_tanh, lanes, begin, end, y);
    };
    t.conv_backward_activation = [](const T* y, const T* dy, bool use_tanh, int lanes, int begin,
                                    int end, T* dpre, T* bias_grad) {
        MSCOMP_BY_LANES(conv_backward_activation, y, dy, use_tanh, lanes, begin, end, dpre,
                        bias_grad);
    };
    t.conv_backward = [](const Neighborhood<T>& rings, const T* x, const T* dpre, const T* mp,
                         const T* mn, int lanes, int begin, int end, T* scratch, T* dx, T* mp_grad,
                         T* mn_grad) {
        MSCOMP_BY_LANES(conv_backward, rings, x, dpre, mp, mn, lanes, begin, end, scratch, dx,
                        mp_grad, mn_grad);
    };
    t.project = [](const T* weights, std::int64_t stride, int components, const T* rows, int lanes,
                   int begin, int end, T* codes) {
        MSCOMP_BY_LANES(project, weights, stride, components, rows, lanes, begin, end, codes);
    };
    t.expand = [](const T* weights, std::int64_t stride, int components, const T* codes, int lanes,
                  int begin, int end, bool accumulate, T* rows) {
        MSCOMP_BY_LANES(expand, weights, stride, components, codes, lanes, begin, end, accumulate,
                        rows);
    };
    t.outer = [](const T* codes, const T* rows, std::int64_t stride, int components, int lanes,
                 int begin, int end, T* weights_grad) {
        MSCOMP_BY_LANES(outer, codes, rows, stride, components, lanes, begin, end, weights_grad);
    };
    t.squared_error = [](const T* x, const T* y, const T* lane_weight, int lanes, int begin,
                         int end) {
        return MSCOMP_BY_LANES(squared_error, x, y, lane_weight, lanes, begin, end);
    };
    t.squared_error_backward = [](const T* x, const T* y, const T* lane_weight, T factor, int lanes,
                                  int begin, int end, T* dx, T* dy) {
        MSCOMP_BY_LANES(squared_error_backward, x, y, lane_weight, factor, lanes, begin, end, dx,
                        dy);
    };
    t.masked_residual = [](const T* x, const T* y, const T* mask, int lanes, int begin, int end,
                           T* out) {
        MSCOMP_BY_LANES(masked_residual, x, y, mask, lanes, begin, end, out);
    };
    t.masked_residual_backward = [](const T* x, const T* y, const T* mask, const T* dout, int lanes,
                                    int begin, int end, T* dx, T* dy, T* dmask) {
        MSCOMP_BY_LANES(masked_residual_backward, x, y, mask, dout, lanes, begin, end, dx, dy,
                        dmask);
    };
    t.tanh_forward = [](const T* x, std::int64_t count, T* y) {
        tanh_forward<T, Half<T>>(x, count, y);
    };
    t.zero_sum = &zero_sum<T, Full<T>>;
    t.adam = &adam<T>;
    t.autoencoder = autoencoder_table<T>();
    return t;
}

#undef MSCOMP_BY_LANES

template Kernels<float> table<float>();
template Kernels<double> table<double>();

}  // namespace mscomp::nn::MSCOMP_ISA
