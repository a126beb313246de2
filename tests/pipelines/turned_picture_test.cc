// A cloud with colours of its own, turned in the world together with its light and its camera: paths, paths that end in
// the solution, and the picture without noise see the same.
#include "pipelines/pictures.h"
#include "support/reference_clouds.h"
#include "support/size.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/light/transmittance_grid.h"
#include "vdbcloud/render/certificate.h"
#include "vdbcloud/render/path.h"
#include "vdbcloud/scatter/multiple_scattering.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

using namespace test;

using Rotation = openvdb::math::Mat3<double>;

const Rotation upright = Rotation::identity();
const Rotation aslant = openvdb::math::rotation<Rotation>(Vec3d(1, 2, -0.7).unit(), 0.8);

/// The cloud of puffs with Cd on coarser voxels, which do not line up with those of the density.
Scene coloured_puffs(const Rotation& turn, double g, bool tinted = true)
{
    Scene scene;
    scene.lights = {make_sun(turn * Vec3d(0.3, 1, 0.2))};
    scene.volumes.resize(1);
    Volume& volume = scene.volumes[0];
    volume.density = cloud_of_puffs();
    volume.medium.sigma_t_per_density = Vec3d(extinction_for(*volume.density, 15));
    volume.medium.albedo = Vec3d(0.99);
    volume.medium.phase = PhaseFunction::henyey_greenstein(g);
    volume.colour = Vec3SGrid::create(Vec3f(0.5f));
    volume.colour->transform().preTranslate(Vec3d(-0.03, 0.02, -0.01));
    volume.colour->transform().preScale(0.11);
    for (int k = 0; k < 1000 && tinted; ++k)
        volume.colour->tree().setValueOn(openvdb::Coord(k / 100, k / 10 % 10, k % 10),
                                         Vec3f(float(0.6 + 0.4 * std::sin(0.7 * (k / 100)))));
    openvdb::math::Mat4d turned;
    turned.setIdentity();
    turned.setMat3(turn.transpose());  // OpenVDB multiplies from the left
    for (Transform* transform : {&volume.density->transform(), &volume.colour->transform()})
        transform->postMult(turned);
    ScatterOptions options;
    options.up = turn * Vec3d(0, 1, 0);
    options.delta = false;
    options.closure.iterations = 3;
    options.reentry_rays = options.line_rays = 0;
    ScatterReport report;
    volume.collided =
        scatter_p1(*volume.density, volume.colour.get(), nullptr, volume.medium, scene.lights, options, {}, report);
    TransmittanceOptions exact;
    exact.fidelity = Fidelity::Exact;
    exact.error_samples = 0;
    volume.transmittance = {transmittance_grid(*volume.density, volume.medium, scene.lights[0], exact)};
    return scene;
}

/// The view from the side, red light.
template<typename Trace>
Picture seen(const Rotation& turn, int samples, uint64_t seed, const Trace& trace)
{
    Picture picture;
    for (int i = 0; i < pixels; ++i)
        for (int j = 0; j < pixels; ++j) {
            double sum = 0, squares = 0;
            for (int k = 0; k < samples; ++k) {
                PathRandom random(seed, i, j, uint64_t(k));
                const double u = random.next(), v = random.next();
                const WorldRay ray = views[1].ray((i + u) / pixels, (j + v) / pixels);
                const double l = trace(WorldRay{turn * ray.origin, turn * ray.direction}, random);
                sum += l;
                squares += l * l;
            }
            Mean& block = picture[size_t(i / edge * (pixels / edge) + j / edge)];
            block.value += sum / samples / (edge * edge);
            block.deviation =
                std::hypot(block.deviation,
                           std::sqrt(std::max(0.0, squares / samples - std::pow(sum / samples, 2)) / (samples - 1)) /
                               (edge * edge));
        }
    return picture;
}

double radiance(const RayResult& r) { return r.direct[0][0] + r.multiple[0]; }

