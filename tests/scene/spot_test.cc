// Spots: light in a cone, against quadrature and closed forms.
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/scene/light.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

constexpr double degrees = M_PI / 180;

Light spot(double angle, double blend) { return make_spot(Vec3d(-1, 2, 0.5), Vec3d(2, -3, 6), angle, blend); }

const Vec3d axis = Vec3d(2, -3, 6) / 7;
const Vec3d across = Vec3d(3, 2, 0).unit();

TEST(Spot, ShinesAsALampWithinTheConeAndNotBeyond)
{
    const Light light = spot(40, 0.25);  // half angles 20 and 15 degrees
    const auto at = [&](double angle, double r) {
        return light->irradiance(light.place() +
                                 r * (std::cos(angle * degrees) * axis + std::sin(angle * degrees) * across));
    };
    EXPECT_NEAR(at(0, 2), 0.25, 1e-12);
    EXPECT_NEAR(at(14.99, 2), 0.25, 1e-12);
    EXPECT_EQ(at(20.01, 2), 0);
    EXPECT_EQ(at(180, 2), 0);
    const double middle = std::acos((std::cos(15 * degrees) + std::cos(20 * degrees)) / 2) / degrees;
    EXPECT_NEAR(at(middle, 2), 0.125, 1e-12);
    EXPECT_LT(at(19, 2), at(16, 2));
    const Vec3d x = light.place() + Vec3d(3, -2, 6);
    EXPECT_NEAR(light->towards(x).distance, 7, 1e-14);
    EXPECT_LT((light->towards(x).direction - Vec3d(-3, 2, -6) / 7).length(), 1e-15);
    EXPECT_EQ(light->irradiance(light.place()), INFINITY);
    EXPECT_FALSE(light->common_direction());
}

TEST(Spot, MeanIrradianceAlongARayIsItsIntegral)
{
    for (const auto& [angle, blend] : {std::pair{40.0, 0.25}, {40.0, 0.0}, {120.0, 1.0}, {170.0, 0.5}}) {
        const Light light = spot(angle, blend);
        // The last two pass behind the spot, where the angle to the axis goes through 180 degrees.
        const Vec3d back = (0.5 * across - axis).unit(), behind = (-across - 0.5 * axis).unit();
        const WorldRay rays[] = {{light.place() + 2 * axis - 5 * across, across},  // through the axis
                                 {light.place() + 0.4 * axis - 3 * across, (across + 0.2 * axis).unit()},
                                 {light.place() + Vec3d(0.3, 0.4, -2), Vec3d(0, 0, 1)},
                                 {light.place() - axis + 0.5 * across, axis},
                                 {light.place() + 0.4 * behind - 3 * back, back},
                                 {light.place() + 0.4 * behind + 7 * back, -back}};
        for (const WorldRay& ray : rays)
            for (const auto& [t0, t1] : {std::pair{0.0, 10.0}, {3.0, 5.0}, {4.0, 4.5}}) {
                const int n = 200000;
                double sum = 0;
                for (int k = 0; k < n; ++k) sum += light->irradiance(ray.at(t0 + (t1 - t0) * (k + 0.5) / n)) / n;
                // A sharp edge errs by half a step of at most two jumps.
                const double most = 1 / std::pow(0.4 * std::cos(0.2), 2);
                EXPECT_NEAR(light->mean_irradiance(ray, t0, t1), sum, 1e-7 + (blend == 0 ? most / n : 0))
                    << angle << ' ' << blend << ' ' << t0 << ' ' << t1;
            }
    }
}

