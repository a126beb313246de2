// make_puffs TAU OUT.vdb: the cloud of puffs whose thickest column has the optical depth TAU, for programs.
#include "support/puffs.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/file/io.h"
#include "vdbcloud/optics/medium.h"

#include <cstdio>
#include <cstdlib>

int main(int argc, char** argv)
{
    using namespace vdbcloud;
    const double tau = argc == 3 ? std::atof(argv[1]) : 0;
    if (!(tau > 0)) {
        std::fprintf(stderr, "usage: make_puffs TAU OUT.vdb, TAU > 0\n");
        return 2;
    }
    const FloatGridPtr puffs = test::cloud_of_puffs();
    puffs->setGridClass(openvdb::GRID_FOG_VOLUME);
    Medium medium;
    medium.sigma_t_per_density = Vec3d(test::extinction_of_puffs(*puffs, tau));
    write_medium(*puffs, medium);
    GridFile file;
    file.metadata = std::make_shared<MetaMap>();
    file.grids = {puffs};
    write_grid_file(argv[2], file);
}
