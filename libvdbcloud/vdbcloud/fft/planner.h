#pragma once
// Plans of FFTW, owned and made safely. FFTW is named in the sources of this folder only, so that it can be
// replaced. Private to fft/.
//
// FFTW's planner and the destruction of plans share global state: both happen under one lock here. Executing
// a plan (fftw_execute_*, on arrays given with the call) needs no lock. Always plan with FFTW_ESTIMATE: a
// measured plan may differ from run to run, and with it the last bits of every result.
#include <cstddef>
#include <memory>
#include <mutex>
#include <stdexcept>

struct fftw_plan_s;   // what fftw_plan points to
struct fftwf_plan_s;  // what fftwf_plan points to

namespace vdbcloud::fft {

std::mutex& planner_mutex();

struct DestroyPlan {
    void operator()(fftw_plan_s*) const;
    void operator()(fftwf_plan_s*) const;
};
template<typename Real>
struct PlanType;
template<>
struct PlanType<double> {
    using type = fftw_plan_s;
};
template<>
struct PlanType<float> {
    using type = fftwf_plan_s;
};

/// An owned plan in the precision `Real` (float or double): `plan.get()` is the fftw_plan or fftwf_plan.
template<typename Real>
using Plan = std::unique_ptr<typename PlanType<Real>::type, DestroyPlan>;

/// The plan that `make()` returns, made under the lock, as in
/// make_plan<double>([&] { return fftw_plan_r2r_1d(...); }).
/// Throws std::logic_error if FFTW has no such plan.
template<typename Real, typename Make>
Plan<Real> make_plan(Make make)
{
    std::lock_guard<std::mutex> lock(planner_mutex());
    Plan<Real> plan(make());
    if (!plan) throw std::logic_error("FFTW has no plan for this transform");
    return plan;
}

/// Bytes to which arrays and rows of arrays are aligned, so that one plan suits every row and every run.
inline constexpr std::size_t alignment = 64;

}  // namespace vdbcloud::fft
