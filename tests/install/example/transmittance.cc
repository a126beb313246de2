// Reads a density, lights it from above and prints the smallest transmittance. Usage: transmittance density.vdb
#include <vdbcloud/core/vdb.h>
#include <vdbcloud/file/io.h>
#include <vdbcloud/grid/density.h>
#include <vdbcloud/light/transmittance_grid.h>

#include <openvdb/tools/Statistics.h>

#include <iostream>

int main(int, char** argv)
{
    using namespace vdbcloud;
    GridFile file = read_grid_file(argv[1]);
    Medium medium;
    medium.sigma_t_per_density = Vec3d(0.5);
    const auto grid = transmittance_grid(*density_of(file, ""), medium, make_sun(Vec3d(0, 1, 0)), {});
    std::cout << openvdb::tools::extrema(openvdb::gridConstPtrCast<FloatGrid>(grid)->cbeginValueOn()).min() << "\n";
}
