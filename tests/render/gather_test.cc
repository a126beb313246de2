// Each term of what a ray gathers, by every integrator, against closed forms in a medium whose collided light is the
// same everywhere.
#include "vdbcloud/optics/spherical_harmonics.h"
#include "vdbcloud/render/media.h"
#include "vdbcloud/scatter/multiple_scattering.h"

#include "support/fields.h"
#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

using openvdb::Coord;

Vec3SGridPtr constant(const Vec3f& value)
{
    auto grid = Vec3SGrid::create(value);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(0.1));
    grid->denseFill(openvdb::CoordBBox(Coord(-2), Coord(17)), value);
    return grid;
}

FloatGridPtr constant(float value)
{
    auto grid = FloatGrid::create(value);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(0.1));
    grid->denseFill(openvdb::CoordBBox(Coord(-2), Coord(17)), value);
    return grid;
}

/// A box of density that varies along x, seen along an odd direction.
struct Gather {
    explicit Gather(const PhaseFunction& phase, int degree, double w0 = 0.9)
    {
        scene.volumes.resize(1);
        Volume& v = scene.volumes[0];
        v.density = test::box(Vec3i(16, 16, 16), 0.1, [](const Coord& c) { return 1 + 0.05 * c[0]; });
        v.medium.sigma_t_per_density = Vec3d(0.8);
        v.medium.albedo = Vec3d(w0);
        v.medium.phase = phase;
        v.collided.scaling = delta_scaling(phase, degree);
        v.collided.phi = constant(Vec3f(0));
    }
    const DeltaScaling& scaling() const { return scene.volumes[0].collided.scaling; }
    Volume& volume() { return scene.volumes[0]; }

    WorldRay ray() const
    {
        const Vec3d direction = Vec3d(0.4, 0.7, -0.5).unit();
        return {Vec3d(0.75) - 5.0 * direction, direction};
    }
    Vec3d to_eye() const { return -ray().direction; }

    RayResult seen(Integrator kind) const
    {
        IntegratorOptions options;
        options.kind = kind;
        options.shadow_rays = true;
        options.tolerance = 1e-7;
        options.step = 0.02;
        const PreparedScene prepared(scene, options);
        const auto integrate = kind == Integrator::Cells     ? make_cells_integrator(prepared, options)
                               : kind == Integrator::Romberg ? make_romberg_integrator(prepared, options)
                                                             : make_steps_integrator(prepared, options);
        RayResult result;
        (*integrate)(ray(), result);
        return result;
    }

    /// Light `source` that is scattered towards the eye per scattering coefficient at every point: w0' source (1 - T').
    Vec3d gathered(const Vec3d& source, const Vec3d& true_tau) const
    {
        const double w0 = scene.volumes[0].medium.albedo[0];
        Vec3d sum;
        for (int c = 0; c < 3; ++c)
            sum[c] = scaling().albedo(w0) * source[c] * -std::expm1(-scaling().extinction(w0) * true_tau[c]);
        return sum;
    }

    Scene scene;
};

class EachIntegrator : public testing::TestWithParam<Integrator> {
protected:
    /// Midpoint steps of a fiftieth of a voxel and a Romberg tolerance of 1e-7; cells extrapolate to fourth order.
    void expect_gathered(const Gather& gather, const Vec3d& source)
    {
        const RayResult result = gather.seen(GetParam());
        const Vec3d expected = gather.gathered(source, result.true_tau);
        ASSERT_GT(result.true_tau[0], 1);
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(result.multiple[c], expected[c], 2e-4 * std::abs(expected[c]) + 1e-9) << c;
    }
};

TEST_P(EachIntegrator, GathersPhiInTheScaledMedium)
{
    Gather gather(PhaseFunction::henyey_greenstein(0.8), 1);
    gather.volume().collided.phi = constant(Vec3f(1, 2, 3));
    ASSERT_GT(gather.scaling().delta_f, 0.6);
    expect_gathered(gather, Vec3d(1, 2, 3) / (4 * pi));
}

TEST_P(EachIntegrator, GathersThreeTimesTheScaledMeanCosineTimesTheFluxTowardsTheEye)
{
    for (double g : {0.8, -0.4}) {
        Gather gather(PhaseFunction::henyey_greenstein(g), 1);
        const Vec3f flux[3] = {Vec3f(1, 0, 0), Vec3f(0.2f, 0.3f, -0.4f), Vec3f(0, 0, 2)};
        Vec3d source;
        for (int c = 0; c < 3; ++c) {
            gather.volume().collided.flux[size_t(c)] = constant(flux[c]);
            const double scaled_g = g > 0 ? g / (1 + g) : g;
            source[c] = 3 * scaled_g * gather.to_eye().dot(Vec3d(flux[c])) / (4 * pi);
        }
        expect_gathered(gather, source);
    }
}

