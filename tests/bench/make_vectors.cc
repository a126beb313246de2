// make_vectors IN.vdb emission|Cd idle|on OUT.vdb: adds to a density's file a vector grid in the voxels of the density,
// with values that add nothing (idle) or something (on): emission of 0 or a tenth of the density, Cd of 1 or 0.9.
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/file/io.h"

#include <cstdio>
#include <exception>
#include <string>

namespace vdbcloud {
namespace {

int make_vectors(int argc, char** argv)
{
    const std::string name = argc == 5 ? argv[2] : "", kind = argc == 5 ? argv[3] : "";
    if ((name != "emission" && name != "Cd") || (kind != "idle" && kind != "on")) {
        std::fprintf(stderr, "usage: make_vectors IN.vdb emission|Cd idle|on OUT.vdb\n");
        return 2;
    }
    GridFile file = read_grid_file(argv[1]);
    const auto density = openvdb::gridPtrCast<FloatGrid>(file.grids.at(0));
    const Vec3f neutral(name == "Cd" ? 1.0f : 0.0f);
    const auto tree = std::make_shared<openvdb::Vec3STree>(density->tree(), neutral, neutral, openvdb::TopologyCopy());
    for (auto v = tree->beginValueOn(); v && kind == "on"; ++v)
        v.setValue(name == "Cd" ? Vec3f(0.9f) : Vec3f(0.1f * density->tree().getValue(v.getCoord())));
    const auto grid = Vec3SGrid::create(tree);
    grid->setName(name);
    grid->setTransform(density->transform().copy());
    file.grids.push_back(grid);
    write_grid_file(argv[4], file);
    return 0;
}

}  // namespace
}  // namespace vdbcloud

int main(int argc, char** argv)
{
    try {
        return vdbcloud::make_vectors(argc, argv);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "make_vectors: %s\n", e.what());
        return 1;
    }
}
