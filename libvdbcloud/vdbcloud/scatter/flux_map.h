#pragma once
// Power per area by column of the grid: what a map of a cloud field from above shows.
#include "vdbcloud/scatter/planes.h"
#include "vdbcloud/scene/light.h"

#include <array>
#include <vector>

namespace vdbcloud {

class BeamMedium;

/// Values by column along the index axis nearest to up, through the ActiveBox of the medium. Power per area of a
/// column's cross-section [radiance x sr]: the mean of a map times the area of the plane is the power of the report.
///
/// Pixel (x, y) is the column at voxel (x, y) of the box along the other two index axes, in rising order. Values of a
/// map are row by row, x fastest.
struct FluxMap {
    int width = 0, height = 0;
    int top = 0, base = 0;        ///< planes, Blocks::Face
    Vec3d first, step_x, step_y;  ///< [world]: centre of pixel 0, 0 on the base plane; a step of one pixel
    double column_area = 0;       ///< [(world unit)^2]

    struct Channel {
        std::vector<float> diffuse_up;    ///< out through the top plane, the sky's light included
        std::vector<float> diffuse_down;  ///< out through the base plane, the same
        std::vector<float> direct_top;    ///< of the beams, downward through the top plane; below 0 where they go up
        std::vector<float> direct_base;   ///< the same through the base plane
        std::vector<float> absorbed;      ///< in the column
    };
    std::array<Channel, 3> channel;
};

/// The names of Channel's members in files, and the members.
struct FluxMapLayer {
    const char* name;
    std::vector<float> FluxMap::Channel::*values;
};
const std::array<FluxMapLayer, 5>& flux_map_layers();

/// Mean of a map's values times its area: a power [radiance x (world unit)^2].
double power_of(const FluxMap&, const std::vector<float>& values);

/// A map without values. Throws InputError if the medium repeats along the axis nearest to `up` [world], and
/// for more than 2^26 columns.
FluxMap columns_of(const VoxelIndex&, const Vec3d& up);

/// From the order of a plane's cells (ActiveBox) to that of a map's pixels.
std::vector<float> by_pixel(const FluxMap&, const std::vector<float>& cells);

/// Irradiance of each cell of a plane by the beams of `lights` (without extent), times their strength in channel `c`;
/// above 0 where a beam goes along `down`. Depths as for add_direct().
std::vector<float> direct_on_plane(const VoxelIndex&, const BeamMedium&, const std::vector<Light>&, int c, int face,
                                   const Vec3d& down);

/// Sets direct_top and direct_base to the beams of `lights` (without extent), times their strength in channel `c`.
/// Depths are taken half a voxel out of the box along the beam, as those of exposed faces (beam.h).
void add_direct(const VoxelIndex&, const BeamMedium&, const std::vector<Light>& lights, int c, const FluxMap&,
                FluxMap::Channel&);

/// Sets absorbed from heating_rate().
void add_absorbed(const VoxelIndex&, const std::vector<float>& heating, const FluxMap&, FluxMap::Channel&);

/// Makes channel `to` the channel `from` times `scale`.
void share_channel(int from, int to, double scale, FluxMap&);

}  // namespace vdbcloud
