#pragma once
// Particles of other programs: .ply, .csv, and points in .vdb files.
#include "vdbcloud/core/fwd.h"

#include <array>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace vdbcloud {

/// An attribute that no particle has is empty; else it has a value for each particle.
struct Particles {
    std::vector<Vec3d> position;                            ///< [world unit]
    std::vector<float> radius, mass, density, temperature;  ///< [world unit], any, any, K
    std::vector<Vec3f> velocity;                            ///< [world unit/s]
    std::vector<std::string> said;                          ///< which attribute is what, a sentence each
};

/// "position", "radius", "mass", "density", "temperature", "velocity".
const std::vector<std::string>& particle_roles();

/// Names of columns or attributes by role, where they are not common ones. A vector in three columns is named by what
/// the three names share: v for vx, vy, vz.
using ParticleNames = std::map<std::string, std::string>;

/// Where the attributes are among named columns: x, y, z, radius, mass, density, temperature, vx, vy, vz; -1: nowhere.
/// Names are compared in any case of letters: x, Px, P.x, P[0], Points:0, pscale, radius, vx, v.x ... Throws InputError
/// where a name of `chosen` or a position is not there.
std::array<int, 10> particle_columns(const std::vector<std::string>& names, const ParticleNames& chosen);

/// Adds a particle from the values of particle_columns(), those of columns that are there. Throws InputError, which
/// where() begins, for a value that no particle has.
void add_particle(Particles&, const std::array<int, 10>& columns, const std::array<double, 10>& values,
                  const std::function<std::string()>& where);

/// The vertices of a .ply: ascii, or binary of either byte order. Throws IoError if the file cannot be read, else
/// InputError with path and place.
Particles read_ply(const std::string& path, const ParticleNames&);

/// A table whose first line names the columns, between commas, semicolons, tabs or blanks. Throws as read_ply().
Particles read_csv(const std::string& path, const ParticleNames&);

/// The points of all PointDataGrids of a .vdb. Throws as read_ply().
Particles read_points(const std::string& path, const ParticleNames&);

/// What splatting does with particles that lack an attribute.
struct SplatOptions {
    Vec3d cell{0, 0, 0};  ///< size of a voxel [world unit]
    double radius = 0;    ///< of particles without one [world unit]
};

struct Splats {
    FloatGridPtr density;      ///< mass per volume [mass/world unit^3]
    FloatGridPtr temperature;  ///< mean over the mass in the voxel; null without temperatures
    Vec3SGridPtr velocity;     ///< the same; null without velocities
    double mass = 0;           ///< of all particles
};

/// What splat() would work on, for estimates of time and memory: voxels that the balls reach, blocks of 8^3 voxels and
/// nodes of 128^3 that the grids have, and pairs of a particle and a block.
struct SplatWork {
    double voxels = 0, blocks = 0, nodes = 0, pairs = 0;
};
SplatWork splat_work(const Particles&, const SplatOptions&);

/// Spreads each particle's mass over the voxels that the ball of its radius about it holds, by the kernel (1 - q)^4 (4
/// q
/// + 1) of q = distance / radius (Wendland 1995), divided by its sum over these voxels: the mass of the grid is that of
/// the particles to the rounding of floats. A radius below two of the longest edge of a voxel, which samples the kernel
/// badly, gives the mass to the eight nearest voxels, trilinearly. Mass: of the particle; without, its density times
/// the volume of its ball; without, 1. (Reeves 1983: particle systems.) The result does not depend on the number of
/// threads.
Splats splat(const Particles&, const SplatOptions&);

}  // namespace vdbcloud
