# Every kernel beside its plain loop: for the benchmark and for the test of their ratios.
set(MSCOMP_KERNEL_CASES autoencoder_cases.cpp kernel_cases.cpp plain_autoencoder.cpp plain_kernels.cpp
                        plain_spectral.cpp spectral_cases.cpp)
list(TRANSFORM MSCOMP_KERNEL_CASES PREPEND "${CMAKE_CURRENT_LIST_DIR}/")