TEST_P(EachIntegrator, GathersOneSolutionOfAllChannelsTimesTheScaleOfEach)
{
    Gather gather(PhaseFunction::henyey_greenstein(0.8), 1);
    CollidedLight& light = gather.volume().collided;
    const Vec3f flux(0.2f, 0.3f, -0.4f);
    light.phi = constant(3.0f);
    light.flux.fill(constant(flux));
    light.channel_scale = Vec3d(1, 0.5, 2);
    const double along = gather.to_eye().dot(Vec3d(flux));
    expect_gathered(gather, (3 + 3 * (0.8 / 1.8) * along) / (4 * pi) * Vec3d(1, 0.5, 2));
}

TEST_P(EachIntegrator, ShortensAFluxThatIsLongerThanItsLimitTimesPhi)
{
    // Fluxes of length 1 along and against the ray, and one within the limit of each channel's phi.
    Gather gather(PhaseFunction::henyey_greenstein(0.8), 1);
    CollidedLight& light = gather.volume().collided;
    light.flux_limit = 0.25;
    light.phi = constant(Vec3f(2, 0, 8));
    const Vec3d along = gather.to_eye();
    light.flux = {constant(Vec3f(along)), constant(Vec3f(along)), constant(Vec3f(-along))};
    const double m = 3 * 0.8 / 1.8;
    expect_gathered(gather, Vec3d(2 + m * 0.25 * 2, 0, 8 - m) / (4 * pi));
}

TEST_P(EachIntegrator, GathersEachHigherMomentByItsScaledMomentAndScale)
{
    const int degree = 3, count = harmonic_count(degree) - harmonic_count(1);
    const PhaseFunction phase("double-henyey-greenstein", {0.85, 0.1, 0.7});
    double y[16];
    for (int k = 0; k < count; k += 3) {
        Gather gather(phase, degree);
        gather.volume().collided.phi = constant(0.0f);  // one solution for all channels
        auto& [red, green, blue] = gather.volume().collided.moments;
        for (int n = 0; n < count; ++n) red.push_back(constant(n == k ? 1.5f : 0.0f));
        green = blue = red;
        gather.volume().collided.channel_scale = Vec3d(1, 0.5, 2);
        evaluate_harmonics(degree, gather.to_eye(), y);
        const int l = k + 4 < 9 ? 2 : 3;
        const double f = phase.moment(4), moment = (phase.moment(l) - f) / (1 - f);
        ASSERT_GT(f, 0);
        expect_gathered(gather, 1.5 * moment * y[k + 4] * Vec3d(1, 0.5, 2));
    }
}

TEST_P(EachIntegrator, GathersMomentsOfEachChannelFromItsOwnGrids)
{
    Gather gather(PhaseFunction("rayleigh"), 2);
    for (int c = 0; c < 3; ++c)
        for (int n = 0; n < 5; ++n)
            gather.volume().collided.moments[size_t(c)].push_back(constant(n == 2 ? float(c + 1) : 0.0f));
    double y[9];
    evaluate_harmonics(2, gather.to_eye(), y);
    expect_gathered(gather, 0.1 * y[harmonic(2, 0)] * Vec3d(1, 2, 3));
}

TEST_P(EachIntegrator, ScattersASunOnceByTheTruePhaseFunctionInTheScaledMedium)
{
    // Without phi there is no peak correction. Seen straight against the sun every point has the depth of the whole
    // ray: w0 p(1) E tau exp(-tau).
    const PhaseFunction phase("hg-draine", {8});
    Gather gather(phase, 1, 0.8);
    gather.volume().collided.phi = nullptr;
    gather.scene.lights = {make_sun(gather.ray().direction, Vec3d(1, 2, 3))};
    const RayResult result = gather.seen(GetParam());
    const double tau = result.true_tau[0], scaled = gather.scaling().extinction(0.8) * tau;
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(result.direct[0][c] / (0.8 * phase(1) * (c + 1) * tau * std::exp(-scaled)), 1, 2e-4) << c;
    EXPECT_NEAR(result.tau[0], scaled, 1e-4 * scaled);
}

