// What cloudsim reads: a first state, a map of the floor.
#include "cloudsim_run.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/file/io.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <openvdb/tools/LevelSetSphere.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace vdbcloud::test {
namespace {

TEST(CloudsimInput, InitFromAFrameReproducesIt)
{
    const Scratch scratch;
    ASSERT_EQ(cloudsim(with(wet, {"-o", scratch / "first.vdb", "--unpruned"})).status, 0);
    const RunResult r = run({program("cloudsim"), "--cells", "16,12,20", "--minutes", "0", "--init",
                             scratch / "first.vdb", "-o", scratch / "again.vdb", "--unpruned", "--no-forcing"});
    ASSERT_EQ(r.status, 0) << r.err;
    const GridFile a = read_grid_file(scratch / "first.vdb"), b = read_grid_file(scratch / "again.vdb");
    for (const std::string name : {"density", "temperature", "qt"}) {
        const auto x = openvdb::gridPtrCast<FloatGrid>(find_grid(a, name)),
                   y = openvdb::gridPtrCast<FloatGrid>(find_grid(b, name));
        double most = 0;
        for (auto it = x->cbeginValueOn(); it; ++it)
            most = std::max(most, std::abs(double(*it) - double(y->tree().getValue(it.getCoord()))));
        EXPECT_LT(most, name == "temperature" ? 2e-4 : 1e-6) << name;
    }
}

// What a pipe gives can be read once only.
TEST(CloudsimInput, InitIsReadOnce)
{
    const Scratch scratch;
    ASSERT_EQ(cloudsim(with(wet, {"-o", scratch / "first.vdb", "--unpruned"})).status, 0);
    RunOptions there;
    there.folder = scratch.path();
    const auto started = [&](const std::string& init, const std::string& more, const std::string& output) {
        return shell("cloudsim --cells 16,12,20 --minutes 0.5 --every 10s -q --init " + init + " " + more + " -o " +
                         output,
                     there);
    };
    EXPECT_EQ(started("first.vdb", "--checkpoint file.state", "file.vdb").err, "");
    EXPECT_EQ(started("<(cat first.vdb)", "--checkpoint pipe.state", "pipe.vdb").err, "");
    EXPECT_EQ(run({program("vdbdiff"), scratch / "file.vdb", scratch / "pipe.vdb"}).status, 0);
    EXPECT_TRUE(read_text(scratch / "file.state") == read_text(scratch / "pipe.state"));
    // Other air is another run, which a checkpoint refuses.
    EXPECT_EQ(started("first.vdb", "--resume file.state", "file.vdb").status, 0);
    const RunResult other = started("file.vdb", "--resume file.state", "other.vdb");
    EXPECT_EQ(other.status, 2);
    EXPECT_NE(other.err.find("init = "), std::string::npos) << other.err;
}

/// A float grid in metres with one value a voxel of size h, y up, floor at height 0, centred as cloudsim's files are.
FloatGridPtr voxels(const std::string& name, int nx, int ny, int nz, double h,
                    const std::function<float(int, int, int)>& value)
{
    auto grid = FloatGrid::create();
    grid->setName(name);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(h));
    grid->transform().postTranslate(Vec3d(0.5 * (1 - nx) * h, 0.5 * h, 0.5 * (1 - nz) * h));
    auto accessor = grid->getAccessor();
    for (int k = 0; k < nz; ++k)
        for (int j = 0; j < ny; ++j)
            for (int i = 0; i < nx; ++i) accessor.setValueOn({i, j, k}, value(i, j, k));
    return grid;
}

