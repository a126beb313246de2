#include "pipelines/solved_puffs.h"

#include "support/reference_clouds.h"
#include "vdbcloud/light/transmittance_grid.h"
#include "vdbcloud/scatter/multiple_scattering.h"

namespace vdbcloud::test {

Scene solved_puffs(double tau, double w0, double g, int iterations)
{
    Scene scene;
    scene.lights = {make_sun(Vec3d(0.3, 1, 0.2))};
    scene.volumes.resize(1);
    Volume& volume = scene.volumes[0];
    volume.density = cloud_of_puffs();
    volume.medium.sigma_t_per_density = Vec3d(extinction_for(*volume.density, tau));
    volume.medium.albedo = Vec3d(w0);
    volume.medium.phase = PhaseFunction::henyey_greenstein(g);
    ScatterOptions options;
    options.closure.iterations = iterations;
    options.reentry_rays = options.line_rays = 0;
    ScatterReport report;
    volume.collided = scatter_p1(*volume.density, nullptr, nullptr, volume.medium, scene.lights, options, {}, report);
    Medium scaled = volume.medium;
    scaled.sigma_t_per_density *= volume.collided.scaling.extinction(w0);
    TransmittanceOptions exact;
    exact.fidelity = Fidelity::Exact;
    exact.error_samples = 0;
    volume.transmittance = {transmittance_grid(*volume.density, scaled, scene.lights[0], exact)};
    return scene;
}

}  // namespace vdbcloud::test
