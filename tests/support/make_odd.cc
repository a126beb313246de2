// The small files of data/odd. Each has an unusual feature found in files of other programs.
#include "support/make_odd.h"

#include "support/grids.h"

#include "vdbcloud/file/io.h"

#include <openvdb/io/Stream.h>
#include <openvdb/tools/LevelSetSphere.h>

#include <fstream>

namespace vdbcloud::test {

namespace {

using openvdb::Coord;

/// A fog ball within one octant of index space, which keeps files small.
FloatGridPtr fog(const std::string& name, Coord centre = Coord(16)) { return ball(name, 6, centre); }

void write(const std::string& path, std::vector<GridBasePtr> grids)
{
    write_grid_file(path, file_of(std::move(grids)));
}

/// Writes as other programs do: no grid class, local space, a random identifier, no file offsets.
void write_stream(const std::string& path, const GridBasePtr& grid)
{
    std::ofstream stream(path, std::ios::binary);
    openvdb::io::Stream(stream).write(openvdb::GridPtrVec{grid});
}

void tiles(const std::string& path)
{
    const auto grid = fog("density");
    grid->tree().addTile(1, Coord(32, 0, 0), 0.25f, true);
    grid->tree().addTile(2, Coord(128, 0, 0), 0.125f, true);
    grid->setGridClass(openvdb::GRID_UNKNOWN);
    write(path, {grid});
}

void rotated(const std::string& path)
{
    const auto grid = fog("density");
    openvdb::Mat4d matrix = openvdb::Mat4d::identity();
    matrix.preScale(Vec3d(0.5, 0.25, 0.75));
    matrix.postRotate(openvdb::math::Z_AXIS, 0.5);
    matrix.postRotate(openvdb::math::X_AXIS, -0.25);
    matrix.postTranslate(Vec3d(10, -3, 2));
    grid->setTransform(Transform::createLinearTransform(matrix));
    write(path, {grid});
}

void frustum(const std::string& path)
{
    const auto grid = fog("density");
    grid->setTransform(Transform::createFrustumTransform(openvdb::BBoxd(Vec3d(0), Vec3d(32)), 0.5, 10, 1));
    write(path, {grid});
}

/// Three grids at different positions that share one tree; the file stores the tree once.
void three_of_one_name(const std::string& path)
{
    std::vector<GridBasePtr> grids;
    const auto first = fog("density");
    for (int k = 0; k < 3; ++k) {
        const auto grid = openvdb::gridPtrCast<FloatGrid>(first->copyGrid());
        grid->setTransform(Transform::createLinearTransform(0.1));
        grid->transform().postTranslate(Vec3d(3 * k, 0, 0));
        grid->insertMeta("index", openvdb::Int32Metadata(k));
        grids.push_back(grid);
    }
    write(path, grids);
}

void empty(const std::string& path)
{
    const auto velocity = Vec3SGrid::create(Vec3f(0));
    velocity->setGridClass(openvdb::GRID_STAGGERED);
    std::vector<GridBasePtr> grids = {FloatGrid::create(), registered<openvdb::Int32Grid>(), FloatGrid::create(),
                                      velocity};
    const char* names[] = {"density", "obstacles", "shadow", "velocity"};
    for (size_t k = 0; k < grids.size(); ++k) grids[k]->setName(names[k]);
    auto file = file_of(grids);
    file.metadata->insertMeta("other/program/matrix", openvdb::Mat4SMetadata(openvdb::Mat4s::identity()));
    write_grid_file(path, file);
}

void numbers_of_all_types(const std::string& path)
{
    const auto mask = registered<openvdb::BoolGrid>();
    const auto count = registered<openvdb::Int32Grid>();
    const auto position = registered<openvdb::Vec3DGrid>();
    const auto active = registered<openvdb::MaskGrid>();
    count->tree().root().setBackground(-1, /*updateChildNodes=*/false);
    mask->tree().addTile(3, Coord(0), true, false);  // a root tile: child nodes would make the file large
    position->tree().setValue(Coord(1, 2, 3), Vec3d(0.5, 0.25, 1e-9));
    mask->setName("mask"), count->setName("count"), position->setName("position"), active->setName("active");
    write(path, {mask, fog("density"), count, position, active});
}

void components(const std::string& path)
{
    std::vector<GridBasePtr> grids = {fog("density")};
    for (const char* name : {"velocity_x", "velocity_y", "velocity_z"}) {
        const auto grid = FloatGrid::create(float(grids.size()));
        grid->setName(name);
        if (grids.size() == 1) grid->tree().setValue(Coord(16, 16, 16), 5.0f);
        grids.push_back(grid);
    }
    write(path, grids);
}

void local_double(const std::string& path)
{
    const auto grid = registered<openvdb::DoubleGrid>();
    grid->setName("Density");
    const auto values = fog("Density");
    for (auto value = values->cbeginValueOn(); value; ++value) grid->tree().setValue(value.getCoord(), double(*value));
    grid->setIsInWorldSpace(false);
    grid->setGridClass(openvdb::GRID_UNKNOWN);
    grid->setCreator("another program");
    write_stream(path, grid);
}

void wrong_values(const std::string& path, float value)
{
    const auto grid = fog("density");
    for (const int x : {12, 16, 30}) grid->tree().setValue(Coord(x, 16, 16), value);
    write(path, {grid});
}

}  // namespace

void make_odd_files(const std::string& folder)
{
    openvdb::initialize();
    const auto in = [&](const char* name) { return folder + "/" + name; };
    tiles(in("tiles.vdb"));
    rotated(in("rotated.vdb"));
    frustum(in("frustum.vdb"));
    three_of_one_name(in("three_of_one_name.vdb"));
    empty(in("empty.vdb"));
    numbers_of_all_types(in("all_types.vdb"));
    components(in("components.vdb"));
    local_double(in("double.vdb"));
    wrong_values(in("negative.vdb"), -0.5f);
    wrong_values(in("nan.vdb"), NAN);
    write(in("unnamed.vdb"), {fog("")});
    const auto heat = FloatGrid::create(20.0f);
    heat->setName("heat");
    write(in("odd_name.vdb"), {heat, fog("voxel_fog_density")});
    const auto sphere = openvdb::tools::createLevelSetSphere<FloatGrid>(4.0f, Vec3f(10), 1.0f, 2.0f);
    sphere->setName("ls_sphere");
    write(in("level_set.vdb"), {sphere});
    const auto half = fog("density");
    half->setSaveFloatAsHalf(true);
    write(in("half.vdb"), {half});
    write(in("points.vdb"), {point_grid()});
    write(in("no_grids.vdb"), {});
}

}  // namespace vdbcloud::test