TEST(CloudsimInput, SupersaturatedInitKeepsItsTemperatureAndReportsItsHeat)
{
    const Scratch scratch;
    const auto start = [&](const std::function<float(int, int, int)>& water) {
        GridFile file;
        file.metadata = std::make_shared<MetaMap>();
        file.grids = {voxels("temperature", 8, 8, 8, 100, [](int, int, int) { return 285.f; }),
                      voxels("qt", 8, 8, 8, 100, water)};
        write_grid_file(scratch / "in.vdb", file);
        return run({program("cloudsim"), "--cells", "8", "--spacing", "100", "--minutes", "0", "--no-forcing", "--init",
                    scratch / "in.vdb", "-o", scratch / "out.vdb", "--unpruned", "--json", "-"});
    };
    RunResult r = start([](int, int j, int) { return j == 3 ? -1e-3f : 0.03f; });
    ASSERT_EQ(r.status, 0) << r.err;
    EXPECT_NE(r.err.find("64 cells with negative water were set to 0"), std::string::npos) << r.err;
    const auto report = nlohmann::json::parse(r.out);
    EXPECT_EQ(report["start"]["saturated_cells"], 7 * 64);
    const GridFile out = read_grid_file(scratch / "out.vdb");
    const auto density = openvdb::gridPtrCast<FloatGrid>(find_grid(out, schema::density));
    const auto temperature = openvdb::gridPtrCast<FloatGrid>(find_grid(out, schema::temperature));
    double heat = 0;
    for (auto it = density->cbeginValueOn(); it; ++it) {
        // What was given is what is there: no heat is added by the first condensation.
        EXPECT_NEAR(temperature->tree().getValue(it.getCoord()), 285, 1e-3);
        EXPECT_EQ(*it > 0, it.getCoord().y() != 3);
        heat += 2.5e6 / 1004 * double(*it) / 512;
    }
    EXPECT_NEAR(double(report["start"]["latent_heat"]) / heat, 1, 0.05);  // of theta: over the Exner function, 0.92..1
    r = start([](int i, int j, int k) { return i == 5 && j == 6 && k == 2 ? NAN : 0.03f; });
    EXPECT_EQ(r.status, 1);
    EXPECT_NE(r.err.find("[5, 2, 6]"), std::string::npos) << r.err;  // of the simulation, whose third axis is up
}

/// Temperatures of the lowest cells after half a minute over a floor that is heated by a map.
std::vector<float> heated_by(const std::string& map, const Scratch& scratch)
{
    const RunResult r = run({program("cloudsim"),
                             "--cells",
                             "8,6,8",
                             "--spacing",
                             "100",
                             "--minutes",
                             "0.5",
                             "--every",
                             "30s",
                             "--no-forcing",
                             "--noise",
                             "0",
                             "--noise-water",
                             "0",
                             "--heat-flux",
                             "1",
                             "--floor-map",
                             map,
                             "--buoyancy",
                             "off",
                             "--momentum",
                             "off",
                             "--sounding",
                             "paper",
                             "--unpruned",
                             "-o",
                             scratch / "out.vdb"});
    EXPECT_EQ(r.status, 0) << r.err;
    const GridFile file = read_grid_file(scratch / "out.vdb");
    const auto t = openvdb::gridPtrCast<FloatGrid>(find_grid(file, schema::temperature));
    std::vector<float> floor;
    for (int k = 0; k < 6; ++k)
        for (int i = 0; i < 8; ++i) floor.push_back(t->tree().getValue({i, 0, k}));
    return floor;
}

