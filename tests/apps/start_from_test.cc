// Sweeps that start from the frame before: one iteration is then as good as three, and light moves with its medium.
#include "in_folder.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/file/io.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/optics/collided_light.h"

#include <gtest/gtest.h>
#include <openvdb/tools/Morphology.h>

#include <cmath>

namespace vdbcloud::test {
namespace {

class StartFrom : public InFolder<StartFrom> {
public:
    static constexpr const char* made =
        "fractalgen -q --size 24 --seed 4 -o cloud.vdb && illuminate -q cloud.vdb --extinction 15 --albedo 0.999 --g "
        "0.85 "
        "--sun 0.5,1,0.3 -o lit.vdb && "
        "p1solve -q lit.vdb --degree 3 --change 1e-9 --iterations 1 -o one.vdb && "
        "p1solve -q lit.vdb --degree 3 --change 1e-9 --iterations 3 -o three.vdb && "
        "p1solve -q lit.vdb --degree 3 --change 1e-9 --iterations 30 -o all.vdb && "
        "p1solve -q lit.vdb --degree 3 --change 1e-9 --iterations 1 --start-from three.vdb -o started.vdb";

protected:
    static Vec3SGridPtr phi_of(const std::string& name,
                               const PhaseFunction& phase = PhaseFunction::henyey_greenstein(0.85))
    {
        return fluence(read_collided_light(read_grid_file(*folder_ / name), phase, {}));
    }
    /// Root mean square of a - b over that of b, b moved by `shift` voxels.
    static double difference(const Vec3SGrid& a, const Vec3SGrid& b, const openvdb::Coord& shift = openvdb::Coord(0))
    {
        double sum = 0, size = 0;
        for (auto v = b.cbeginValueOn(); v; ++v) {
            const auto d = Vec3d(a.tree().getValue(v.getCoord() + shift)) - Vec3d(*v);
            sum += d.lengthSqr();
            size += Vec3d(*v).lengthSqr();
        }
        return std::sqrt(sum / size);
    }
    static double difference(const std::string& a, const std::string& b) { return difference(*phi_of(a), *phi_of(b)); }
    /// lit.vdb without its light, `shift` voxels along x from where it was, with a velocity.
    static void write_moved(const std::string& name, int shift, double speed)
    {
        GridFile file = read_grid_file(*folder_ / "cloud.vdb");
        const auto density = openvdb::gridPtrCast<FloatGrid>(file.grids.at(0));
        const double edge = density->voxelSize()[0];
        const auto transform = density->transform().copy();
        transform->postTranslate(Vec3d(shift * edge, 0, 0));
        density->setTransform(transform);
        const auto vel = Vec3SGrid::create();
        vel->setName("vel");
        vel->setTransform(transform->copy());
        for (auto v = density->cbeginValueOn(); v; ++v)
            vel->tree().setValue(v.getCoord(), openvdb::Vec3f(float(speed * edge), 0, 0));
        openvdb::tools::dilateActiveValues(vel->tree(), 1);
        file.grids.push_back(vel);
        write_timed(name, std::move(file), 10.5);
    }
    static void write_timed(const std::string& name, GridFile file, double time)
    {
        set_number(*file.metadata, schema::sim_time, time);
        write_grid_file(*folder_ / name, file);
    }
    static void expect_refused(const std::string& command, int status, const std::string& piece)
    {
        const RunResult r = in_folder(command);
        EXPECT_EQ(r.status, status) << command;
        EXPECT_NE(r.err.find(piece), std::string::npos) << r.err;
    }
};

TEST_F(StartFrom, OneIterationIsAsGoodAsThree)
{
    const double one = difference("one.vdb", "all.vdb"), three = difference("three.vdb", "all.vdb"),
                 started = difference("started.vdb", "all.vdb");
    EXPECT_GT(one, 2 * three) << "the cloud needs iterations";
    EXPECT_LT(started, three) << "a fourth iteration, in fact";
    EXPECT_LT(difference("started.vdb", "three.vdb"), 0.01);
    EXPECT_NE(get_text(*fluence_grid(read_grid_file(*folder_ / "started.vdb")), schema::started_from, ""), "");
    EXPECT_EQ(get_text(*fluence_grid(read_grid_file(*folder_ / "three.vdb")), schema::started_from, ""), "");
}

TEST_F(StartFrom, StillCloudDoesNotFlicker)
{
    // The change from frame to frame is what the iteration leaves: below the error that the file states.
    expect_done("p1solve -q lit.vdb --degree 3 --change 1e-9 --iterations 1 --start-from started.vdb -o next.vdb");
    const GridFile file = read_grid_file(*folder_ / "next.vdb");
    const double stated = get_number(*fluence_grid(file), std::string(schema::accuracy_prefix) + "change", -1);
    const double flicker = difference("next.vdb", "started.vdb");
    EXPECT_GT(stated, 0);
    EXPECT_LT(flicker, stated);
    EXPECT_LT(flicker, difference("started.vdb", "three.vdb"));
}

TEST_F(StartFrom, LightMovesWithItsMedium)
{
    // Three voxels in half a second, by the files' times: the samples fall on voxels, and all is as if the cloud had
    // stood still.
    write_moved("moved.vdb", 3, 6);
    write_timed("timed.vdb", read_grid_file(*folder_ / "three.vdb"), 10);
    const std::string solve = "p1solve -q moved.vdb --extinction 15 --albedo 0.999 --g 0.85 --sun 0.5,1,0.3 --degree 3 "
                              "--change 1e-9 --iterations 1 --start-from timed.vdb ";
    expect_done(solve + "-o carried.vdb");
    EXPECT_LT(difference("carried.vdb", "started.vdb"), 1e-4);
    // Without the velocity's way the light is that of another place.
    expect_done(solve + "--start-seconds 0 -o left.vdb");
    EXPECT_GT(difference("left.vdb", "started.vdb"), 20 * difference("carried.vdb", "started.vdb"));
}

TEST_F(StartFrom, FramesOfOneRunFollowEachOther)
{
    expect_done("cp lit.vdb f.1.vdb && cp lit.vdb f.2.vdb && p1solve -q f.%d.vdb --frames 1,2 --degree 3 --change 1e-9 "
                "--iterations 1 --start-from s.%d.vdb -o s.%d.vdb");
    EXPECT_EQ(difference("s.1.vdb", "one.vdb"), 0);
    expect_done("p1solve -q lit.vdb --degree 3 --change 1e-9 --iterations 1 --start-from one.vdb -o second.vdb");
    EXPECT_EQ(difference("s.2.vdb", "second.vdb"), 0);
}

TEST_F(StartFrom, WhatCannotStartIsRefused)
{
    expect_refused("p1solve lit.vdb --start-from three.vdb -o n.vdb", 2, "--iterations above 0");
    expect_refused("p1solve lit.vdb --iterations 1 --start-from cloud.vdb -o n.vdb", 1, "no multiple scattering");
    expect_refused("p1solve lit.vdb --iterations 1 --degree 3 --periodic x --start-from three.vdb -o n.vdb", 2,
                   "and this one along x");
    expect_refused("p1solve lit.vdb --iterations 1 --degree 1 --start-from three.vdb -o n.vdb", 2, "--degree");
    expect_refused("p1solve lit.vdb --iterations 1 --degree 3 --start-from three.vdb --start-seconds 1 -o n.vdb", 2,
                   "a grid vel");
}

}  // namespace
}  // namespace vdbcloud::test