INSTANTIATE_TEST_SUITE_P(Integrators, EachIntegrator,
                         testing::Values(Integrator::Cells, Integrator::Romberg, Integrator::Steps),
                         [](const auto& test) { return std::string(name(test.param)); });

TEST(Gather, CorrectsThePeakByTheUnscaledScatteringDepth)
{
    // Against the sun the depth by way of any point is tau' of the whole ray, and the argument of the peak is
    // w0 tau' / (1 - w0 f) = w0 tau.
    for (const PhaseFunction& phase : {PhaseFunction::henyey_greenstein(0.85), PhaseFunction("hg-draine", {20})}) {
        const double w0 = 0.9;
        Gather gather(phase, 1, w0);
        gather.scene.lights = {make_sun(gather.ray().direction)};
        const RayResult result = gather.seen(Integrator::Cells);
        const double tau = result.true_tau[0], scaled = gather.scaling().extinction(w0) * tau;
        const double ratio = ForwardPeak(phase, gather.scaling())(1, w0 * tau);
        ASSERT_GT(std::abs(ForwardPeak(phase, gather.scaling())(1, w0 * scaled) / ratio - 1), 0.02);
        EXPECT_NEAR(result.direct[0][0] / (w0 * phase(1) * tau * std::exp(-scaled) * ratio), 1, 1e-4) << phase.text();
    }
}

TEST(Gather, ScattersALampOnceByItsInverseSquare)
{
    // A lamp on the ray's side, in a medium so thin that it attenuates by less than 1e-5: w0 sigma_t int p I / r^2 dt
    // by midpoints.
    const PhaseFunction phase = PhaseFunction::henyey_greenstein(0.4);
    Gather gather(phase, 1);
    gather.volume().collided.phi = nullptr;
    gather.volume().collided.scaling = DeltaScaling();
    gather.volume().medium.sigma_t_per_density = Vec3d(1e-5);
    const Vec3d position = Vec3d(1.5, 0.3, 1.1);
    gather.scene.lights = {make_lamp(position, Vec3d(2))};
    const WorldRay ray = gather.ray();
    const BrickMap bricks(*gather.volume().density);
    double expected = 0;
    const int n = 40000;
    for (int k = 0; k < n; ++k) {
        const double t = 10 * (k + 0.5) / n;
        const Vec3d to = position - ray.at(t);
        const double density = bricks.sample(bricks.index_from_world().point(ray.at(t)));
        expected += 0.9 * 1e-5 * density * phase(to.dot(ray.direction) / to.length()) * 2 / to.lengthSqr() * 10 / n;
    }
    for (Integrator kind : {Integrator::Cells, Integrator::Steps})
        EXPECT_NEAR(gather.seen(kind).direct[0][0] / expected, 1, 2e-3) << name(kind);
}

TEST(Gather, OfARayleighFurnaceIsTheSkyBehindIt)
{
    // In a white medium under a sky of radiance L every moment but phi is 0 and the picture is L (1 - T) + L T.
    const double L = 0.7;
    Gather gather(PhaseFunction("rayleigh"), 2, 1);
    ScatterOptions options;
    options.sky = Sky::constant(Vec3d(L));
    options.closure.iterations = 10;
    options.closure.directions = 64;
    options.closure.degree = 2;
    options.closure.change = 1e-7;
    options.solve.tolerance = 1e-9;
    options.reentry_rays = 0;
    ScatterReport report;
    const CollidedLight fields =
        scatter_p1(*gather.volume().density, nullptr, nullptr, gather.volume().medium, {}, options, {}, report);
    ASSERT_EQ(fields.scaling.moments.size(), 3u);
    EXPECT_NEAR(fields.scaling.moments[2], 0.1, 1e-15);
    ASSERT_EQ(fields.moments[0].size(), 5u);
    gather.volume().collided = fields;
    const RayResult result = gather.seen(Integrator::Cells);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(result.multiple[c] + L * std::exp(-result.tau[c]), L, 1e-4 * L);
}

TEST(PreparedScene, RefusesMomentsBeyondTheDegreeOfTheScaling)
{
    Gather gather(PhaseFunction("rayleigh"), 1);
    for (auto& moments : gather.volume().collided.moments)
        for (int n = 0; n < 5; ++n) moments.push_back(constant(0.0f));
    EXPECT_THROW(gather.seen(Integrator::Cells), InputError);
}

}  // namespace
}  // namespace vdbcloud