TEST(CloudsimInput, FloorMapScalesTheHeatFlux)
{
    const Scratch scratch;
    // 4 x 3 pixels, the first row at the far end: bright only in the near left corner and, half as much, in the far
    // right one.
    write_text(scratch / "map.pgm",
               std::string("P5\n4 3\n255\n") + std::string({0, 0, 0, 127, 0, 0, 0, 0, '\xff', 0, 0, 0}));
    const auto picture = heated_by(scratch / "map.pgm", scratch);
    GridFile file;
    file.metadata = std::make_shared<MetaMap>();
    file.grids = {voxels("density", 8, 1, 6, 100, [](int i, int, int k) {
        return k < 2 && i < 2 ? 1.f : k >= 4 && i >= 6 ? 127 / 255.f : 0.f;
    })};
    write_grid_file(scratch / "map.vdb", file);
    const auto grid = heated_by(scratch / "map.vdb", scratch);
    const float cold = picture[3];
    for (int k = 0; k < 6; ++k)
        for (int i = 0; i < 8; ++i) {
            const size_t c = size_t(8 * k + i);
            // 1 K m/s for 30 s into 100 m, times the map.
            const double factor = k < 2 && i < 2 ? 1 : k >= 4 && i >= 6 ? 127 / 255. : 0;
            EXPECT_NEAR(picture[c], double(cold) + 0.3 * factor, 2e-3) << i << ' ' << k;
            EXPECT_NEAR(grid[c], picture[c], 1e-4) << i << ' ' << k;
        }
    // The same map in a file whose z is up, in kilometres.
    FloatGridPtr flat = FloatGrid::create();
    flat->setName("density");
    flat->setTransform(openvdb::math::Transform::createLinearTransform(0.1));
    flat->transform().postTranslate(Vec3d(0.05 * (1 - 8), 0.05 * (1 - 6), 0.05));
    for (auto it = openvdb::gridPtrCast<FloatGrid>(file.grids[0])->cbeginValueOn(); it; ++it)
        flat->tree().setValue({it.getCoord().x(), it.getCoord().z(), 0}, *it);
    file.grids = {flat};
    set_text(*file.metadata, schema::up_axis, "Z");
    set_number(*file.metadata, schema::meters_per_unit, 1000);
    write_grid_file(scratch / "map_z_up.vdb", file);
    EXPECT_EQ(heated_by(scratch / "map_z_up.vdb", scratch), grid);
    // What cannot be a map is refused in a sentence.
    write_text(scratch / "no.png", "no picture");
    for (const std::string map : {"no.png", "none.png", "none.vdb"}) {
        const RunResult r = cloudsim({"-o", scratch / "f%d.vdb", "--heat-flux", "1", "--floor-map", scratch / map});
        EXPECT_EQ(r.status, 1) << map;
        EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
    }
}

void write_grid(const std::string& path, const FloatGrid::Ptr& grid, double metres_per_unit = 1)
{
    GridFile file;
    file.metadata = std::make_shared<MetaMap>();
    set_number(*file.metadata, schema::meters_per_unit, metres_per_unit);
    file.grids = {grid};
    write_grid_file(path, file);
}

/// A fog volume of `value` where the world's x and z are below 0 and y is below 400 m.
void write_mask(const std::string& path, float value, double metres_per_unit = 1)
{
    auto grid = FloatGrid::create();
    grid->setName("smoke");
    grid->setTransform(openvdb::math::Transform::createLinearTransform(100 / metres_per_unit));
    grid->fill(openvdb::CoordBBox({-30, -30, -30}, {0, 4, 0}), value);
    write_grid(path, grid, metres_per_unit);
}

/// Options of air at rest, in eight cells of 400 m along each axis, for ten seconds.
Words still_air(const Scratch& scratch)
{
    write_text(scratch / "calm.txt", "0 300 0 0 0\n");
    return {program("cloudsim"),
            "--preset",
            "smoke",
            "--no-forcing",
            "--momentum",
            "off",
            "--noise",
            "0",
            "--sounding",
            scratch / "calm.txt",
            "--cells",
            "8,8,8",
            "--spacing",
            "400",
            "--every",
            "10s",
            "--unpruned",
            "-o",
            scratch / "out.vdb"};
}

/// Dye in a cell of out.vdb, y up.
double dye_at(const Scratch& scratch, const openvdb::Coord& cell)
{
    const GridFile file = read_grid_file(scratch / "out.vdb");
    return double(openvdb::gridPtrCast<FloatGrid>(find_grid(file, "dye"))->tree().getValue(cell));
}

