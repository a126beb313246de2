#include "vdbcloud/scatter/solid_walls.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/voxels/active_box.h"
#include "vdbcloud/voxels/brick_map.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <tuple>
#include <unordered_map>

namespace vdbcloud {

namespace {

Vec3i nearest(const Vec3d& p) { return Vec3i(int(std::lround(p[0])), int(std::lround(p[1])), int(std::lround(p[2]))); }

/// The voxels on either side of an element.
Vec3i behind(const SolidSurface::Element& e) { return nearest(e.at - 0.5 * e.along); }

/// Calls f for a voxel and the 26 about it.
template<typename F>
void about(const Vec3i& voxel, const F& f)
{
    for (int n = 0; n < 27; ++n) f(voxel + Vec3i(n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1));
}

/// The geometry of a grid's voxels.
struct Frame {
    explicit Frame(const FloatGrid& grid) : world(world_from_index(grid.transform(), grid.getName()))
    {
        for (int a = 0; a < 3; ++a) {
            Vec3d unit(0);
            unit[a] = 1;
            axis[a] = world.vector(unit);
            edge[a] = axis[a].length();
            axis[a] /= edge[a];
        }
    }
    Affine world;
    Vec3d axis[3], edge;
};

/// Whether the normal lies nearest to an axis; of equal ones the first counts.
bool is_across(const Vec3d& along, int axis)
{
    for (int a = 0; a < 3; ++a)
        if (std::abs(along[a]) > std::abs(along[axis]) + (a < axis ? -1e-9 : 1e-9)) return false;
    return true;
}

/// The elements on one line: where it goes into solids and, on the way back, where it goes out of them.
class Line {
public:
    Line(const Frame& frame, const SolidRays& solids, int axis, const Vec3d& from, double voxels)
        : frame_(frame), solids_(solids), axis_(axis), from_(from), voxels_(voxels)
    {
    }
    template<typename F>
    void each(const F& found) const
    {
        double done = 0;  // [voxels]
        if (solids_.inside(place(0))) leave(done, found);
        while (done < voxels_) {
            const auto hit = nearest(done, 1, voxels_ - done);
            if (!hit) return;
            done += hit->t / frame_.edge[axis_];
            found(element(*hit, done));
            leave(done, found);
        }
    }

private:
    Vec3d voxel(double along) const
    {
        Vec3d at = from_;
        at[axis_] += along;
        return at;
    }
    Vec3d place(double along) const { return frame_.world.point(voxel(along)); }
    std::optional<SolidHit> nearest(double along, double sign, double voxels) const
    {
        return solids_.nearest({place(along), sign * frame_.axis[axis_]}, voxels * frame_.edge[axis_]);
    }
    SolidSurface::Element element(const SolidHit& hit, double along) const
    {
        SolidSurface::Element e{voxel(along), hit.outside, hit.normal, Vec3d(0), hit.solid};
        for (int a = 0; a < 3; ++a) e.along[a] = hit.normal.dot(frame_.axis[a]);
        return e;
    }
    /// Goes on, voxel by voxel, to the first place in the open.
    template<typename F>
    void leave(double& done, const F& found) const
    {
        const double entered = done;
        do done += done == entered ? 0.5 : 1;
        while (done < voxels_ && solids_.inside(place(done)));
        if (done >= voxels_) return;
        if (const auto hit = nearest(done, -1, done - entered))
            found(element(*hit, done - hit->t / frame_.edge[axis_]));
    }

