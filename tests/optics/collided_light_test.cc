// Collided light in a file: which grids stand for it, and what is read back.
#include "vdbcloud/optics/collided_light.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"

#include <gtest/gtest.h>

#include <set>

namespace vdbcloud::test {
namespace {

const PhaseFunction forward = PhaseFunction::henyey_greenstein(0.6);

FloatGridPtr number(float value)
{
    auto grid = FloatGrid::create(0.0f);
    grid->fill(openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(3)), value);
    return grid;
}

Vec3SGridPtr vectors(const Vec3f& value)
{
    auto grid = Vec3SGrid::create(Vec3f(0.0f));
    grid->fill(openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(3)), value);
    return grid;
}

/// Moments of degree 2 to 3: 1, 2, 3 and so on, times `scale`.
std::vector<FloatGridPtr> moments(float scale)
{
    std::vector<FloatGridPtr> all;
    for (int k = 0; k < 12; ++k) all.push_back(number(scale * float(k + 1)));
    return all;
}

/// One solution for all channels, of degree 3.
CollidedLight one_solution(const PhaseFunction& phase)
{
    CollidedLight light;
    light.phi = number(7);
    light.flux.fill(vectors(Vec3f(1, 2, 3)));
    light.moments.fill(moments(1));
    light.channel_scale = Vec3d(1, 0.5, 0.25);
    light.scaling = delta_scaling(phase, 3);
    name_collided_light(light, [](GridBase& grid) { set_text(grid, schema::lit_by, "a sun"); });
    return light;
}

CollidedLight three_solutions(const PhaseFunction& phase)
{
    CollidedLight light;
    light.phi = vectors(Vec3f(7, 8, 9));
    for (int c = 0; c < 3; ++c) {
        light.flux[size_t(c)] = vectors(Vec3f(1, 2, float(c)));
        light.moments[size_t(c)] = moments(float(c + 1));
    }
    light.flux_limit = 0.3;
    light.scaling = delta_scaling(phase, 3);
    name_collided_light(light, [](GridBase&) {});
    return light;
}

std::set<std::string> names(const GridFile& file)
{
    std::set<std::string> all;
    for (const auto& grid : file.grids) all.insert(grid->getName());
    return all;
}

GridFile empty_file()
{
    GridFile file;
    file.metadata = std::make_shared<MetaMap>();
    return file;
}

float first(const FloatGridPtr& grid) { return grid->tree().getValue(openvdb::Coord(0)); }
Vec3f first(const Vec3SGridPtr& grid) { return grid->tree().getValue(openvdb::Coord(0)); }

TEST(CollidedLight, OfOneSolutionIsOneGridOfEachKind)
{
    GridFile file = empty_file();
    put_collided_light(file, one_solution(forward));
    EXPECT_EQ(file.grids.size(), 14u);
    EXPECT_EQ(names(file).count("flux"), 1u);
    EXPECT_EQ(names(file).count("sh_3m3"), 1u);
    const CollidedLight light = read_collided_light(file, PhaseFunction(), {});
    ASSERT_TRUE(light.phi->isType<FloatGrid>());
    EXPECT_EQ(light.channel_scale, Vec3d(1, 0.5, 0.25));
    EXPECT_EQ(light.flux_limit, 0);
    EXPECT_EQ(light.scaling.moments, delta_scaling(forward, 3).moments);
    EXPECT_EQ(first(fluence(light)), Vec3f(7, 3.5f, 1.75f));
    EXPECT_EQ(first(flux_of(light, 2)), Vec3f(0.25f, 0.5f, 0.75f));
    ASSERT_EQ(light.moments[1].size(), 12u);
    EXPECT_EQ(first(light.moments[1][11]), 12);
    for (const auto& grid : file.grids) EXPECT_EQ(get_text(*grid, schema::lit_by, ""), "a sun") << grid->getName();
}

TEST(CollidedLight, OfThreeSolutionsHasGridsOfEachChannel)
{
    GridFile file = empty_file();
    put_collided_light(file, one_solution(forward));
    put_collided_light(file, three_solutions(forward));
    EXPECT_EQ(file.grids.size(), 1u + 3 * 13) << "the earlier solution is gone";
    const CollidedLight light = read_collided_light(file, PhaseFunction(), {});
    EXPECT_EQ(light.channel_scale, Vec3d(1));
    EXPECT_EQ(light.flux_limit, 0.3);
    EXPECT_EQ(first(fluence(light)), Vec3f(7, 8, 9));
    EXPECT_EQ(first(flux_of(light, 2)), Vec3f(1, 2, 2));
    EXPECT_EQ(first(light.moments[2][0]), 3);
}

