#include "vdbcloud/sweep/patch_light.h"

#include "vdbcloud/core/constants.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <numeric>

namespace vdbcloud {

namespace {

constexpr int tile = 8;  // cells along the edge of a tile

Vec3d as_double(const Vec3i& v) { return Vec3d(v.x(), v.y(), v.z()); }

}  // namespace

PatchLight::PatchLight(const Blocks& blocks, const SweepSet& set, SweepGround& ground)
    : set_(set), to_(ground), patch_(*ground.patch), box_(blocks), axis_(ground.face / 2),
      down_(ground.face % 2 ? 1 : -1), sum_(patch_.cells(), 0.0), in_void_(patch_.cells(), 1),
      begin_(blocks.count() + 1, 0)
{
    for (size_t m = 0; m < set.count(); ++m) unit_ += std::max(outward(m), 0.0);
    std::vector<std::pair<uint32_t, InBlock>> found;
    for (size_t cell = 0; cell < patch_.cells(); ++cell) {
        const size_t slot = blocks.slot(patch_.middle(cell));
        if (slot >= blocks.count() * Blocks::size) continue;
        in_void_[cell] = 0;
        found.push_back({uint32_t(slot / Blocks::size), {uint32_t(cell), uint16_t(slot % Blocks::size)}});
    }
    std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (const auto& [block, in] : found) {
        ++begin_[block + 1];
        in_block_.push_back(in);
    }
    for (size_t b = 0; b < blocks.count(); ++b) begin_[b + 1] += begin_[b];
    // A tile of cells of one voxel lies in one block's place: its rays are then traced together.
    const auto before = [&](int k) { return patch_.edge == 1 ? patch_.first[size_t(k)] & (tile - 1) : 0; };
    for (int row = -before(0); row < patch_.count[0]; row += tile)
        for (int column = -before(1); column < patch_.count[1]; column += tile)
            if (patch_.edge > 1 || size_t(blocks.slot(patch_.middle(row, column))) >= blocks.count() * Blocks::size)
                tiles_.push_back({row, column});
}

void PatchLight::gather(size_t cell, size_t number, double radiance)
{
    sum_[cell] += outward(number) * (radiance - inflow(number));
}

void PatchLight::add(const SweepPath& path, int d, size_t block, const block_sweep::Scratch& s)
{
    for (uint32_t n = begin_[block]; n < begin_[block + 1]; ++n)
        gather(in_block_[n].cell, path.number, double(s.out[d][in_block_[n].slot]));
}

void PatchLight::add_voids(const std::vector<SweepPath>& batch, const Aprons& aprons, int channel)
{
    tbb::parallel_for(size_t(0), tiles_.size(), [&](size_t n) {
        const auto [row, column] = tiles_[n];
        const Vec3d corner = as_double(patch_.middle(row, column));
        for (size_t d = 0; d < batch.size(); ++d) {
            alignas(32) float radiance[tile * tile];
            float* const to[] = {radiance};
            const uint64_t sky =
                aprons.fill_tile(batch[d], int(d), size_t(channel), 1, corner, ActiveBox::axes(axis_), to, patch_.edge);
            if (!~sky) continue;
            for (int k = 0; k < tile * tile; ++k) {
                const int i = row + k / tile, j = column + k % tile;
                if (sky >> k & 1 || i < 0 || i >= patch_.count[0] || j < 0 || j >= patch_.count[1]) continue;
                const size_t cell = size_t(i) * size_t(patch_.count[1]) + size_t(j);
                if (in_void_[cell]) gather(cell, batch[d].number, double(radiance[k]));
            }
        }
    });
}

void PatchLight::reflect()
{
    to_.irradiance.resize(sum_.size());
    radiance_.resize(sum_.size());
    for (size_t n = 0; n < sum_.size(); ++n) {
        const double diffuse = unit_ > 0 ? sum_[n] * pi / unit_ : 0;
        to_.irradiance[n] = float(diffuse);
        radiance_[n] = float(to_.albedo / pi * (diffuse + to_.direct[n]));
    }
}

double PatchLight::change(const Vec3d& point, const Vec3d& step) const
{
    if (!(step[axis_] * down_ < 0)) return 0;
    const auto [u, v] = ActiveBox::axes(axis_);
    const double back = (point[axis_] - patch_.plane) / step[axis_];
    return patch_.interpolate(radiance_, {point[u] - back * step[u], point[v] - back * step[v]});
}

namespace {

/// Cells of a plane along one axis, some of them together.
struct Strips {
    int first, cells, width;
    Strips(const ActiveBox& box, int axis, int edge)
        : first(box.first[axis]), cells(box.size(axis)), width(std::max(edge, (cells - 1) / 2048 + 1))
    {
    }
    int count() const { return (cells - 1) / width + 1; }
    int size(int n) const { return std::min(width, cells - n * width); }
    double middle(int n) const { return double(first) + double(n) * width + 0.5 * (size(n) - 1); }
};

}  // namespace

double PatchLight::sum_on_plane(int face, const Vec3d& step) const
{
    if (black()) return 0;
    const int axis = face / 2;
    const auto [u, v] = ActiveBox::axes(axis);
    const Strips rows(box_, u, patch_.edge), columns(box_, v, patch_.edge);
    std::vector<double> sums(size_t(rows.count()), 0.0);
    tbb::parallel_for(0, rows.count(), [&, u = u, v = v](int row) {
        Vec3d at;
        at[axis] = face % 2 ? box_.last[axis] + 0.5 : box_.first[axis] - 0.5;
        at[u] = rows.middle(row);
        for (int column = 0; column < columns.count(); ++column) {
            at[v] = columns.middle(column);
            sums[size_t(row)] += double(rows.size(row)) * columns.size(column) * change(at, step);
        }
    });
    return std::accumulate(sums.begin(), sums.end(), 0.0);
}

void PatchLight::write(const Vec3d& spacing, PlaneLight& to) const
{
    for (int face = 0; face < 6; ++face) {
        const int axis = face / 2, side = face % 2 ? 1 : -1;
        double everywhere = 0, changes = 0;
        for (size_t m = 0; m < set_.count(); ++m) {
            const double in = -side * set_.direction[m][axis] * set_.weight[m];
            if (!(in > 0) || !(outward(m) < 0)) continue;
            everywhere += in * inflow(m);
            Vec3d step;
            for (int a = 0; a < 3; ++a) step[a] = set_.direction[m][a] / spacing[a];
            changes += in * sum_on_plane(face, step);
        }
        to.sky_in[size_t(face)] -= everywhere;
        to.ground_in[size_t(face)] = everywhere * double(box_.cells(face)) + changes;
    }
}

}  // namespace vdbcloud
