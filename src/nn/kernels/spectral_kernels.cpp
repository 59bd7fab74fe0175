// SPDX-License-Identifier: MIT
#include "spectral_kernels.h"

#include <string_view>

#include "kernels.h"

namespace mscomp::nn {

template <class T>
const SpectralKernels<T>* find_spectral_kernels(const char* instruction_set) {
    if (find_kernels<T>(instruction_set) == nullptr) return nullptr;
#if defined(__x86_64__)
    const std::string_view wanted = instruction_set;
    if (wanted == "avx2") {
        static const SpectralKernels<T> avx2 = isa_avx2::spectral_table<T>();
        return &avx2;
    }
    if (wanted == "avx512") {
        static const SpectralKernels<T> avx512 = isa_avx512::spectral_table<T>();
        return &avx512;
    }
#endif
    static const SpectralKernels<T> generic = isa_generic::spectral_table<T>();
    return &generic;
}

template <class T>
const SpectralKernels<T>& spectral_kernels() {
    static const SpectralKernels<T>& chosen =
        *find_spectral_kernels<T>(kernels<T>().instruction_set);
    return chosen;
}

template const SpectralKernels<float>* find_spectral_kernels<float>(const char*);
template const SpectralKernels<double>* find_spectral_kernels<double>(const char*);
template const SpectralKernels<float>& spectral_kernels<float>();
template const SpectralKernels<double>& spectral_kernels<double>();

}  // namespace mscomp::nn
