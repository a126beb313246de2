#pragma once
// The options of fractalgen.
#include "medium_options.h"
#include "stage_options.h"

#include "vdbcloud/fractal/cloud_shape.h"
#include "vdbcloud/fractal/cumulus.h"
#include "vdbcloud/fractal/detail.h"
#include "vdbcloud/fractal/mountain.h"
#include "vdbcloud/fractal/noise.h"

namespace vdbcloud::app {

enum class Region { Cumulus, Sphere, Ellipsoid, Slab, Box };

/// Defaults make a fair-weather cumulus, two world units broad.
struct Options {
    std::string input, output;
    uint64_t seed = 1;
    std::optional<double> beta, outer;  ///< without a value: cloud_beta, cloud_outer, mountain_beta or mountain_outer
    Spectrum spectrum;
    Region envelope = Region::Cumulus;
    std::string envelope_from, mask_grid;
    CumulusOptions cumulus;
    ShapeOptions shape;
    std::string size = "256", bounds;
    std::optional<UpAxis> up_asked;
    UpAxis up = UpAxis::Y;  ///< the one asked for, else that of the input or of the envelope's file
    MediumOptions medium;
    bool mountain = false;
    MountainOptions relief;
    std::string detail_from;  ///< density that gets detail; empty: none
    DetailOptions detail;
    Option detail_time;
};

// The towers and bulges of a cumulus replace the long waves of its surface, so its noise begins at shorter waves.
inline constexpr double cloud_beta = 4.2, cloud_outer = 4;
inline constexpr double mountain_beta = 3.5, mountain_outer = 0;

void declare(App&, Options&);

/// The box of voxels that the cloud is made in. It covers the bounds.
struct Domain {
    Box box;     ///< [world]
    Vec3i size;  ///< [voxels]
};

/// The domain of --size and --bounds; without --bounds, of `otherwise`. If --size is one number, it divides the longest
/// side, voxels are cubes, and the other sides grow to whole numbers of voxels. Throws UsageError.
Domain domain_of(const Options&, const Box& otherwise);

/// Two units broad, 1.25 high, standing on the origin.
Box default_bounds(const Options&);

}  // namespace vdbcloud::app
