// make_cloud puffs|blobs TAU OUT.vdb [whole|half]: a reference cloud whose thickest column has the optical depth TAU,
// for programs; half: the same medium by voxels of half the edge.
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
    const bool known = argc == 4 || argc == 5;
    const std::string cloud = known ? argv[1] : "", voxels = argc == 5 ? argv[4] : "whole";
    const double tau = known ? std::atof(argv[2]) : 0;
    if (!(tau > 0) || (cloud != "puffs" && cloud != "blobs") || (voxels != "whole" && voxels != "half")) {
        std::fprintf(stderr, "usage: make_cloud puffs|blobs TAU OUT.vdb [whole|half], TAU > 0\n");
        return 2;
    }
    const FloatGridPtr whole = cloud == "puffs" ? test::cloud_of_puffs() : test::cloud_of_blobs();
    const FloatGridPtr density = voxels == "half" ? test::at_half_the_voxel(*whole) : whole;
    density->setGridClass(openvdb::GRID_FOG_VOLUME);
    Medium medium;
    medium.sigma_t_per_density = Vec3d(test::extinction_for(*whole, tau));
    write_medium(*density, medium);
    GridFile file;
    file.metadata = std::make_shared<MetaMap>();
    file.grids = {density};
    write_grid_file(argv[3], file);
}
