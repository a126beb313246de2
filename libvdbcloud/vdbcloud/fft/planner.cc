#include "vdbcloud/fft/planner.h"

#include <fftw3.h>

namespace vdbcloud::fft {

std::mutex& planner_mutex()
{
    static std::mutex mutex;
    return mutex;
}

void DestroyPlan::operator()(fftw_plan_s* plan) const
{
    std::lock_guard<std::mutex> lock(planner_mutex());
    fftw_destroy_plan(plan);
}

void DestroyPlan::operator()(fftwf_plan_s* plan) const
{
    std::lock_guard<std::mutex> lock(planner_mutex());
    fftwf_destroy_plan(plan);
}

}  // namespace vdbcloud::fft
