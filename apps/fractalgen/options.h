#pragma once
// What fractalgen can be asked for.
#include "medium_options.h"
#include "stage_options.h"

#include "vdbcloud/fractal/cloud_shape.h"
#include "vdbcloud/fractal/cumulus.h"
#include "vdbcloud/fractal/mountain.h"
#include "vdbcloud/fractal/noise.h"

namespace vdbcloud::app {

enum class Region { Cumulus, Sphere, Ellipsoid, Slab, Box };

/// Defaults make a fair-weather cumulus, two world units broad.
struct Options {
    std::string input, output;
    uint64_t seed = 1;
    std::optional<double> beta, outer;  ///< not given: cloud_beta and so on below
    Spectrum spectrum;
    Region envelope = Region::Cumulus;
    std::string envelope_from, mask_grid;
    CumulusOptions cumulus;
    ShapeOptions shape;
    std::string size = "256", bounds;
    UpAxis up = UpAxis::Y;
    MediumOptions medium;
    bool mountain = false;
    MountainOptions relief;
};

// The bulges of a cumulus are the long waves of its surface, so its noise begins at shorter ones; other
// envelopes have none.
inline constexpr double cloud_beta = 4.2, cloud_outer = 4;
inline constexpr double mountain_beta = 3.5, mountain_outer = 0;

void declare(App&, Options&);

/// Where the cloud is made: whole voxels over at least the bounds.
struct Domain {
    Box box;     ///< [world]
    Vec3i size;  ///< [voxels]
};

/// From --size and --bounds, or `otherwise` where there are no --bounds. One number for the size cuts the
/// longest side into so many voxels, which are cubes: the other sides grow by less than one to a whole number
/// of them. Throws UsageError.
Domain domain_of(const Options&, const Box& otherwise);

/// Two units broad, 1.25 high, standing on the origin.
Box default_bounds(const Options&);

}  // namespace vdbcloud::app
