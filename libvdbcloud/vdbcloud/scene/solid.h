#pragma once
// Opaque bodies beside the media: their shapes, their materials, and how they travel in a file.
#include "vdbcloud/core/fwd.h"

#include <optional>
#include <string>
#include <vector>

namespace vdbcloud {

struct GridFile;

/// How a surface sends light back.
enum class Finish {
    Diffuse,  ///< Lambert's law
    Mirror,   ///< the mirror image alone
    Glossy    ///< a lobe about the mirror image (optics/reflection.h)
};

/// The words of files and command lines: diffuse, mirror, glossy.
const char* name(Finish);
Finish finish_kind(const std::string& word);  ///< Throws InputError with the words that there are.

/// Reflectance of a surface. It is the share of the light from any direction that leaves the surface again.
struct Material {
    Finish finish = Finish::Diffuse;
    Vec3d colour{0.5, 0.5, 0.5};  ///< reflectance for r, g, b, 0 to 1
    std::optional<Vec3d>
        checker;              ///< of every second cube of a lattice of cubes about the world's origin; else one colour
    double checker_edge = 1;  ///< of these cubes [world unit], > 0
    double roughness = 0.1;   ///< Glossy: 0 (mirror) to 1; the lobe is cos^n, n = 2 / roughness^2 - 2

    /// The colour at a point of the surface.
    const Vec3d& reflectance(const Vec3d& x) const;
    /// True where no channel comes back anywhere.
    bool black() const;
};

bool operator==(const Material&, const Material&);

enum class SolidKind {
    Plane,    ///< all that lies below a plane without end
    Sphere,   ///< a ball
    Box,      ///< between two corners, edges along the world's axes
    LevelSet  ///< where the trilinear interpolant of a level set is below 0
};

/// One solid: a value. All lengths are in world space.
struct Solid {
    SolidKind kind = SolidKind::Sphere;
    Vec3d place{0, 0, 0};    ///< a point of the plane, the middle of the ball, the lowest corner of the box
    Vec3d extent{0, 1, 0};   ///< the plane's upward normal (unit), the ball's radius in all three, the other corner
    FloatGridPtr level_set;  ///< of LevelSet; signed distance within a band, background above 0 outside
    Material material;
};

Solid make_plane(const Vec3d& point, const Vec3d& up, const Material& = {});
Solid make_ball(const Vec3d& middle, double radius, const Material& = {});
Solid make_box(const Vec3d& lowest, const Vec3d& highest, const Material& = {});
Solid make_level_set(FloatGridPtr, const Material& = {});

/// Throws InputError for a number that is not finite or out of its range, a box without volume, a level set without a
/// background above 0, with a value that is not finite, or without an affine transform.
void check(const Solid&);

/// "sphere at 0,1,0 of radius 0.5", "level set 'solid'": for messages.
std::string described(const Solid&);

/// Memory of their level sets [bytes].
double bytes_of(const std::vector<Solid>&);

/// Corners [world] of a box about a solid; none for a plane.
std::vector<Vec3d> corners_of(const Solid&);

/// The solids of a file: its grids `solid`, `solid2` ... in the order of their numbers. Material and shape are in their
/// metadata (docs/format.md); a level set without a material is grey and diffuse, as fractalgen and other programs
/// leave it. Throws InputError as check(), naming the grid.
std::vector<Solid> solids_of(const GridFile&);

/// Puts solids into a file in place of those that it has, as grids `solid`, `solid2` ...
void put_solids(GridFile&, const std::vector<Solid>&);

/// Fingerprint of the shapes of solids, in any order, with `materials` of their materials too. Empty without solids.
std::string solids_digest(const std::vector<Solid>&, bool materials);

}  // namespace vdbcloud
