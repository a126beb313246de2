#include "scatter/sweep_cases.h"

#include "vdbcloud/core/random.h"
#include "vdbcloud/scatter/beam.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace vdbcloud::test {

Result solve(const P1Case& c, const Lit& lit, ClosureOptions options)
{
    const bool layered = c.index.blocks().period()[0] && c.index.blocks().period()[2];
    const bool periodic = c.index.blocks().period() != Vec3i(0, 0, 0);
    const P1Operator coarse(c.index, c.density, c.exposed, {lit.sigma, lit.w0, nullptr, hg(lit.g), true, 1});
    const auto open = closure_exposed(coarse, c.exposed);
    const P1Operator p1(c.index, c.density, open, {lit.sigma, lit.w0, nullptr, hg(lit.g), true, options.degree});
    Multigrid multigrid(p1.stencil()), multigrid1(coarse.stencil());
    const Light sun = make_sun(lit.to_sun);
    SecondMoment closure(p1, options, {1, layered});
    closure.set_sky(lit.sky);
    P1Source first(coarse), base(p1);
    std::vector<float> early, late;
    const double e1 = lit.sigma * coarse.scaling(0).extinction, e = lit.sigma * p1.scaling(0).extinction;
    if (lit.sun > 0) {
        const BeamDepths depths = periodic ? periodic_beam_depths(c.index, c.exposed, c.density, sun)
                                           : beam_depths(c.index, c.exposed, BrickMap(*c.grid), sun);
        add_beam(coarse, depths, e1, {{&first, lit.sun}});
        add_beam(p1, depths, e, {{&base, lit.sun}});
        add_beam_profile(p1, depths, e, {{&base, lit.sun}});
        const auto centre =
            periodic ? periodic_centre_depths(c.index, c.density, sun) : centre_depths(c.index, BrickMap(*c.grid), sun);
        early = beam_fluence(coarse, depths, centre, e1);
        late = beam_fluence(p1, depths, centre, e);
        closure.add_uncollided(sun, late, lit.sun);
    }
    if (lit.sky > 0) {
        add_sky(coarse, lit.sky, first);
        add_sky(p1, lit.sky, base);
    }
    Result r;
    SolveOptions tight;
    tight.tolerance = 1e-8;
    P1Source p1_source = first;
    EXPECT_TRUE(solve_p1(coarse, multigrid1, p1_source, r.phi, tight).converged);
    r.p1_budget = budget(coarse, p1_source, r.phi);
    r.phi_p1 = r.phi;
    closure.start_with_flux(cell_flux(coarse, p1_source, r.phi));
    if (lit.sun > 0) {
        for (size_t n = 0; n < early.size(); ++n) {
            early[n] -= late[n];
            r.phi[n] += lit.sun * early[n];
        }
        closure.start_with(sun, early, lit.sun);
    }
    r.report = closure.run(multigrid, tight, base, r.phi);
    for (const SolveResult& s : r.report.solves) EXPECT_TRUE(s.converged);
    r.budget = budget(p1, base, r.phi);
    r.moments = closure.moments();
    r.uncollided = late;
    r.extinction = e;
    return r;
}

ClosureOptions options(int directions, int iterations, int degree, double change)
{
    ClosureOptions o;
    o.directions = directions;
    o.iterations = iterations;
    o.degree = degree;
    o.change = change;
    return o;
}

double clumps(const Vec3i& p, uint64_t seed)
{
    const double big = uniform(hash_bits(seed, uint64_t(p.x() >> 3), uint64_t(p.y() >> 3), uint64_t(p.z() >> 3)));
    const double small = uniform(hash_bits(seed + 1, uint64_t(p.x()), uint64_t(p.y()), uint64_t(p.z())));
    return big < 0.4 || small < 0.3 ? 0 : std::pow(10.0, 6 * small - 5.5);
}

double billows(const Vec3i& p, int n)
{
    const Vec3d x = (Vec3d(p.x(), p.y(), p.z()) + Vec3d(0.5)) / n - Vec3d(0.5);
    const double value =
        0.35 - std::sqrt(x.dot(x)) + 0.12 * std::sin(17 * x.x() + 3) * std::sin(15 * x.y()) * std::sin(19 * x.z() + 1);
    return value > 0 ? std::min(1.0, 6 * value) : 0;
}

}  // namespace vdbcloud::test
