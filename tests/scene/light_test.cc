// How lights travel as metadata of their transmittance grids.
#include "vdbcloud/scene/light.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

Light sun()
{
    Light light;
    light.name = "sun_2";
    light.to_light = Vec3d(0.6, 0.8, 0);
    light.irradiance = Vec3d(1, 2, 3);
    light.angular_diameter = 0.53;
    return light;
}

Light lamp()
{
    Light light;
    light.name = "lamp";
    light.kind = LightKind::Point;
    light.position = Vec3d(-1, 20, 0.5);
    return light;
}

FloatGridPtr grid_with(const Light& light)
{
    auto grid = FloatGrid::create(1.0f);
    grid->setName(transmittance_name(light));
    write_light(*grid, light);
    return grid;
}

TEST(Light, ComesBackAsItWasWritten)
{
    for (const Light& light : {sun(), lamp()}) {
        const auto back = read_light(*grid_with(light), transmittance_name(light));
        ASSERT_TRUE(back.has_value());
        EXPECT_EQ(back->name, light.name);
        EXPECT_EQ(back->kind, light.kind);
        EXPECT_LT((back->to_light - light.to_light).length(), 1e-15);
        EXPECT_EQ(back->position, light.position);
        EXPECT_EQ(back->irradiance, light.irradiance);
        EXPECT_EQ(back->angular_diameter, light.angular_diameter);
    }
}

TEST(Light, DirectionIsWrittenAsAUnitVector)
{
    Light light = sun();
    light.to_light *= 10.0;
    const auto back = read_light(*grid_with(light), transmittance_name(light));
    EXPECT_LT((back->to_light - sun().to_light).length(), 1e-15);
}

TEST(Light, AFileGivesItsLightsInOrderAndPassesOverOtherGrids)
{
    GridFile file;
    file.metadata = std::make_shared<MetaMap>();
    auto density = FloatGrid::create(0.0f);
    density->setName(schema::density);
    auto foreign = FloatGrid::create(1.0f);  // the right name, and nothing known about it
    foreign->setName("transmittance_other");
    file.grids = {grid_with(lamp()), density, foreign, grid_with(sun())};
    const auto lights = lights_of(file);
    ASSERT_EQ(lights.size(), 2u);
    EXPECT_EQ(lights[0].name, "lamp");
    EXPECT_EQ(lights[1].name, "sun_2");
}

TEST(Light, RefusesWhatCannotShine)
{
    const auto refused = [](Light light, auto change) {
        change(light);
        MetaMap metadata;
        EXPECT_THROW(write_light(metadata, light), InputError);
        EXPECT_EQ(metadata.metaCount(), 0u);
    };
    refused(sun(), [](Light& l) { l.name = "the sun"; });
    refused(sun(), [](Light& l) { l.name = ""; });
    refused(sun(), [](Light& l) { l.to_light = Vec3d(0, 0, 0); });
    refused(sun(), [](Light& l) { l.to_light[0] = std::nan(""); });
    refused(sun(), [](Light& l) { l.irradiance[1] = -1; });
    refused(sun(), [](Light& l) { l.angular_diameter = -1; });
    refused(lamp(), [](Light& l) { l.position[2] = INFINITY; });
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