TEST(Spot, SendsThroughARectangleTheIntegralOfItsIrradiance)
{
    const Vec3d u = across, v = axis.cross(across);
    for (const auto& [angle, blend, error] : {std::tuple{60.0, 0.3, 1e-3}, {60.0, 0.0, 1e-2}, {60.0, 0.1, 1e-3}}) {
        const Light light = spot(angle, blend);
        for (const auto& [aside, half] : {std::pair{0.0, 0.3}, {1.1, 0.3}, {0.9, 0.6}, {3.0, 0.3}}) {
            const Vec3d middle = light.place() + 2 * axis + aside * u;
            const std::array<Vec3d, 4> corner{middle - half * u - half * v, middle + half * u - half * v,
                                              middle + half * u + half * v, middle - half * u + half * v};
            const int n = 600;
            double sum = 0, free = 0;
            for (int i = 0; i < n * n; ++i) {
                const Vec3d x = middle + half * ((2 * (i / n + 0.5) / n - 1) * u + (2 * (i % n + 0.5) / n - 1) * v),
                            from = x - light.place();
                const double cosine = from.dot(axis) / from.length(), area = 4 * half * half / (n * n);
                sum += light->irradiance(x) * cosine * area;
                free += cosine * area / from.lengthSqr();
            }
            EXPECT_NEAR(light->power_through(corner, axis), sum, error * free) << blend << ' ' << aside;
            EXPECT_NEAR(light->power_through(corner, -axis), -sum, error * free) << blend << ' ' << aside;
        }
    }
}

TEST(Spot, SendsItsWholePowerOutOfABoxAboutIt)
{
    for (const auto& [angle, blend] : {std::pair{60.0, 0.3}, {150.0, 0.5}}) {
        const Light light = spot(angle, blend);
        const double expected = light->source()->power;
        const Vec3d centre = light.place() + Vec3d(0.2, -0.3, 0.1), edges(1.3, 0.9, 2);
        double out = 0;
        for (int a = 0; a < 3; ++a)
            for (const double side : {-1.0, 1.0}) {
                Vec3d n(0), u(0), v(0);
                n[a] = side * edges[a] / 2, u[(a + 1) % 3] = edges[(a + 1) % 3] / 2,
                v[(a + 2) % 3] = edges[(a + 2) % 3] / 2;
                const Vec3d c = centre + n;
                out += light->power_through({c - u - v, c + u - v, c + u + v, c - u + v}, n);
            }
        EXPECT_NEAR(out, expected, 1e-3 * 4 * M_PI);
        double sum = 0;  // 2 pi int f dcos
        const int n = 100000;
        for (int k = 0; k < n; ++k) {
            const double c = -1 + 2 * (k + 0.5) / n;
            sum += 4 * M_PI / n * light->irradiance(light.place() + c * axis + std::sqrt(1 - c * c) * across);
        }
        EXPECT_NEAR(expected, sum, 1e-3 * sum);
    }
}

TEST(Spot, RoundTripsThroughMetadataAndText)
{
    const Light light = make_spot(Vec3d(1, 2, 3), Vec3d(0, 0, 2), 30, 0.5, Vec3d(4, 5, 6));
    auto grid = FloatGrid::create();
    write_light(*grid, light);
    const auto back = read_light(*grid, "transmittance_spot");
    ASSERT_TRUE(back);
    EXPECT_TRUE(same_light(*back, light));
    EXPECT_EQ(back->parameters(), light.parameters());
    EXPECT_EQ(lights_text({light}), "spot at 1,2,3 of 4,5,6 direction 0,0,1 angle 30 blend 0.5");
    EXPECT_FALSE(same_place(light, make_spot(Vec3d(1, 2, 3), Vec3d(0, 0.1, 2), 30, 0.5)));
    EXPECT_FALSE(same_place(light, make_spot(Vec3d(1, 2, 3), Vec3d(0, 0, 2), 31, 0.5)));
    EXPECT_THROW(make_spot(Vec3d(0), Vec3d(0)), InputError);
    EXPECT_THROW(make_spot(Vec3d(0), Vec3d(1), 0), InputError);
    EXPECT_THROW(make_spot(Vec3d(0), Vec3d(1), 180), InputError);
    EXPECT_THROW(make_spot(Vec3d(0), Vec3d(1), 30, 1.5), InputError);
    EXPECT_THROW(make_spot(Vec3d(0), Vec3d(NAN, 1, 1)), InputError);
}

}  // namespace
}  // namespace vdbcloud
