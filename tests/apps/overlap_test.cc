// Media that overlap and keep their phase functions and colours: p1solve makes one file of several, render shows it.
#include "several_inputs.h"

#include "vdbcloud/grid/registry.h"

namespace vdbcloud::test {
namespace {

class OverlapOfFiles : public SeveralInputs {
protected:
    void write_medium_file(const std::string& name, const FloatGridPtr& density, const Vec3d& sigma_t,
                           const Vec3d& albedo, const PhaseFunction& phase)
    {
        Medium m;
        m.sigma_t_per_density = sigma_t;
        m.albedo = albedo;
        m.phase = phase;
        const auto grid = density->deepCopy();
        write_medium(*grid, m);
        write_grid_file(path(name), file_of({grid}));
    }
    /// Rayleigh air, isotropic dust that absorbs, droplets.
    void write_media(const Vec3d& dust_albedo = Vec3d(0.9, 0.7, 0.5))
    {
        write_medium_file("air.vdb", body(1), Vec3d(0.5, 1, 2), Vec3d(1), PhaseFunction("rayleigh"));
        write_medium_file("dust.vdb", moved(body(2), Vec3d(0.4, 0, 0)), Vec3d(3, 2, 1), dust_albedo, PhaseFunction());
        write_medium_file("cloud.vdb", body(3), Vec3d(8), Vec3d(1), PhaseFunction::henyey_greenstein(0.8));
    }
};

TEST_F(OverlapOfFiles, SingleScatteringOfTheSolvedFileIsThatOfTheFiles)
{
    write_media();
    // Without delta scaling each shows w0 sigma_t p E T of the true medium. Lattices of rays differ: those of one
    // density of all, and one for each medium.
    done("p1solve", "-q air.vdb dust.vdb cloud.vdb --sun 0.3,1,0.2 --delta off -o lit.vdb");
    const PictureFile solved = view("lit.vdb", "--aov all"),
                      direct = view("air.vdb dust.vdb cloud.vdb", "--aov all --sun 0.3,1,0.2");
    for (const char* layer : {"direct_sun.R", "direct_sun.G", "direct_sun.B", "A"})
        EXPECT_NEAR(mean(solved, layer) / mean(direct, layer), 1, 0.003) << layer;
    const GridFile lit = read_grid_file(path("lit.vdb"));
    EXPECT_EQ(get_number(*lit.metadata, schema::media, 0), 3);
    EXPECT_TRUE(find_grid(lit, "density") && find_grid(lit, "medium_2") && find_grid(lit, "medium_3"));
    EXPECT_EQ(read_medium(*find_grid(lit, "medium_2")).albedo, Vec3d(0.9, 0.7, 0.5));
    EXPECT_EQ(std::string(read_medium(*find_grid(lit, "medium_3")).phase.name()), "henyey-greenstein");
}

TEST_F(OverlapOfFiles, PictureIsThatOfLightPaths)
{
    // 16^3 voxels and six sweeps: 3 % of the mean; paths leave 1 %, two sets of paths more.
    write_media();
    done("p1solve",
         "-q air.vdb dust.vdb cloud.vdb --sun 0.3,1,0.2 --iterations 6 --degree 3 --directions 64 -o lit.vdb");
    const std::string paths = " --integrator path --spp 48";
    const PictureFile truth = view("lit.vdb", paths), cells = view("lit.vdb", ""),
                      gathered = view("lit.vdb", " --integrator path --gather 2 --spp 8"),
                      of_files = view("air.vdb dust.vdb cloud.vdb", paths + " --sun 0.3,1,0.2");
    for (const char* channel : {"R", "G", "B"})
        for (const PictureFile* seen : {&cells, &gathered, &of_files})
            EXPECT_NEAR(mean(*seen, channel) / mean(truth, channel), 1, 0.04) << channel;
}

TEST_F(OverlapOfFiles, WhiteMediaUnderAUniformSkyAreInvisible)
{
    write_media(Vec3d(1));
    for (const char* options : {"", " --iterations 2 --degree 3"}) {
        done("p1solve", std::string("-q air.vdb dust.vdb cloud.vdb --sky 1 --tolerance 1e-8 -o lit.vdb") + options);
        const PictureFile seen = view("lit.vdb", " --background sky");
        for (const char* channel : {"R", "G", "B"}) EXPECT_NEAR(mean(seen, channel), 1, 2e-5) << channel;
    }
}

TEST_F(OverlapOfFiles, ASolvedFileIsSolvedAgain)
{
    write_media();
    done("p1solve", "-q air.vdb dust.vdb cloud.vdb --sun 0.3,1,0.2 -o lit.vdb");
    const std::string said = done("p1solve", "lit.vdb -o again.vdb");
    EXPECT_NE(said.find("3 media overlap"), std::string::npos) << said;
    EXPECT_TRUE(equal("lit.vdb", "again.vdb"));
}

TEST_F(OverlapOfFiles, WhatTakesOneMediumIsRefused)
{
    write_media();
    for (const char* option : {"--series 2", "--voxel-error"})
        EXPECT_NE(
            refused("p1solve", "air.vdb cloud.vdb " + std::string(option) + " -o no.vdb").find("takes one medium"),
            std::string::npos);
    EXPECT_NE(refused("illuminate", "air.vdb cloud.vdb -o no.vdb").find("p1solve or render"), std::string::npos);
    done("p1solve", "-q air.vdb cloud.vdb --sun 0.3,1,0.2 -o lit.vdb");
    // Light of other coefficients, of a file that lost a medium, and beside another medium.
    EXPECT_NE(refused("render", "lit.vdb --albedo 0.5 -o no.exr").find("run p1solve again"), std::string::npos);
    EXPECT_NE(refused("render", "lit.vdb dust.vdb -o no.exr").find("p1solve lit.vdb dust.vdb"), std::string::npos);
    GridFile less = read_grid_file(path("lit.vdb"));
    remove_grids(less, [](const std::string& name) { return name == "medium_2"; });
    write_grid_file(path("less.vdb"), less);
    const RunResult result = run_line("render", "less.vdb -o no.exr");
    EXPECT_EQ(result.status, 1);
    EXPECT_NE(result.err.find("'medium_2' is missing"), std::string::npos) << result.err;
}

TEST_F(OverlapOfFiles, MediaThatRepeatHaveThePeriodOfAll)
{
    const auto slab = [](int n) { return box({n, 8, n}, edge, [](Coord) { return 1.0; }); };
    write_medium_file("air.vdb", slab(16), Vec3d(0.5, 1, 2), Vec3d(1), PhaseFunction("rayleigh"));
    write_medium_file("cloud.vdb", slab(8), Vec3d(8), Vec3d(1), PhaseFunction::henyey_greenstein(0.8));
    done("p1solve", "-q air.vdb cloud.vdb --periodic xz --sky 1 --tolerance 1e-8 -o lit.vdb");
    EXPECT_NEAR(mean("lit.vdb", " --background sky"), 1, 1e-3);
}

}  // namespace
}  // namespace vdbcloud::test