TEST(CollidedLight, LeavesOutWhatPicturesDoNotWeigh)
{
    GridFile file = empty_file();
    put_collided_light(file, one_solution(PhaseFunction()));
    EXPECT_EQ(names(file), std::set<std::string>{"phi"}) << "isotropic: neither flux nor moments";
    put_collided_light(file, one_solution(PhaseFunction("rayleigh")));
    EXPECT_EQ(names(file), (std::set<std::string>{"phi", "sh_2m2", "sh_2m1", "sh_20", "sh_2p1", "sh_2p2"}));
    std::string said;
    const CollidedLight light =
        read_collided_light(file, PhaseFunction(), [&](const std::string& text) { said += text; });
    EXPECT_EQ(light.moments[0].size(), 5u);
    EXPECT_EQ(said, "") << "nothing that counts is missing";
    put_collided_light(file, {});
    EXPECT_TRUE(file.grids.empty());
}

TEST(CollidedLight, SaysThatTheFluxIsMissing)
{
    for (const bool one : {true, false}) {
        GridFile file = empty_file();
        put_collided_light(file, one ? one_solution(forward) : three_solutions(forward));
        remove_grids(file, [&](const std::string& name) { return name == (one ? "flux" : "flux_g"); });
        std::string said;
        read_collided_light(file, PhaseFunction(), [&](const std::string& text) { said += text; });
        EXPECT_NE(said.find("scattered to degree 3 and its flux is missing"), std::string::npos) << said;
    }
}

TEST(CollidedLight, SaysWhichDegreesAreMissing)
{
    GridFile file = empty_file();
    put_collided_light(file, one_solution(forward));
    remove_grids(file, [](const std::string& name) { return name == "sh_3p1"; });
    std::string said;
    const CollidedLight light =
        read_collided_light(file, PhaseFunction(), [&](const std::string& text) { said += text; });
    EXPECT_EQ(light.moments[2].size(), 5u);
    EXPECT_NE(said.find("kept to degree 2"), std::string::npos) << said;
}

/// Format 1 shared moments beside phi and fluxes of each channel.
TEST(CollidedLight, IsReadFromFilesOfFormatOne)
{
    GridFile file = empty_file();
    CollidedLight light = three_solutions(forward);
    light.flux_limit = 0;
    put_collided_light(file, light);
    remove_grids(file, [](const std::string& name) { return schema::has_role(name, schema::Role::Moment); });
    size_t k = 0;
    for (int l = 2; l <= 3; ++l)
        for (int m = -l; m <= l; ++m) {
            const auto grid = number(float(++k));
            grid->setName(schema::moment_name(l, m, -1));
            set_vector(*grid, schema::channel_scale, Vec3d(1, 0.5, 0.25));
            put_grid(file, grid);
        }
    const CollidedLight back = read_collided_light(file, PhaseFunction(), {});
    EXPECT_EQ(back.channel_scale, Vec3d(1));
    ASSERT_EQ(back.moments[1].size(), 12u);
    EXPECT_EQ(first(back.moments[0][11]), 12);
    EXPECT_EQ(first(back.moments[1][11]), 6);
    EXPECT_EQ(first(back.moments[2][11]), 3);
    EXPECT_EQ(first(fluence(back)), Vec3f(7, 8, 9));
}

/// A signed distance, for example, as solvers of fluids write it.
TEST(CollidedLight, IsNotAGridOfAnotherProgramThatIsCalledPhi)
{
    GridFile file = empty_file();
    const auto distance = number(1);
    distance->setName("phi");
    put_grid(file, distance);
    EXPECT_FALSE(fluence_grid(file));
    EXPECT_FALSE(read_collided_light(file, PhaseFunction(), {}).phi);
}

TEST(CollidedLight, RefusesPhiWithoutItsScale)
{
    GridFile file = empty_file();
    put_collided_light(file, one_solution(forward));
    find_grid(file, schema::phi)->removeMeta(schema::channel_scale);
    try {
        read_collided_light(file, PhaseFunction(), {});
        ADD_FAILURE() << "accepted";
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("channel_scale' is missing"), std::string::npos) << error.what();
    }
}

TEST(CollidedLight, RefusesGridsOfAnotherType)
{
    GridFile file = empty_file();
    put_collided_light(file, one_solution(forward));
    const auto wrong = number(1);
    wrong->setName("flux");
    put_grid(file, wrong);
    EXPECT_THROW(read_collided_light(file, PhaseFunction(), {}), InputError);
}

}  // namespace
}  // namespace vdbcloud::test
