// Radiance on faces of voxels, and what leaves through the planes of the box.
#include "vdbcloud/sweep/periodic_planes.h"

#include <cmath>

namespace vdbcloud {

using periodic::each;

/// As the reference has it: where light passed the plane of centres half a voxel before the face, at most one voxel
/// aside; outward, in the voxel's own plane.
std::array<PeriodicSweep::Impl::View, 6> PeriodicSweep::Impl::views_of(const Vec3d& step) const
{
    std::array<View, 6> views;
    for (int face = 0; face < 6; ++face) {
        View& view = views[size_t(face)];
        const int axis = face / 2, outward = face % 2 ? 1 : -1, sides[2] = {(axis + 1) % 3, (axis + 2) % 3};
        view.along = step[axis] == 0;
        if (view.along) {
            view.weight[0] = 1;
            continue;
        }
        view.leaves = step[axis] * outward > 0;
        view.half_exit = 0.5 / std::abs(step[axis]);
        double shift[2];
        for (int k = 0; k < 2; ++k) shift[k] = std::min(0.5 * std::abs(step[sides[k]] / step[axis]), 1.0);
        for (size_t n = 0; n < 4; ++n) {
            Vec3i from(0, 0, 0);
            if (!view.leaves) from[axis] += outward;
            for (int k = 0; k < 2; ++k)
                if (n >> k & 1) from[sides[k]] -= step[sides[k]] > 0 ? 1 : -1;
            view.weight[n] = (n & 1 ? shift[0] : 1 - shift[0]) * (n & 2 ? shift[1] : 1 - shift[1]);
            view.row[n] = from[u];
            view.column[n] = from[v];
            view.before[n] = from[w] != 0;
        }
    }
    return views;
}

/// L on a face of a voxel of the plane now, in an existing block.
double PeriodicSweep::Impl::on_face(int d, const Way& way, const Vec3i& voxel, int face) const
{
    const View& view = way.views[size_t(face)];
    const float* planes[2] = {radiance[now][size_t(d)].data(), radiance[1 - now][size_t(d)].data()};
    const auto over_seam = [](int k, int size) { return k < 0 ? k + size : k >= size ? k - size : k; };
    double light = 0;
    for (size_t n = 0; n < 4; ++n)
        if (view.weight[n] > 0)
            light += view.weight[n] * planes[view.before[n]][cell(over_seam(row_of(voxel) + view.row[n], nu),
                                                                  over_seam(column_of(voxel) + view.column[n], nv))];
    if (!view.leaves) return light;
    const size_t own = cell(row_of(voxel), column_of(voxel));
    const float s = sigma[now][own];
    if (!(s > 0)) return light;
    const double e = std::exp(-view.half_exit * s);
    return light * e + source[now][size_t(d)][own] / s * (1 - e);
}

void PeriodicSweep::Impl::tally(int p, int, const std::vector<Way>& ways)
{
    const auto& here = faces[size_t(p - 8 * first_layer)];
    each(int(here.size()), here.size() > 512, [&](int n) {
        const Face& face = here[size_t(n)];
        for (size_t d = 0; d < ways.size(); ++d) {
            const size_t m = ways[d].number;
            const double cosine = (face.face % 2 ? 1 : -1) * set->direction[m][face.face / 2];
            const double weighted = set->weight[m] * on_face(int(d), ways[d], face.voxel, face.face);
            sums[face.number][0] += cosine * weighted;
            sums[face.number][1] += weighted;
            sums[face.number][2] += (cosine * cosine - 1.0 / 3) * weighted;
        }
    });
}

/// The plane p through which light leaves the box: what planes and ground take from cells of existing blocks, or from
/// the other cells. These see blocks up to half a voxel beyond the plane, so they come after the last plane.
void PeriodicSweep::Impl::leave(int p, int sign, const std::vector<Way>& ways, bool of_blocks)
{
    const int face = 2 * w + (sign > 0);
    const bool to_ground = ground && ground->face() == face;
    if ((!with_planes && !to_ground) || (!of_blocks && whole[size_t(layer_of(p))])) return;
    for (size_t d = 0; to_ground && of_blocks && d < ways.size(); ++d)
        ground->gather_unit(set->weight[ways[d].number] * std::abs(set->direction[ways[d].number][w]));
    std::vector<RowSums> rows(size_t(nu), RowSums{});
    each(nu, large, [&](int row) {
        for (int column = 0; column < nv; ++column) {
            Vec3i voxel;
            voxel[w] = p;
            voxel[u] = 8 * first_u + row;
            voxel[v] = 8 * first_v + column;
            if (!box.contains(voxel)) continue;
            if ((block_at(layer_of(p), row >> 3, column >> 3) >= 0) != of_blocks) continue;
            const size_t n = box.cell(face, voxel);
            for (size_t d = 0; d < ways.size(); ++d) {
                const size_t m = ways[d].number;
                const double out = set->weight[m] * std::abs(set->direction[m][w]);
                std::optional<double> light;
                if (of_blocks)
                    light = on_face(int(d), ways[d], voxel, face);
                else {
                    Vec3d point(voxel[0], voxel[1], voxel[2]);
                    point[w] += sign * inside_plane;
                    light = through_void(int(d), ways[d], point);
                }
                if (with_planes) add_cell(face, n, ways[d], out, light, rows[size_t(row)][d]);
                if (to_ground) ground->gather(n, out * light.value_or(ways[d].sky));
            }
        }
    });
    if (with_planes) add_rows(rows, ways, [&](const Way&) { return face; });
}

void PeriodicSweep::Impl::add_cell(int face, size_t cell, const Way& way, double out,
                                   const std::optional<double>& light, std::array<double, 2>& row)
{
    const double power = out * light.value_or(way.sky);
    (light ? from_medium : from_sky)[size_t(face)][cell] += power;
    row[light ? 0 : 1] += power;
}

void PeriodicSweep::Impl::add_rows(const std::vector<RowSums>& rows, const std::vector<Way>& ways,
                                   const std::function<int(const Way&)>& face_of)
{
    for (const RowSums& row : rows)
        for (size_t d = 0; d < ways.size(); ++d) {
            const size_t face = size_t(face_of(ways[d]));
            medium_along[face][ways[d].number] += row[d][0];
            sky_along[face][ways[d].number] += row[d][1];
        }
}

/// The part in plane p of the planes of the box across `aside`, as leave().
void PeriodicSweep::Impl::leave_aside(int p, const std::vector<Way>& ways, bool of_blocks)
{
    if (!with_planes || aside < 0 || p < box.first[w] || p > box.last[w]) return;
    const int along = 3 - w - aside, count = aside == u ? nv : nu;
    std::vector<RowSums> rows(size_t(count), RowSums{});
    each(count, false, [&](int k) {
        for (size_t d = 0; d < ways.size(); ++d) {
            const Vec3d& step = ways[d].step;
            if (step[aside] == 0) continue;
            const int upper = step[aside] > 0, face = 2 * aside + upper;
            Vec3i voxel;
            voxel[w] = p;
            voxel[aside] = (upper ? box.last : box.first)[aside];
            voxel[along] = k;
            if ((block_at(layer_of(p), row_of(voxel) >> 3, column_of(voxel) >> 3) >= 0) != of_blocks) continue;
            const size_t m = ways[d].number, n = box.cell(face, voxel);
            const double out = set->weight[m] * std::abs(set->direction[m][aside]);
            std::optional<double> light;
            if (of_blocks)
                light = on_face(int(d), ways[d], voxel, face);
            else {
                Vec3d point(voxel[0], voxel[1], voxel[2]);
                point[aside] += upper ? inside_plane : -inside_plane;
                light = through_void(int(d), ways[d], point);
            }
            add_cell(face, n, ways[d], out, light, rows[size_t(k)][d]);
        }
    });
    add_rows(rows, ways, [&](const Way& way) { return 2 * aside + (way.step[aside] > 0); });
}

std::optional<double> PeriodicSweep::Impl::through_void(int d, const Way& way, const Vec3d& point) const
{
    const VoidRays::Hit hit = rays.trace(point, way.step);
    if (hit.block >= 0) return light_of(d, way, hit);
    if (upward && ground) return outside(way, point);
    return std::nullopt;
}

}  // namespace vdbcloud
