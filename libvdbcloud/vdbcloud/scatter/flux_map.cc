#include "vdbcloud/scatter/flux_map.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/scatter/beam_medium.h"
#include "vdbcloud/scatter/second_moment.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <numeric>

namespace vdbcloud {

namespace {

constexpr size_t most_columns = size_t(1) << 26;  // 4 GB for the five maps of three channels

Vec3d as_double(const Vec3i& v) { return Vec3d(v.x(), v.y(), v.z()); }

}  // namespace

const std::array<FluxMapLayer, 5>& flux_map_layers()
{
    using C = FluxMap::Channel;
    static const std::array<FluxMapLayer, 5> all{{{"diffuse_up", &C::diffuse_up},
                                                  {"diffuse_down", &C::diffuse_down},
                                                  {"direct_top", &C::direct_top},
                                                  {"direct_base", &C::direct_base},
                                                  {"absorbed", &C::absorbed}}};
    return all;
}

double power_of(const FluxMap& map, const std::vector<float>& values)
{
    return std::accumulate(values.begin(), values.end(), 0.0) * map.column_area;
}

FluxMap columns_of(const VoxelIndex& index, const Vec3d& up)
{
    const ActiveBox box(index.blocks());
    const int axis = frame_of(index, {false, false, false}, up).polar;
    if (box.periodic[size_t(axis)])
        throw InputError(std::string("a map by column along ") + "xyz"[axis] +
                         ": expected a medium that ends along this axis");
    const auto [u, v] = ActiveBox::axes(axis);
    FluxMap map;
    const bool rising = index.axis(axis).dot(up) > 0;
    map.top = 2 * axis + rising;
    map.base = map.top ^ 1;
    if (box.cells(2 * axis) > most_columns)
        throw InputError("a map by column of " + std::to_string(box.size(u)) + " x " + std::to_string(box.size(v)) +
                         " voxels: expected at most 2^26 columns");
    map.width = box.size(u);
    map.height = box.size(v);
    Vec3d corner = as_double(box.first);
    corner[axis] = rising ? box.first[axis] - 0.5 : box.last[axis] + 0.5;
    map.first = index.world(corner);
    map.step_x = index.spacing()[u] * index.axis(u);
    map.step_y = index.spacing()[v] * index.axis(v);
    map.column_area = index.spacing()[u] * index.spacing()[v];
    return map;
}

std::vector<float> by_pixel(const FluxMap& map, const std::vector<float>& cells)
{
    std::vector<float> pixels;
    pixels.reserve(cells.size());
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) pixels.push_back(cells[size_t(x) * size_t(map.height) + size_t(y)]);
    return pixels;
}

namespace {

/// Irradiance of a plane's cell by the beam of a light of strength 1, times its transmittance; above 0 where the beam
/// goes along `down`.
double direct_at(const VoxelIndex& index, const BeamMedium& medium, const Light& light, int face, Vec3d cell,
                 const Vec3d& down)
{
    const int axis = face / 2;
    cell[axis] += face % 2 ? 0.5 : -0.5;
    const Vec3d place = index.world(cell);
    const Sight sight = light->towards(place);
    const double cosine = -sight.direction.dot(down);
    if (cosine == 0) return 0;
    Vec3d travel;  // [voxels]
    for (int a = 0; a < 3; ++a) travel[a] = -sight.direction.dot(index.axis(a)) / index.spacing()[a];
    const bool leaves = (travel[axis] > 0) == (face % 2 == 1);
    const Vec3d out = travel * ((leaves ? 0.5 : -0.5) / std::abs(travel[axis]));  // beyond it there is no density
    return cosine * light->irradiance(place) * std::exp(-medium.extinction() * medium.depth(cell + out, light));
}

}  // namespace

std::vector<float> direct_on_plane(const VoxelIndex& index, const BeamMedium& medium, const std::vector<Light>& lights,
                                   int c, int face, const Vec3d& down)
{
    const ActiveBox box(index.blocks());
    std::vector<float> cells(box.cells(face));
    tbb::parallel_for(size_t(0), cells.size(), [&](size_t cell) {
        double sum = 0;
        for (const Light& light : lights)
            sum += light.strength()[c] * direct_at(index, medium, light, face, as_double(box.voxel(face, cell)), down);
        cells[cell] = float(sum);
    });
    return cells;
}

void add_direct(const VoxelIndex& index, const BeamMedium& medium, const std::vector<Light>& lights, int c,
                const FluxMap& map, FluxMap::Channel& to)
{
    const Vec3d down = index.axis(map.top / 2) * (map.top % 2 ? -1.0 : 1.0);
    for (const int face : {map.top, map.base})
        (face == map.top ? to.direct_top : to.direct_base) =
            by_pixel(map, direct_on_plane(index, medium, lights, c, face, down));
}

void add_absorbed(const VoxelIndex& index, const std::vector<float>& heating, const FluxMap& map, FluxMap::Channel& to)
{
    const Blocks& blocks = index.blocks();
    const ActiveBox box(blocks);
    const int axis = map.top / 2;
    const auto [u, v] = ActiveBox::axes(axis);
    std::vector<double> sums(box.cells(map.top), 0.0);
    for (size_t slot = 0; slot < blocks.count() * Blocks::size; ++slot) {
        if (!blocks.active(slot)) continue;
        const Vec3i at = blocks.voxel(slot) - box.first;
        sums[size_t(at[v]) * size_t(map.width) + size_t(at[u])] += heating[slot] * index.spacing()[axis];
    }
    to.absorbed.assign(sums.begin(), sums.end());
}

void share_channel(int from, int to, double scale, FluxMap& map)
{
    map.channel[size_t(to)] = map.channel[size_t(from)];
    for (const FluxMapLayer& layer : flux_map_layers())
        for (float& value : map.channel[size_t(to)].*layer.values) value = float(scale * value);
}

}  // namespace vdbcloud
