#pragma once
// Small densities from one line of text, and their images under a map of the index space.
#include "hard/programs.h"
#include "vdbcloud/core/fwd.h"
#include "vdbcloud/grid/grid_file.h"

#include <array>
#include <optional>
#include <string>

namespace vdbcloud::test {

/// What a twin of a world differs in. Index c of the twin is shift[c] plus sign[c] times index axis[c] of the world; a
/// point p of the world is at world * p in the twin.
struct Change {
    std::array<int, 3> axis{0, 1, 2}, sign{1, 1, 1};
    Vec3i shift{0, 0, 0};                                                        ///< [voxels]
    std::array<Vec3d, 3> world{Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1)};  ///< rows
    double size = 1;                                                             ///< of the scaling in `world`
    double density = 1;                                                          ///< factor of density and emission
    double power = 1;      ///< factor of all lights, the sky among them
    bool flipped = false;  ///< the picture is seen in a mirror

    Vec3d point(const Vec3d& p) const { return {world[0].dot(p), world[1].dot(p), world[2].dot(p)}; }
    Vec3i index(const Vec3i& i) const
    {
        return shift + Vec3i(sign[0] * i[axis[0]], sign[1] * i[axis[1]], sign[2] * i[axis[2]]);
    }
};

/// The grids of a body. The line is a kind and NAME=VALUE words:
///
///     noise n=8,8,6 seed=5 void=0.4 low=1e-3 high=1   random values, even in the logarithm, and voids
///     box n=8,8,8 value=1                             one value
///     ball n=9                                        1 in the middle, falling to 0
///     checker n=8,8,8 low=1 high=1e12                 two values by turns; layers, rows: along i; along i and j
///     line n=8                                        voxels along the diagonal
///     stray n=4,4,4 distance=100                      a box, and a voxel far away along i
///     far n=5,5,5 at=1000000000                       a box whose first voxel has these indices
///     spread n=16 distance=600                        voxels far from each other
///     tile level=1                                    one active tile: 1 of 8, 2 of 128, 3 of 4096 voxels a side
///     empty                                           no active voxel
///     fractal --size 8 --seed 3                       a density of fractalgen with these options
///
///     table 0 1 2 / 3 4 5                             no density but a text file: lines between slashes
///
/// emission=VALUE adds a grid `emission` of the density times this value, fire=KELVIN grids `temperature` of the
/// density times this value and `flame` of the density, cd=SEED a random grid `Cd`, times=VALUE
/// multiplies the density. `axes` are the world vectors of steps along i, j, k before the change.
GridFile make_body(Programs&, const std::string& line, const std::array<Vec3d, 3>& axes, const Vec3d& origin,
                   const Change&, const std::string& folder);

/// The text of a body of kind table.
std::optional<std::string> table_of_body(const std::string& line);

/// Reads and writes files of the suite itself.
GridFile read_own(const std::string& path);
void write_own(const std::string& path, const GridFile&);

/// The density that make_body gives.
FloatGridPtr density_of_body(const GridFile&);

}  // namespace vdbcloud::test
