#pragma once
// A homogeneous slab over a Lambertian ground: the slab's reference solution and the light that goes between slab and
// ground any number of times.
#include "support/slab_exact.h"

#include <cmath>

namespace vdbcloud::test {

/// Powers per area for a beam of irradiance 1 across itself, so mu0 falls on the slab. With E0 what reaches a black
/// ground, s the slab's reflectance for isotropic light and T its transmittance,
///
///     E = E0 / (1 - A s),   reflected = R0 + A E T,   radiance of the ground = A E / pi
///
/// The slab is alike from both sides.
struct SlabOverGround {
    SlabOverGround(const SlabExact::Options& o, double albedo)
    {
        const SlabExact slab(o);
        irradiance =
            (o.mu0 * std::exp(-o.tau / o.mu0) + slab.transmitted()) / (1 - albedo * slab.reflected_of_isotropic());
        ground = albedo * irradiance / 3.14159265358979323846;
        reflected = slab.reflected() + albedo * irradiance * slab.transmitted_of_isotropic();
        absorbed_by_ground = (1 - albedo) * irradiance;
        absorbed = o.mu0 - reflected - absorbed_by_ground;
        for (size_t k = 0; k < o.view.size(); ++k) {
            // Radiance at mu for isotropic radiance from below is, by reciprocity, the transmittance of a beam at mu.
            SlabExact::Options beam = o;
            beam.mu0 = o.view[k];
            beam.view.clear();
            const double through = SlabExact(beam).transmitted() / beam.mu0 + std::exp(-o.tau / beam.mu0);
            radiance.push_back(slab.emergent_top(int(k)) + ground * through);
        }
    }

    double irradiance, ground, reflected, absorbed_by_ground, absorbed;
    std::vector<double> radiance;  ///< that leaves the top along each view cosine
};

}  // namespace vdbcloud::test
