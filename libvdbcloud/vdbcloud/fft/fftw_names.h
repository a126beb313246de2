#pragma once
// FFTW's two precisions under one set of names. Private to fft/.
#include <fftw3.h>

namespace vdbcloud::fft {

/// FFTW's functions and complex number in the precision `Real`, double or float.
template<typename Real>
struct FftwNames;

#define VDBCLOUD_FFTW_NAMES(Real, fftw)                                                                                \
    template<>                                                                                                         \
    struct FftwNames<Real> {                                                                                           \
        using Complex = fftw##_complex;                                                                                \
        static constexpr auto plan_many_r2c = fftw##_plan_many_dft_r2c;                                                \
        static constexpr auto plan_many_c2r = fftw##_plan_many_dft_c2r;                                                \
        static constexpr auto plan_many_c2c = fftw##_plan_many_dft;                                                    \
        static constexpr auto plan_guru_r2c = fftw##_plan_guru_dft_r2c;                                                \
        static constexpr auto plan_guru_c2r = fftw##_plan_guru_dft_c2r;                                                \
        static constexpr auto plan_guru_r2r = fftw##_plan_guru_r2r;                                                    \
        static constexpr auto run_r2c = fftw##_execute_dft_r2c;                                                        \
        static constexpr auto run_c2r = fftw##_execute_dft_c2r;                                                        \
        static constexpr auto run_c2c = fftw##_execute_dft;                                                            \
        static constexpr auto run_r2r = fftw##_execute_r2r;                                                            \
    }
VDBCLOUD_FFTW_NAMES(double, fftw);
VDBCLOUD_FFTW_NAMES(float, fftwf);
#undef VDBCLOUD_FFTW_NAMES

}  // namespace vdbcloud::fft
