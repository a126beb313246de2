#pragma once
// What fractalgen can be asked for.
#include "app.h"

#include "vdbcloud/fractal/cloud_shape.h"
#include "vdbcloud/fractal/cumulus.h"
#include "vdbcloud/fractal/noise.h"
#include "vdbcloud/optics/medium.h"

namespace vdbcloud::app {

enum class Region { Cumulus, Sphere, Ellipsoid, Slab, Box };

/// Defaults make a fair-weather cumulus, two world units broad.
struct Options {
    std::string output;
    uint64_t seed = 1;
    std::string size = "256", bounds;
    int up = 1;
    Region envelope = Region::Cumulus;
    CumulusOptions cumulus;
    ShapeOptions shape;
    Spectrum spectrum{1, 4.2, 4};  // the envelope has the long waves
    Medium medium;
};

void declare(App&, Options&);

/// Where the cloud is made: whole voxels over at least the bounds.
struct Domain {
    Box box;     ///< [world]
    Vec3i size;  ///< [voxels]
};

/// From --size and --bounds. One number for the size cuts the longest side into so many voxels, which are cubes: the
/// other sides grow by less than one to a whole number of them. Throws UsageError.
Domain domain_of(const Options&);

}  // namespace vdbcloud::app
