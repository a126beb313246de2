#include "vdbcloud/sim/stages.h"

namespace vdbcloud::sim {

namespace {

constexpr double rk3_stage = 11.0 / 20;

}  // namespace

double longest_stage(TimeScheme scheme) { return scheme == TimeScheme::Rk3 ? rk3_stage : 1; }

const std::vector<Stage>& stages(TimeScheme scheme)
{
    static const std::vector<Stage> euler{{0, 0, 1, 0, 0, 1, 0, 1, 1, 1}};
    static const std::vector<Stage> rk2{{0, 0, 1, 0, 0, 1, 0, 1, 1, 0.5}, {1, 1, 0, 1, 1, 1, 0, 0.5, 1, 0.5}};
    // Four stages of third order, eSSPRK+(4,3) in the terms of Isherwood, Grant and Gottlieb 2018: abscissae 0, 11/20,
    // 11/16, 11/16, so that the factor exp(-t/t_f) of friction is only ever applied forwards, and convex sums of Euler
    // steps of 11/20 dt, so that limited scalars stay bounded.
    constexpr double tau = rk3_stage, middle = 11.0 / 16;
    static const std::vector<Stage> rk3{{0, 0, 1, 0, 0, tau, 0, 1, tau, 89.0 / 363},
                                        {1, 1, 2, tau, tau, middle, 0, 5.0 / 8, tau, 50.0 / 363},
                                        {2, 2, 3, middle, middle, middle, 0, 5.0 / 9, tau, 80.0 / 363},
                                        {3, 1, 0, middle, tau, 1, 260.0 / 1331, 960.0 / 1331, tau, 144.0 / 363}};
    return scheme == TimeScheme::Rk3 ? rk3 : scheme == TimeScheme::Rk2 ? rk2 : euler;
}

}  // namespace vdbcloud::sim
