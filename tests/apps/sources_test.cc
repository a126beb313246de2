// A result is used only with the grids that it was computed from, and with grids that lie on other voxels.
#include "stages.h"

#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/optics/collided_light.h"

namespace vdbcloud::test {
namespace {

using openvdb::Coord;

/// A vec3s grid that covers the ball, one value everywhere.
Vec3SGridPtr filled(const char* name, const Vec3f& value, int reach = 6)
{
    const auto grid = Vec3SGrid::create(name == std::string(schema::colour) ? Vec3f(1.0f) : Vec3f(0.0f));
    grid->setName(name);
    grid->fill(openvdb::CoordBBox(Coord(-reach), Coord(reach)), value);
    return grid;
}

class Results : public Stages {
protected:
    /// The file with these grids in place of those of the same names.
    std::string with_grids(const std::string& path, const std::vector<GridBasePtr>& grids)
    {
        GridFile file = read_grid_file(path);
        for (const auto& grid : grids) put_grid(file, grid);
        return written(file);
    }
    std::string without(const std::string& path, const std::string& name)
    {
        GridFile file = read_grid_file(path);
        remove_grids(file, [&](const std::string& n) { return n == name; });
        return written(file);
    }
    std::string written(const GridFile& file)
    {
        const std::string path = scratch / ("changed" + std::to_string(++count_) + ".vdb");
        write_grid_file(path, file);
        return path;
    }
    RunResult render(const std::string& input, const Words& options = {})
    {
        return run(test::with({program("render"), input, "-o", scratch / "p.exr", "--resolution", "4"}, options));
    }
    void expect_refused(const std::string& input, const std::string& what, const Words& options = {})
    {
        const RunResult result = render(input, options);
        EXPECT_EQ(result.status, 2) << what;
        EXPECT_NE(result.err.find("another " + what + " than"), std::string::npos) << result.err;
        EXPECT_NE(result.err.find("run p1solve again"), std::string::npos) << result.err;
    }
    std::string lit(const std::vector<GridBasePtr>& others, const Words& options = {})
    {
        const std::string input = write_ball("in.vdb", "density", openvdb::GRID_FOG_VOLUME, others);
        return stage("p1solve", input, "lit" + std::to_string(++count_) + ".vdb", test::with(medium, options));
    }

private:
    int count_ = 0;
};

TEST_F(Results, OfAnotherDensityColourOrEmissionAreRefused)
{
    const auto colour = filled("Cd", Vec3f(0.9f, 0.5f, 0.2f)), glow = filled("emission", Vec3f(0.1f));
    const std::string all = lit({colour, glow}), bare = lit({});
    EXPECT_EQ(render(all).status, 0) << render(all).err;
    EXPECT_EQ(render(bare).status, 0) << render(bare).err;

    expect_refused(with_grids(bare, {colour}), "Cd");
    expect_refused(without(all, "Cd"), "Cd");
    expect_refused(with_grids(all, {filled("Cd", Vec3f(0.9f, 0.5f, 0.25f))}), "Cd");
    expect_refused(with_grids(bare, {glow}), "emission");
    expect_refused(without(all, "emission"), "emission");
    expect_refused(with_grids(all, {filled("emission", Vec3f(0.1f, 0.1f, 0.11f))}), "emission");
    const auto thinner = ball("density", 5);
    thinner->tree().setValue(Coord(0), 0.5f);
    thinner->insertMeta(*read_grid_file(bare).grids[0]);
    expect_refused(with_grids(bare, {thinner}), "density");
}

TEST_F(Results, OfASeriesOfAnotherEmissionAreRefused)
{
    const std::string series = lit({filled("emission", Vec3f(0.1f))}, {"--series", "2", "--galerkin"});
    const Words darker{"--albedo", "0.8"};
    EXPECT_EQ(render(series, darker).status, 0) << render(series, darker).err;
    const RunResult result = render(without(series, "emission"), darker);
    EXPECT_EQ(result.status, 2);
    EXPECT_NE(result.err.find("another density, emission, medium or light"), std::string::npos) << result.err;
}

TEST_F(Results, KeepTheirSourcesWhereAllIsStoredAsHalf)
{
    const auto colour = filled("Cd", Vec3f(0.9f, 0.501f, 0.2f));
    const std::string half = lit({colour}, {"--half"});
    EXPECT_EQ(render(half).status, 0) << render(half).err;
    const std::string passed = stage("illuminate", half, "passed.vdb", {});
    EXPECT_EQ(render(passed).status, 0) << render(passed).err;
}

/// Cd of one value on voxels of another size, place and direction is the same Cd.
TEST_F(Results, DoNotDependOnTheVoxelsOfAUniformColour)
{
    const auto coarse = filled("Cd", Vec3f(0.9f, 0.5f, 0.2f), 40);
    coarse->transform().preRotate(0.4, openvdb::math::Z_AXIS);
    coarse->transform().postScale(0.35);
    coarse->transform().postTranslate(Vec3d(0.3, -0.2, 0.1));
    const GridFile own = read_grid_file(lit({filled("Cd", Vec3f(0.9f, 0.5f, 0.2f))})),
                   other = read_grid_file(lit({coarse}));
    const auto a = fluence(read_collided_light(own, PhaseFunction(), {})),
               b = fluence(read_collided_light(other, PhaseFunction(), {}));
    ASSERT_TRUE(a && b);
    double difference = 0, size = 0;
    for (auto v = a->cbeginValueOn(); v; ++v) {
        difference += double((*v - b->tree().getValue(v.getCoord())).lengthSqr());
        size += double(v->lengthSqr());
    }
    EXPECT_GT(size, 0);
    EXPECT_LT(std::sqrt(difference / size), 1e-5) << "the solver's tolerance is 1e-6";
}

}  // namespace
}  // namespace vdbcloud::test
