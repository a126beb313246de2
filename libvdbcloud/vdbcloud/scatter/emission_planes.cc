// Planes of the box about the voxels as receivers of emission.
#include "vdbcloud/scatter/emission_receivers.h"

#include <tbb/parallel_for.h>

namespace vdbcloud {

using namespace emission;

namespace {

/// Solid angle of a rectangle seen from a point at the height `z` above its plane; its corners lie at x0..x1, y0..y1
/// from the point's foot.
double rectangle(double x0, double x1, double y0, double y1, double z)
{
    const auto corner = [z](double x, double y) { return std::atan2(x * y, z * std::sqrt(x * x + y * y + z * z)); };
    return corner(x1, y1) - corner(x0, y1) - corner(x1, y0) + corner(x0, y0);
}

}  // namespace

/// The cells of a plane as receivers: numbered from 0 along the plane's axes, 0 across it.
struct EmissionGather::Plane {
    Plane(const EmissionGather& of, int f, const Hemisphere& half, std::vector<double>& to, double* ahead_of)
        : my(of), face(f), hemisphere(half), out(to), ahead(ahead_of)
    {
        cells[0] = cells[1] = cells[2] = 1;
        for (const int a : ActiveBox::axes(face / 2)) cells[a] = my.box_.size(a);
    }

    bool inside(const Vec3i& at) const { return at[0] < cells[0] && at[1] < cells[1] && at[2] < cells[2]; }
    bool any(const Tile& tile) const { return inside(tile.at); }
    size_t cell(const Vec3i& at) const { return my.box_.cell(face, my.box_.first + at); }

    /// The depth from a point on the way from `source` to a place of the plane, and on to the end of the trilinear
    /// fringe.
    double depth(const Vec3d& source, const Vec3d& place, const Vec3d& from) const  // `from` [world]
    {
        const Vec3d way = place - source;
        const double across = std::max(std::abs(way[face / 2]), 1e-3);
        return my.depth_(my.index_.world(place + way * (0.5 / across)), from, deepest);
    }

    bool take(const EmissionNode& node, const Tile& tile)
    {
        const int axis = face / 2;
        const Look look = my.look(node, tile, scale);
        if (look.share < least_share) return true;
        if (my.coarse(node, tile, look)) return false;
        const bool by_parts = look.parts;
        const Vec3d centre = my.voxels(Vec3d(node.centre));
        const TileDepths depths(tile.n, stride_of(node, look.share, 0), [&](const Vec3i& p) {
            const Vec3d at = tile.low + as_double(p);
            return depth(centre, at, my.way_out(node, at, by_parts));
        });
        for (int i = 0; i < tile.n[0]; ++i)
            for (int j = 0; j < tile.n[1]; ++j)
                for (int k = 0; k < tile.n[2]; ++k) {
                    const Vec3i p(i, j, k);
                    if (!inside(tile.at + p)) continue;
                    const View view(node, my.metric(tile.low + as_double(p)), my.index_.spacing(), depths(p),
                                    by_parts ? &my.parts_ : nullptr);
                    const double cosine = std::abs(view.towards[axis]);
                    const double within = hemisphere.of_direction(-view.towards);
                    for (size_t c = 0; c < size_t(my.channels_); ++c)
                        add(tile.at + p, c, cosine * view.of_channel(node, c), within);
                }
        return true;
    }

    /// A voxel beside the plane, as 3^3 points: the power of each through the cell, by the cell's solid angle.
    void near(const EmissionNode& node, const Tile& tile)
    {
        const Vec3d& h = my.index_.spacing();
        const int axis = face / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
        double share = 0, within = 0;
        for (int k = 0; k < 27; ++k) {
            const Vec3d source = as_double(node.low) + Vec3d(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1) / 3.0;
            const Vec3d way = tile.low - source;
            const double solid = rectangle((way[u] - 0.5) * h[u], (way[u] + 0.5) * h[u], (way[v] - 0.5) * h[v],
                                           (way[v] + 0.5) * h[v], std::abs(way[axis]) * h[axis]);
            const double light = solid * std::exp(-depth(source, tile.low, my.index_.world(source))) / 27;
            share += light;
            within += hemisphere.of_direction(my.metric(way).unit()) * light;
        }
        for (size_t c = 0; c < size_t(my.channels_) && share > 0; ++c)
            add(tile.at, c, share * node.power[c] / (h[u] * h[v]), within / share);
    }

    /// `within`: the part that goes into the hemisphere.
    void add(const Vec3i& at, size_t c, double power, double within)
    {
        out[cell(at) * size_t(my.channels_) + c] += power;
        ahead[c] += within * power;
    }

    const EmissionGather& my;
    const int face;
    const Hemisphere& hemisphere;
    std::vector<double>& out;
    double* ahead;
    Vec3i cells;
    double scale = 0;  // as of Voxels
};

std::vector<double> EmissionGather::plane(int face, const Hemisphere& hemisphere, std::vector<double>& ahead) const
{
    std::vector<double> out(box_.cells(face) * size_t(channels_), 0.0);
    ahead.assign(size_t(channels_), 0.0);
    if (tree_.nodes().empty()) return out;
    const int axis = face / 2;
    const auto [u, v] = ActiveBox::axes(axis);
    const int rows = (box_.size(u) + 7) / 8, columns = (box_.size(v) + 7) / 8;
    std::vector<std::array<double, 3>> of_tile(size_t(rows * columns), {0, 0, 0});
    tbb::parallel_for(0, rows * columns, [&, u = u, v = v](int n) {
        Plane plane(*this, face, hemisphere, out, of_tile[size_t(n)].data());
        Tile tile;
        tile.at = Vec3i(0, 0, 0);
        tile.at[u] = n / columns * 8;
        tile.at[v] = n % columns * 8;
        tile.n = Vec3i(8, 8, 8);
        tile.n[axis] = 1;
        tile.low = as_double(box_.first + tile.at);
        tile.low[axis] = face % 2 ? box_.last[axis] + 0.5 : box_.first[axis] - 0.5;
        tile.high = tile.low + as_double(tile.n - Vec3i(1));
        plane.scale = least_fluence(tile);
        descend(tile, {0}, plane);
    });
    for (const auto& sums : of_tile)
        for (size_t c = 0; c < ahead.size(); ++c) ahead[c] += sums[c];
    return out;
}

}  // namespace vdbcloud
