#pragma once
// Cells of a simulation and voxels of its files: no other code exchanges axes. Private to sim/.
#include "vdbcloud/core/fwd.h"
#include "vdbcloud/grid/up_axis.h"
#include "vdbcloud/sim/field.h"

namespace vdbcloud::sim {

/// From cells (i, j, k), k up, to voxels: the box begins on the origin, in metres.
struct Axes {
    const Lattice& l;
    UpAxis up;
    std::array<double, 2> moved{0, 0};  ///< of the box over the ground [m]

    bool swap() const { return up == UpAxis::Y; }
    /// The coordinate of the files along which a cell's axis points.
    int file_axis(int axis) const { return swap() && axis > 0 ? 3 - axis : axis; }

    Vec3i voxel(int i, int j, int k) const { return swap() ? Vec3i(i, k, j) : Vec3i(i, j, k); }
    Vec3f vector(float u, float v, float w) const { return swap() ? Vec3f(u, w, v) : Vec3f(u, v, w); }
    Vec3d position(double x, double y, double z) const { return swap() ? Vec3d(x, z, y) : Vec3d(x, y, z); }
    /// World coordinate of the centre of cell `i` along an axis [m].
    double centre(int axis, double i) const
    {
        const double in_box = (i + 0.5 - (axis < 2 ? 0.5 * l.n[size_t(axis)] : 0)) * l.h[size_t(axis)];
        return axis < 2 ? in_box + moved[size_t(axis)] : in_box;
    }
};

}  // namespace vdbcloud::sim
