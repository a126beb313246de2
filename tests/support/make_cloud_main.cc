// make_cloud puffs|blobs TAU OUT.vdb: a reference cloud whose thickest column has the optical depth TAU, for programs.
#include "support/reference_clouds.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/file/io.h"
#include "vdbcloud/optics/medium.h"

#include <cstdio>
#include <cstdlib>
#include <string>

int main(int argc, char** argv)
{
    using namespace vdbcloud;
    const std::string cloud = argc == 4 ? argv[1] : "";
    const double tau = argc == 4 ? std::atof(argv[2]) : 0;
    if (!(tau > 0) || (cloud != "puffs" && cloud != "blobs")) {
        std::fprintf(stderr, "usage: make_cloud puffs|blobs TAU OUT.vdb, TAU > 0\n");
        return 2;
    }
    const FloatGridPtr density = cloud == "puffs" ? test::cloud_of_puffs() : test::cloud_of_blobs();
    density->setGridClass(openvdb::GRID_FOG_VOLUME);
    Medium medium;
    medium.sigma_t_per_density = Vec3d(test::extinction_for(*density, tau));
    write_medium(*density, medium);
    GridFile file;
    file.metadata = std::make_shared<MetaMap>();
    file.grids = {density};
    write_grid_file(argv[3], file);
}