    const Frame& frame_;
    const SolidRays& solids_;
    int axis_;
    Vec3d from_;
    double voxels_;
};

/// The elements on all lines along an axis, row by row.
std::vector<SolidSurface::Element> seen_along(const Frame& frame, const SolidRays& solids, int axis, const Vec3i& low,
                                              const Vec3i& high)
{
    const auto [u, v] = ActiveBox::axes(axis);
    std::vector<std::vector<SolidSurface::Element>> rows(size_t(high[u] - low[u] + 1));
    tbb::parallel_for(low[u], high[u] + 1, [&, u = u, v = v](int i) {
        for (int j = low[v]; j <= high[v]; ++j) {
            Vec3d from;
            from[axis] = low[axis] - 0.5;
            from[u] = i;
            from[v] = j;
            Line(frame, solids, axis, from, high[axis] - low[axis] + 1).each([&](const SolidSurface::Element& e) {
                if (is_across(e.along, axis)) rows[size_t(i - low[u])].push_back(e);
            });
        }
    });
    std::vector<SolidSurface::Element> all;
    for (const auto& row : rows) all.insert(all.end(), row.begin(), row.end());
    return all;
}

std::vector<SolidSurface::Element> surface_within(const FloatGrid& density, const SolidRays& solids,
                                                  const openvdb::CoordBBox& box, double margin)
{
    const Frame frame(density);
    double longest = 0;
    for (int a = 0; a < 3; ++a) longest = std::max(longest, box.dim()[a] * frame.edge[a]);
    Vec3i low, high;
    for (int a = 0; a < 3; ++a) {
        const int beyond = int(std::min(std::ceil(margin * longest / frame.edge[a]), 4096.0)) + 1;
        low[a] = box.min()[a] - beyond;
        high[a] = box.max()[a] + beyond;
    }
    std::vector<SolidSurface::Element> all;
    for (int axis = 0; axis < 3; ++axis) {
        const auto some = seen_along(frame, solids, axis, low, high);
        all.insert(all.end(), some.begin(), some.end());
    }
    return all;
}

using Place = std::tuple<int, int, int>;

}  // namespace

SolidSurface::SolidSurface(const FloatGrid& density, const SolidRays* solids)
{
    const auto box = density.evalActiveVoxelBoundingBox();
    if (!solids || box.empty()) return;
    const size_t most = std::max(least_elements, size_t(density.activeVoxelCount()));
    for (double share = margin;; share = share < margin / 8 ? 0 : share / 2) {
        elements = surface_within(density, *solids, box, share);
        if (elements.size() <= most || share == 0) break;
    }
    std::set<Place> places;
    for (const Element& e : elements)
        about(behind(e), [&](const Vec3i& voxel) { places.emplace(voxel[0] >> 3, voxel[1] >> 3, voxel[2] >> 3); });
    for (const auto& [x, y, z] : places) blocks.emplace_back(x, y, z);
}

std::vector<double> reflectances(const std::vector<Solid>& solids, int channel)
{
    std::vector<double> all;
    for (const Solid& solid : solids) {
        all.push_back(solid.material.colour[channel]);
        all.push_back(solid.material.checker.value_or(solid.material.colour)[channel]);
    }
    return all;
}

SweepWalls walls_of(const SolidSurface& surface, const SolidRays& solids, const VoxelIndex& index)
{
    const Blocks& blocks = index.blocks();
    std::vector<std::vector<uint32_t>> opaque(blocks.count());
    tbb::parallel_for(size_t(0), blocks.count(), [&](size_t b) {
        for (size_t slot = b * Blocks::size; slot < (b + 1) * Blocks::size; ++slot) {
            if (blocks.active(slot)) continue;
            const Vec3i at = blocks.voxel(slot);
            if (solids.inside(index.world(Vec3d(at[0], at[1], at[2])))) opaque[b].push_back(uint32_t(slot));
        }
    });
    SweepWalls walls;
    std::unordered_map<size_t, uint32_t> number;  // of opaque voxels, by slot
    for (const auto& some : opaque)
        for (const uint32_t slot : some) {
            number[slot] = uint32_t(walls.voxels.size());
            walls.voxels.push_back({slot, 0, 0});
        }
    std::vector<std::vector<uint32_t>> own(walls.voxels.size()), beside(walls.voxels.size());
    for (const SolidSurface::Element& e : surface.elements) {
        const auto n = uint32_t(walls.elements.size());
        uint32_t outside = SweepWalls::nowhere;
        for (const double step : {0.75, 1.25, 1.75}) {
            const size_t slot = blocks.slot(nearest(e.at + step * e.along) - index.origin());
            if (slot >= blocks.count() * Blocks::size || number.count(slot)) continue;
            outside = uint32_t(slot);
            break;
        }
        walls.elements.push_back({e.along, outside});
        const Vec3i middle = behind(e) - index.origin();
        about(middle, [&](const Vec3i& voxel) {
            const auto found = number.find(blocks.slot(voxel));
            if (found != number.end()) (voxel == middle ? own : beside)[found->second].push_back(n);
        });
    }
    for (size_t k = 0; k < walls.voxels.size(); ++k) {
        const std::vector<uint32_t>& seen = own[k].empty() ? beside[k] : own[k];
        walls.voxels[k].first = uint32_t(walls.seen.size());
        walls.voxels[k].count = uint32_t(seen.size());
        walls.seen.insert(walls.seen.end(), seen.begin(), seen.end());
    }
    walls.sort(blocks);
    return walls;
}

void LitWalls::reflect()
{
    light.radiance.resize(direct.size());
    for (size_t e = 0; e < direct.size(); ++e)
        light.radiance[e] = float(double(reflectance[e]) / pi * (double(direct[e]) + double(light.irradiance[e])));
}

}  // namespace vdbcloud
