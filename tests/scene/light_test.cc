// Lights: the field of each kind against closed forms, and how lights travel as metadata.
#include "vdbcloud/scene/light.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/scatter_schema.h"
#include "vdbcloud/grid/schema.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace vdbcloud {
namespace {

Light sun() { return make_sun(Vec3d(0.6, 0.8, 0), Vec3d(1, 2, 3), 0.53, "sun_2"); }

Light lamp() { return make_lamp(Vec3d(-1, 20, 0.5), Vec3d(4, 5, 6)); }

FloatGridPtr grid_with(const Light& light)
{
    auto grid = FloatGrid::create(1.0f);
    grid->setName(transmittance_name(light));
    write_light(*grid, light);
    return grid;
}

/// Corners of the parallelogram about `centre` with these edges.
std::array<Vec3d, 4> face(const Vec3d& centre, const Vec3d& u, const Vec3d& v)
{
    const Vec3d first = centre - u / 2.0 - v / 2.0;
    return {first, first + u, first + u + v, first + v};
}

TEST(Sun, HasOneDirectionAndUnitIrradianceEverywhere)
{
    const Light light = sun();
    for (const Vec3d& x : {Vec3d(0.0), Vec3d(1e6, -3, 2)}) {
        EXPECT_LT((light->towards(x).direction - Vec3d(0.6, 0.8, 0)).length(), 1e-15);
        EXPECT_EQ(light->towards(x).distance, INFINITY);
        EXPECT_EQ(light->irradiance(x), 1);
        EXPECT_EQ(light->mean_irradiance({x, Vec3d(0, 0, 1)}, 2, 7), 1);
    }
    ASSERT_TRUE(light->common_direction());
    EXPECT_LT((*light->common_direction() - Vec3d(0.6, 0.8, 0)).length(), 1e-15);
    EXPECT_FALSE(light->source());
    EXPECT_EQ(light.strength(), Vec3d(1, 2, 3));
}

TEST(Sun, SendsThroughAFaceItsAreaTimesTheCosine)
{
    const Light light = sun();  // travels along (-0.6, -0.8, 0)
    const auto corner = face(Vec3d(5, 6, 7), Vec3d(2, 0, 0), Vec3d(0, 0, 3));
    EXPECT_NEAR(light->power_through(corner, Vec3d(0, 1, 0)), -0.8 * 6, 1e-14);
    EXPECT_NEAR(light->power_through(corner, Vec3d(0, -9, 0)), 0.8 * 6, 1e-14);
}

TEST(Sun, DiscHasItsDiameterAndIsFilledEvenlyAboutItsCentre)
{
    for (const double diameter : {0.53, 40.0, 180.0}) {
        const Light light = make_sun(Vec3d(0.6, 0, 0.8), Vec3d(1.0), diameter);
        const int n = 256;
        const auto parts = light.parts(n);
        ASSERT_EQ(int(parts.size()), n);
        // Over a disc of even radiance 1 - cos is evenly spread between 0 and 1 - cos(diameter / 2): its mean is half
        // of that, its mean square a third. The n points are the midpoints of that range, so the mean is exact and the
        // mean square errs by 1 / (4 n^2) of a third. The largest misses the edge by half a step.
        const double edge = 1 - std::cos(diameter / 2 * M_PI / 180);
        double mean = 0, square = 0, most = 0;
        Vec3d centre(0.0);
        for (const auto& part : parts) {
            const Vec3d to = *part->common_direction();
            const double from_centre = 1 - to.dot(Vec3d(0.6, 0, 0.8));
            mean += from_centre / n;
            square += from_centre * from_centre / n;
            most = std::max(most, from_centre);
            centre += to / n;
            EXPECT_NEAR(to.length(), 1, 1e-14);
            EXPECT_TRUE(part->parts(n).empty());
        }
        EXPECT_NEAR(mean, edge / 2, 1e-13);
        EXPECT_NEAR(square, edge * edge / 3, edge * edge / (4.0 * n * n) + 1e-13);
        EXPECT_NEAR(most, edge * (1 - 0.5 / n), 1e-13);
        // Around the centre the golden angle leaves a discrepancy of order 1 / n of the disc's radius.
        const Vec3d aside = centre - centre.dot(Vec3d(0.6, 0, 0.8)) * Vec3d(0.6, 0, 0.8);
        EXPECT_LT(aside.length(), 2 * std::sin(std::min(diameter / 2, 90.0) * M_PI / 180) / n);
    }
}

TEST(Sun, WithoutDiscIsItsOnlyPart)
{
    for (const Light& light : {make_sun(Vec3d(0, 1, 0)), lamp()}) {
        const auto parts = light.parts(16);
        ASSERT_EQ(parts.size(), 1u);
        EXPECT_EQ(parts[0].get(), &*light);
    }
    EXPECT_EQ(sun().parts(1).size(), 1u);
}

TEST(Lamp, FollowsTheInverseSquare)
{
    const Light light = lamp();
    const Vec3d x = light.place() + Vec3d(2, -3, 6);  // 7 away
    EXPECT_NEAR(light->irradiance(x), 1.0 / 49, 1e-16);
    EXPECT_NEAR(light->towards(x).distance, 7, 1e-14);
    EXPECT_LT((light->towards(x).direction - Vec3d(-2, 3, -6) / 7).length(), 1e-15);
    EXPECT_FALSE(light->common_direction());
    ASSERT_TRUE(light->source());
    EXPECT_EQ(light->source()->position, light.place());
    EXPECT_NEAR(light->source()->power, 4 * M_PI, 1e-14);
    EXPECT_EQ(light->towards(light.place()).distance, 0);
    EXPECT_EQ(light->towards(light.place()).direction, Vec3d(0.0));
    EXPECT_EQ(light->irradiance(light.place()), INFINITY);
}

TEST(Lamp, MeanIrradianceAlongARayIsItsIntegral)
{
    const Light light = lamp();
    const WorldRay ray{light.place() + Vec3d(0.3, 0.4, -2), Vec3d(0, 0, 1)};  // passes at 0.5, foot at t = 2
    for (const auto& [t0, t1] : {std::pair{0.0, 5.0}, {1.9, 2.1}, {4.0, 4.5}}) {
        // Midpoint rule: error (t1 - t0)^2 / (24 n^2) times the second derivative, at most 2 / 0.5^4 = 32.
        const int n = 4000;
        double sum = 0;
        for (int k = 0; k < n; ++k) sum += light->irradiance(ray.at(t0 + (t1 - t0) * (k + 0.5) / n)) / n;
        EXPECT_NEAR(light->mean_irradiance(ray, t0, t1), sum, 32 * (t1 - t0) * (t1 - t0) / (24.0 * n * n) + 1e-14);
    }
    const WorldRay through{light.place() - Vec3d(0, 0, 1), Vec3d(0, 0, 1)};
    // The distance is then a hundredth of the piece: 2 atan(0.5 / 0.01) / (0.01 * 1 * 1).
    EXPECT_NEAR(light->mean_irradiance(through, 0.5, 1.5), 200 * std::atan(50.0), 1e-9);
}

TEST(Lamp, SendsThroughARectangleItsSolidAngle)
{
    const Light light = lamp();
    const double a = 1.5, b = 0.7, d = 2;  // half edges, distance: 4 atan(a b / (d sqrt(a^2 + b^2 + d^2)))
    const double angle = 4 * std::atan(a * b / (d * std::sqrt(a * a + b * b + d * d)));
    for (const double side : {1.0, -1.0}) {
        const auto corner = face(light.place() + Vec3d(0, side * d, 0), Vec3d(2 * a, 0, 0), Vec3d(0, 0, 2 * b));
        EXPECT_NEAR(light->power_through(corner, Vec3d(0, 1, 0)), side * angle, 1e-14);
        EXPECT_NEAR(light->power_through(corner, Vec3d(0, -1, 0)), -side * angle, 1e-14);
        const std::array<Vec3d, 4> mirrored{corner[0], corner[3], corner[2], corner[1]};
        EXPECT_NEAR(light->power_through(mirrored, Vec3d(0, 1, 0)), side * angle, 1e-14) << "either way around";
    }
}

TEST(Lamp, SendsItsWholePowerOutOfAnyBoxAboutIt)
{
    const Light light = lamp();
    const Vec3d centre = light.place() + Vec3d(0.2, -0.3, 0.1), x(1.3, 0, 0), y(0, 0.9, 0), z(0, 0, 2);
    double out = 0;
    for (const double side : {-1.0, 1.0}) {
        out += light->power_through(face(centre + side * x / 2.0, y, z), side * x);
        out += light->power_through(face(centre + side * y / 2.0, z, x), side * y);
        out += light->power_through(face(centre + side * z / 2.0, x, y), side * z);
    }
    EXPECT_NEAR(out, 4 * M_PI, 1e-13);
}

TEST(LightKinds, HaveWordsNamesAndKeysOfTheirOwn)
{
    std::set<std::string> words, names;
    for (const LightKind* kind : light_kinds()) {
        EXPECT_TRUE(words.insert(kind->word).second) << kind->word;
        EXPECT_TRUE(names.insert(kind->name).second) << kind->name;
        ASSERT_FALSE(kind->parameters.empty()) << kind->word;
        EXPECT_EQ(kind->parameters[0].type, LightValue::Colour) << "the strength comes first";
        EXPECT_EQ(kind->parameters[0].otherwise, Vec3d(1));
        std::set<std::string> keys{kind->place_key};
        for (const LightParameter& p : kind->parameters) EXPECT_TRUE(keys.insert(p.key).second) << p.key;
        const Light plain(*kind, kind->name, Vec3d(0, 3, 4));
        EXPECT_EQ(plain.strength(), Vec3d(1.0));
        EXPECT_NEAR(plain.place().length(), kind->at_infinity ? 1 : 5, 1e-15);
    }
    EXPECT_EQ(words, (std::set<std::string>{"directional", "point", "spot"})) << "files hold these words";
}

TEST(Light, RoundTripsThroughMetadata)
{
    for (const Light& light : {sun(), lamp()}) {
        const auto back = read_light(*grid_with(light), transmittance_name(light));
        ASSERT_TRUE(back.has_value());
        EXPECT_EQ(back->name, light.name);
        EXPECT_EQ(&back->kind(), &light.kind());
        EXPECT_LT((back->place() - light.place()).length(), 1e-15);
        EXPECT_EQ(back->parameters(), light.parameters());
        EXPECT_TRUE(same_place(*back, light));
    }
}

TEST(Light, PointsOfADiscShareItsStrengthAndHaveNoExtent)
{
    const Light disc = make_sun(Vec3d(0, 3, 4), Vec3d(1, 2, 3), 20);
    EXPECT_TRUE(disc.has_extent());
    const auto points = points_of({disc, lamp()}, 8);
    ASSERT_EQ(points.size(), 9u);
    Vec3d strength(0.0), centre(0.0);
    for (size_t k = 0; k < 8; ++k) {
        strength += points[k].strength();
        centre += *points[k]->common_direction() / 8.0;
        EXPECT_FALSE(points[k].has_extent());
        // Within the disc, whose edge is 10 degrees from its centre.
        EXPECT_GT(points[k]->common_direction()->dot(disc.place()), std::cos(10 * M_PI / 180));
    }
    EXPECT_LT((strength - Vec3d(1, 2, 3)).length(), 1e-14);
    EXPECT_GT((*points[0]->common_direction() - *points[7]->common_direction()).length(), 0.1);
    EXPECT_LT((centre.unit() - disc.place()).length(), 0.05);
    EXPECT_EQ(points[8].strength(), lamp().strength());
}

TEST(Light, ATextNamesWhatALightIsBesideItsStrength)
{
    EXPECT_EQ(lights_text({make_sun(Vec3d(0, 1, 0))}), "sun towards 0,1,0 of 1,1,1");
    EXPECT_EQ(lights_text({make_sun(Vec3d(0, 1, 0), Vec3d(1, 2, 3), 5)}), "sun towards 0,1,0 of 1,2,3 diameter 5");
}

TEST(Light, WritesTheKeysThatFilesHold)
{
    const auto of_sun = grid_with(sun()), of_lamp = grid_with(lamp());
    EXPECT_EQ(get_text(*of_sun, "vdbcloud:light_kind", ""), "directional");
    EXPECT_LT((get_vector(*of_sun, "vdbcloud:light_to", Vec3d(0.0)) - Vec3d(0.6, 0.8, 0)).length(), 1e-15);
    EXPECT_EQ(get_vector(*of_sun, "vdbcloud:light_irradiance", Vec3d(0.0)), Vec3d(1, 2, 3));
    EXPECT_EQ(get_number(*of_sun, "vdbcloud:light_angular_diameter", 0), 0.53);
    EXPECT_EQ(get_text(*of_lamp, "vdbcloud:light_kind", ""), "point");
    EXPECT_EQ(get_vector(*of_lamp, "vdbcloud:light_position", Vec3d(0.0)), Vec3d(-1, 20, 0.5));
    EXPECT_EQ(get_vector(*of_lamp, "vdbcloud:light_irradiance", Vec3d(0.0)), Vec3d(4, 5, 6));
}

TEST(Light, DirectionBecomesAUnitVector)
{
    EXPECT_LT((make_sun(Vec3d(6, 8, 0)).place() - sun().place()).length(), 1e-15);
}

TEST(Light, AFileGivesItsLightsByNameAndSkipsOtherGrids)
{
    GridFile file;
    file.metadata = std::make_shared<MetaMap>();
    auto density = FloatGrid::create(0.0f);
    density->setName(schema::density);
    auto foreign = FloatGrid::create(1.0f);  // the right name without metadata of ours
    foreign->setName("transmittance_other");
    file.grids = {grid_with(sun()), density, foreign, grid_with(lamp())};
    const auto lights = lights_of(file);
    ASSERT_EQ(lights.size(), 2u);
    EXPECT_EQ(lights[0].name, "lamp");
    EXPECT_EQ(lights[1].name, "sun_2");
}

TEST(Light, SamePlaceIgnoresStrength)
{
    EXPECT_TRUE(same_place(sun(), make_sun(Vec3d(6, 8, 1e-9), Vec3d(7.0), 0.53)));
    EXPECT_FALSE(same_place(sun(), make_sun(Vec3d(6, 8, 1e-6), Vec3d(1, 2, 3), 0.53)));
    EXPECT_FALSE(same_place(sun(), make_sun(Vec3d(6, 8, 0), Vec3d(1, 2, 3), 0.54)));
    EXPECT_TRUE(same_place(lamp(), make_lamp(Vec3d(-1, 20, 0.5 + 1e-8))));
    EXPECT_FALSE(same_place(lamp(), make_lamp(Vec3d(-1, 20, 0.5 + 1e-7))));
    EXPECT_FALSE(same_place(make_sun(Vec3d(0, 1, 0)), make_lamp(Vec3d(0, 1, 0))));
}

TEST(Light, AGridIsFoundByWhatItsLightIs)
{
    const auto in_another_order = [](const std::string& name) { return make_sun(Vec3d(0, 1, 0), Vec3d(2.0), 0, name); };
    GridFile file;
    file.metadata = std::make_shared<MetaMap>();
    const auto mine = grid_with(in_another_order("sun")), other = grid_with(sun());
    file.grids = {mine, other};
    EXPECT_EQ(grid_of_light(file, in_another_order("sun")), mine);
    EXPECT_EQ(grid_of_light(file, in_another_order(sun().name)), mine) << "by another name, which another light has";
    EXPECT_EQ(grid_of_light(file, in_another_order("lamp")), mine);
    const Light brighter = make_sun(Vec3d(0, 1, 0), Vec3d(3.0));
    EXPECT_FALSE(same_light(brighter, in_another_order("sun")));
    EXPECT_EQ(grid_of_light(file, brighter), mine) << "by its name: the strength is not the grid's";
    EXPECT_EQ(grid_of_light(file, make_sun(Vec3d(0, 1, 0), Vec3d(3.0), 0, sun().name)), mine) << "at its place";
    EXPECT_EQ(grid_of_light(file, make_sun(Vec3d(1, 0, 0))), mine) << "by its name alone: another light's";
    EXPECT_EQ(grid_of_light(file, lamp()), nullptr);
    const auto strong = grid_with(make_sun(Vec3d(0, 1, 0), Vec3d(3.0), 0, "sun_3"));
    file.grids.push_back(strong);
    EXPECT_EQ(grid_of_light(file, brighter), strong) << "the light itself, before one of its name at its place";
}

TEST(Light, TextNamesPlaceAndStrengthOfEach)
{
    EXPECT_EQ(lights_text({}), "");
    EXPECT_EQ(lights_text({make_sun(Vec3d(0, 2, 0), Vec3d(1, 2, 3)), lamp()}),
              "lamp at -1,20,0.5 of 4,5,6; sun towards 0,1,0 of 1,2,3");
}

TEST(Light, OfASolutionAreASet)
{
    const Light a = make_sun(Vec3d(0, 1, 0), Vec3d(1, 2, 3)), b = lamp();
    EXPECT_EQ(lights_text({a, b}), lights_text({b, a}));
    MetaMap solution;
    EXPECT_EQ(other_lights(solution, {a}), std::nullopt) << "the metadata names none";
    set_text(solution, schema::lit_by, "sun towards 0,1,0 of 1,2,3; lamp at -1,20,0.5 of 4,5,6");
    EXPECT_EQ(other_lights(solution, {a, b}), std::nullopt);
    EXPECT_EQ(other_lights(solution, {b, a}), std::nullopt);
    // Names follow the order of options: two suns in the other order have each other's.
    const Light c = make_sun(Vec3d(1, 0, 0), Vec3d(1, 2, 3), 0, "sun2");
    MetaMap two;
    set_text(two, schema::lit_by, lights_text({a, c}));
    EXPECT_EQ(other_lights(
                  two, {make_sun(Vec3d(1, 0, 0), Vec3d(1, 2, 3)), make_sun(Vec3d(0, 1, 0), Vec3d(1, 2, 3), 0, "sun2")}),
              std::nullopt);
    EXPECT_NE(other_lights(
                  two, {make_sun(Vec3d(1, 0, 0), Vec3d(1, 2, 3)), make_sun(Vec3d(1, 0, 0), Vec3d(1, 2, 3), 0, "sun2")}),
              std::nullopt);
    for (const auto& others : {std::vector<Light>{a}, {b}, {}, {a, b, b}, {a, make_lamp(Vec3d(-1, 20, 0.6))}})
        EXPECT_EQ(other_lights(solution, others), get_text(solution, schema::lit_by, "")) << lights_text(others);
    set_text(solution, schema::lit_by, "");
    EXPECT_EQ(other_lights(solution, {a}), "") << "lit by a sky alone";
    EXPECT_EQ(other_lights(solution, {}), std::nullopt);
}

TEST(Light, BrightestSunIsTheLargestOfEachChannelAmongLightsAtInfinity)
{
    EXPECT_EQ(brightest_sun({}), Vec3d(0.0));
    EXPECT_EQ(brightest_sun({make_sun(Vec3d(1, 0, 0), Vec3d(1, 5, 2)), make_lamp(Vec3d(0.0), Vec3d(9.0)),
                             make_sun(Vec3d(0, 1, 0), Vec3d(3, 4, 1))}),
              Vec3d(3, 5, 2));
}

TEST(Light, RefusesInadmissibleValues)
{
    const Vec3d y(0, 1, 0), one(1.0);
    EXPECT_THROW(make_sun(y, one, 0, "the sun"), InputError);
    EXPECT_THROW(make_sun(y, one, 0, ""), InputError);
    EXPECT_THROW(make_sun(Vec3d(0.0)), InputError);
    EXPECT_THROW(make_sun(Vec3d(std::nan(""), 1, 0)), InputError);
    EXPECT_THROW(make_sun(y, Vec3d(1, -1, 1)), InputError);
    EXPECT_THROW(make_sun(y, Vec3d(1, 1, INFINITY)), InputError);
    EXPECT_THROW(make_sun(y, one, -1), InputError);
    EXPECT_THROW(make_sun(y, one, 181), InputError);
    EXPECT_THROW(make_lamp(Vec3d(0, 0, INFINITY)), InputError);
    EXPECT_THROW(make_lamp(Vec3d(0.0), Vec3d(-1.0)), InputError);
    Light renamed = sun();
    renamed.name = "the sun";
    MetaMap metadata;
    EXPECT_THROW(write_light(metadata, renamed), InputError);
    EXPECT_EQ(metadata.metaCount(), 0u);
}

TEST(Light, RefusalsNameLightQuantityAndLimits)
{
    const auto said = [](auto make) -> std::string {
        try {
            make();
        } catch (const InputError& e) {
            return e.what();
        }
        return "";
    };
    EXPECT_EQ(said([] { make_lamp(Vec3d(0.0), Vec3d(1, -1, 1), "lamp3"); }),
              "light 'lamp3': intensity [1, -1, 1]: expected finite numbers, 0 or above");
    EXPECT_EQ(said([] { make_sun(Vec3d(0, 1, 0), Vec3d(1.0), 200); }),
              "light 'sun': diameter 200: expected a number in [0, 180]");
}

TEST(Light, RefusesAFileThatContradictsItself)
{
    auto grid = grid_with(sun());
    set_text(*grid, schema::light_kind, "area");
    EXPECT_THROW(read_light(*grid, grid->getName()), InputError);

    auto missing = grid_with(lamp());
    missing->removeMeta(schema::light_position);
    EXPECT_THROW(read_light(*missing, missing->getName()), InputError);
}

}  // namespace
}  // namespace vdbcloud