Picture by_paths(const Rotation& turn, const Scene& scene, int vertices, uint64_t seed)
{
    const PathScene prepared(scene);
    const PathEndScene end(scene);
    PathTracer trace(prepared, vertices > 0 ? &end : nullptr, vertices);
    RayResult r;
    return seen(turn, sized(50, 1000), seed, [&](const WorldRay& ray, PathRandom& random) {
        trace(ray, random, r);
        return radiance(r);
    });
}

Picture by_cells(const Rotation& turn, const Scene& scene)
{
    const PreparedScene prepared(scene, {});
    const auto march = make_cells_integrator(prepared, {});
    RayResult r;
    return seen(turn, 16, 1, [&](const WorldRay& ray, PathRandom&) {
        (*march)(ray, r);
        return radiance(r);
    });
}

/// Mean over the blocks of the squared difference, in squared standard deviations: 1 for two measurements of one
/// picture.
double chi_squared(const Picture& a, const Picture& b)
{
    double sum = 0;
    for (size_t k = 0; k < blocks; ++k)
        sum += std::pow(a[k].value - b[k].value, 2) / (std::pow(a[k].deviation, 2) + std::pow(b[k].deviation, 2));
    return sum / blocks;
}

/// What a certificate says of the mean of the picture from the side.
Interval certified(const Rotation& turn, const Scene& scene)
{
    Camera camera;
    camera.projection = Projection::Orthographic;
    camera.position = turn * (Vec3d(0.5) - 2 * views[1].direction);
    camera.look_at = turn * Vec3d(0.5);
    camera.up = turn * Vec3d(0, 1, 0);
    camera.width = 1;
    ImageSize size;
    size.width = size.height = pixels;
    auto layers = render_layers(scene, {});
    for (const LayerSpec& layer : certificate_layers(scene, false)) layers.push_back(layer);
    SamplingOptions sampling;
    sampling.samples = 16;
    Film film(size, layers);
    render_image(film, scene, {camera, size}, sampling, {});
    CertifyOptions options;
    options.passes = sized(40, 400);
    return certify(film, scene, {camera, size}, sampling, options).bias;
}

TEST(TurnedPicture, OfAColouredCloudIsTheSameByAllMethods)
{
    for (const auto& [g, most] : {std::pair(0.0, 0.02), {0.5, 0.05}}) {
        SCOPED_TRACE(g);
        const Scene straight = coloured_puffs(upright, g), turned = coloured_puffs(aslant, g);
        const Picture cells = by_cells(upright, straight);
        EXPECT_LT(rms(by_cells(aslant, turned), cells).value, 1e-8);
        const Picture ends = by_paths(upright, straight, 3, 1), whole = by_paths(upright, straight, 0, 2);
        // Nine blocks: 2.7 is three standard deviations, and less than 0.1 would be samples that are not independent.
        for (const double x : {chi_squared(ends, by_paths(aslant, turned, 3, 3)),
                               chi_squared(whole, by_paths(aslant, turned, 0, 4)), chi_squared(ends, whole)}) {
            EXPECT_LT(x, 2.7);
            EXPECT_GT(x, 0.1);
        }
        const double error = mean(cells).value / mean(whole).value - 1,
                     noise = mean(whole).deviation / mean(whole).value;
        EXPECT_LT(std::abs(error), most + 3 * noise) << "voxels of up to 1.6 mean free paths, and degree 1 at g = 0.5";
        for (const Interval& found : {certified(upright, straight), certified(aslant, turned)}) {
            EXPECT_LT(found.low, error + 3 * noise);
            EXPECT_GT(found.high, error - 3 * noise);
            EXPECT_LT(found.high - found.low, 0.1);
        }
        EXPECT_GT(mean(by_cells(upright, coloured_puffs(upright, g, false))).value, 1.15 * mean(cells).value)
            << "the colours darken the cloud";
    }
}

}  // namespace
}  // namespace vdbcloud