TEST(CloudsimInput, SourcesFromFilesHaveTheirUnitTheirFramesAndTheirSurface)
{
    const Scratch scratch;
    write_mask(scratch / "mask.vdb", 0.5f);
    write_mask(scratch / "cm.vdb", 0.5f, 0.01);
    write_mask(scratch / "m.1.vdb", 0), write_mask(scratch / "m.2.vdb", 1);
    const auto ball = openvdb::tools::createLevelSetSphere<FloatGrid>(500, openvdb::Vec3f(-600, 200, -600), 50);
    ball->setName("solid");
    write_grid(scratch / "ball.vdb", ball);
    const openvdb::Coord within(2, 0, 2), beyond(5, 0, 5);  // centres at -600, 200, -600 and 600, 200, 600
    const struct {
        const char* source;
        double dye;
    } cases[] = {
        {"mask.vdb; dye=2", 10},
        {"cm.vdb; grid=smoke; dye=2", 10},
        {"mask.vdb; dye=2; start=3; end=5s", 2},
        {"m.%d.vdb; every=10s; dye=2", 10},           // 0 to 1 within the run
        {"m.%d.vdb; every=2s; dye=2; start=1s", 16},  // 1 from the third second on
        {"ball.vdb; dye=2", 20},
        {"sphere; at=-600,200,-600; radius=500; dye=2", 20},
    };
    for (const auto& c : cases) {
        const std::string source = std::string(c.source).substr(0, 6) == "sphere" ? c.source : scratch / c.source;
        const RunResult r = run(with(still_air(scratch), {"--minutes", "0.16666666666666667", "--source", source}), {});
        ASSERT_EQ(r.status, 0) << r.err;
        EXPECT_NEAR(dye_at(scratch, within), c.dye, 1e-4) << source;
        EXPECT_EQ(dye_at(scratch, beyond), 0) << source;
    }
    for (const std::string source : {"mask.vdb; grid=none; dye=2", "none.vdb; dye=1"})
        EXPECT_EQ(run(with(still_air(scratch), {"--minutes", "0.1", "--source", scratch / source}), {}).status, 1);
    const RunResult fog = run(with(still_air(scratch), {"--minutes", "0.1", "--collider", scratch / "mask.vdb"}), {});
    EXPECT_EQ(fog.status, 2);
    EXPECT_NE(fog.err.find("expected a level set"), std::string::npos) << fog.err;
}

TEST(CloudsimInput, OtherSourcesMayHoldFromACheckpointOn)
{
    const Scratch scratch;
    write_mask(scratch / "mask.vdb", 0.5f);
    const Words state{"--checkpoint", scratch / "state", "--resume", scratch / "state"};
    ASSERT_EQ(run(with(still_air(scratch), with(state, {"--minutes", "0.5"})), {}).status, 0);
    const Words more = with(state, {"--minutes", "1", "--source", (scratch / "mask.vdb") + "; dye=2"});
    EXPECT_EQ(run(with(still_air(scratch), more), {}).status, 2);
    const RunResult changed = run(with(still_air(scratch), with(more, {"--change"})), {});
    ASSERT_EQ(changed.status, 0) << changed.err;
    EXPECT_NE(changed.err.find("after 30 s: source = none -> "), std::string::npos) << changed.err;
    EXPECT_NEAR(dye_at(scratch, openvdb::Coord(2, 0, 2)), 30, 1e-3);
    // A body is not: the air of the checkpoint flows where it would stand.
    const Words flowing{program("cloudsim"),
                        "--preset",
                        "smoke",
                        "--cells",
                        "8,8,8",
                        "--spacing",
                        "400",
                        "--every",
                        "10s",
                        "--minutes",
                        "2",
                        "--change",
                        "--collider",
                        "sphere; radius=500",
                        "-o",
                        scratch / "out.vdb"};
    const RunResult body = run(with(flowing, state), {});
    EXPECT_EQ(body.status, 2);
    EXPECT_NE(body.err.find("--init"), std::string::npos) << body.err;
}

}  // namespace
}  // namespace vdbcloud::test
