// make_fields IN.vdb emission|Cd|temperature idle|on OUT.vdb: adds to a density's file a grid in the voxels of the
// density, with values that add nothing (idle) or something (on): emission of 0 or a tenth of the density, Cd of 1 or
// 0.9, temperatures of 300 or 1500 K.
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/file/io.h"

#include <cstdio>
#include <exception>
#include <string>

namespace vdbcloud {
namespace {

/// A grid in the voxels of the density: value(density) in each.
template<typename GridT, typename F>
GridBasePtr field(const FloatGrid& density, const F& value)
{
    using Tree = typename GridT::TreeType;
    const typename GridT::ValueType none(0.0f);
    const auto tree = std::make_shared<Tree>(density.tree(), none, none, openvdb::TopologyCopy());
    for (auto v = tree->beginValueOn(); v; ++v) v.setValue(value(density.tree().getValue(v.getCoord())));
    return GridT::create(tree);
}

GridBasePtr named_field(const FloatGrid& density, const std::string& name, bool on)
{
    if (name == "emission") return field<Vec3SGrid>(density, [&](float d) { return Vec3f(on ? 0.1f * d : 0.0f); });
    if (name == "Cd") return field<Vec3SGrid>(density, [&](float) { return Vec3f(on ? 0.9f : 1.0f); });
    if (name == "temperature") return field<FloatGrid>(density, [&](float) { return on ? 1500.0f : 300.0f; });
    return nullptr;
}

int make_fields(int argc, char** argv)
{
    const std::string name = argc == 5 ? argv[2] : "", kind = argc == 5 ? argv[3] : "";
    const bool known = name == "emission" || name == "Cd" || name == "temperature";
    if (!known || (kind != "idle" && kind != "on")) {
        std::fprintf(stderr, "usage: make_fields IN.vdb emission|Cd|temperature idle|on OUT.vdb\n");
        return 2;
    }
    GridFile file = read_grid_file(argv[1]);
    const auto density = openvdb::gridPtrCast<FloatGrid>(file.grids.at(0));
    const GridBasePtr grid = named_field(*density, name, kind == "on");
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
        return vdbcloud::make_fields(argc, argv);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "make_fields: %s\n", e.what());
        return 1;
    }
}
