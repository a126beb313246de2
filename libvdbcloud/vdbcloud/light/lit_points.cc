#include "vdbcloud/light/lit_points.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/optics/cell_march.h"
#include "vdbcloud/optics/optical_depth.h"
#include "vdbcloud/optics/periodic_light.h"
#include "vdbcloud/sweep/light_lattice.h"
#include "vdbcloud/voxels/extend.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace vdbcloud {

WantedPoints::WantedPoints(const FloatGrid& density, int refine_by, const Period& period) : refine(refine_by)
{
    const FloatGridPtr coarse = voxels_with_fringe(density, period);
    if (refine == 1) {
        grid = coarse;
    } else {
        grid = FloatGrid::create(0.0f);
        openvdb::tree::ValueAccessor<openvdb::FloatTree> fine(grid->tree());
        for (auto v = coarse->cbeginValueOn(); v; ++v)
            for (int n = 0; n < refine * refine * refine; ++n)
                fine.setValueOn(openvdb::Coord(v.getCoord()[0] * refine + n / (refine * refine),
                                               v.getCoord()[1] * refine + n / refine % refine,
                                               v.getCoord()[2] * refine + n % refine));
    }
    for (auto it = grid->tree().cbeginLeaf(); it; ++it) {
        leaf.push_back({it->origin()[0] >> 3, it->origin()[1] >> 3, it->origin()[2] >> 3});
        for (openvdb::Index w = 0; w < 8; ++w) bits.push_back(it->getValueMask().getWord<openvdb::Index64>(w));
        voxels += it->onVoxelCount();
    }
}

namespace {

/// Depths on the lattice of `density`, at voxels that lie `shift` from the voxels of the blocks `wanted`.
std::vector<float> shifted_depths(const BrickMap& density, const Vec3d& to_light, const std::vector<Vec3i>& wanted,
                                  const Vec3d& shift, int rays_per_voxel, const Progress& progress)
{
    const Vec3i by(int(std::floor(shift[0])), int(std::floor(shift[1])), int(std::floor(shift[2])));
    const auto before = [](const Vec3i& p, const Vec3i& q) {
        return p[0] != q[0] ? p[0] < q[0] : p[1] != q[1] ? p[1] < q[1] : p[2] < q[2];
    };
    std::vector<Vec3i> blocks;
    for (const Vec3i& b : wanted)
        for (int corner = 0; corner < 8; ++corner) {
            const Vec3i last = b * 8 + by + Vec3i(corner & 1, corner >> 1 & 1, corner >> 2) * 7;
            blocks.push_back({last[0] >> 3, last[1] >> 3, last[2] >> 3});
        }
    std::sort(blocks.begin(), blocks.end(), before);
    blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
    const std::vector<float> there =
        lattice_depths(density, to_light, blocks, {rays_per_voxel, shift - Vec3d(by[0], by[1], by[2]), 1}, progress);
    std::vector<float> depth(wanted.size() * 512);
    tbb::parallel_for(size_t(0), wanted.size(), [&](size_t b) {
        for (int k = 0; k < 512; ++k) {
            const Vec3i voxel = wanted[b] * 8 + Vec3i(k >> 6, k >> 3 & 7, k & 7) + by;
            const Vec3i block(voxel[0] >> 3, voxel[1] >> 3, voxel[2] >> 3);
            const auto place = size_t(std::lower_bound(blocks.begin(), blocks.end(), block, before) - blocks.begin());
            depth[b * 512 + size_t(k)] =
                there[place * 512 + size_t((voxel[0] & 7) << 6 | (voxel[1] & 7) << 3 | (voxel[2] & 7))];
        }
    });
    return depth;
}

/// Depths at all wanted points to one light without extent, through one medium. `centres`: the density whose voxels the
/// points belong to.
std::vector<float> find_depths(const Crossed& medium, const BrickMap& centres, const LightModel& light,
                               const TransmittanceOptions& o, const WantedPoints& wanted, const Progress& progress,
                               std::atomic<size_t>* products = nullptr)
{
    const BrickMap& density = medium.density;
    const auto to_light = light.common_direction();
    if (to_light && o.fidelity == Fidelity::Lattice && medium.shift && !density.repeats()) {
        if (*medium.shift == Vec3d(0.0))
            return lattice_depths(density, *to_light, wanted.leaf, {o.rays_per_voxel, Vec3d(0), o.refine, products},
                                  progress);
        if (o.refine == 1)
            return shifted_depths(density, *to_light, wanted.leaf, *medium.shift, o.rays_per_voxel, progress);
    }
    std::vector<float> depth(wanted.leaf.size() * 512, 0.0f);
    std::atomic<size_t> done{0};
    tbb::parallel_for(size_t(0), wanted.leaf.size(), [&](size_t b) {
        for (size_t n = b * 512; n < (b + 1) * 512; ++n)
            if (wanted.has(n)) depth[n] = float(depth_to_light(density, light, wanted.world(n, centres)));
        report(progress, double(++done) / double(wanted.leaf.size()));
    });
    return depth;
}

/// True if the depth is above 0 at a wanted point.
bool shades(const std::vector<float>& depth, const WantedPoints& wanted)
{
    for (size_t n = 0; n < depth.size(); ++n)
        if (depth[n] > 0 && wanted.has(n)) return true;
    return false;
}

/// Whether solids hide a light without extent from x.
bool hidden(const SolidRays& solids, const LightModel& light, const Vec3d& x)
{
    const Sight sight = light.towards(x);
    return solids.blocked({x, sight.direction}, sight.distance);
}

}  // namespace

std::vector<float> find_transmittance(const std::vector<Crossed>& media,
                                      const std::vector<std::shared_ptr<const LightModel>>& parts, size_t channels,
                                      bool only_if_shaded, const SolidRays& solids, const TransmittanceOptions& o,
                                      const WantedPoints& wanted, const Progress& progress,
                                      std::atomic<size_t>* products)
{
    const double steps = double(parts.size() * media.size());
    const auto depths = [&](size_t p, size_t m) {
        const double before = double(p * media.size() + m);
        const Progress of_step =
            progress ? Progress([&, before](double f) { return progress((before + f) / steps); }) : Progress();
        return find_depths(media[m], media[0].density, *parts[p], o, wanted, of_step, products);
    };
    std::vector<float> transmittance(wanted.leaf.size() * 512 * channels, 0.0f);
    bool shaded = !only_if_shaded;
    for (size_t p = 0; p < parts.size(); ++p) {
        std::vector<std::vector<float>> depth(media.size());
        for (size_t m = 1; m < media.size(); ++m) {
            depth[m] = depths(p, m);
            shaded = shaded || shades(depth[m], wanted);
        }
        if (!shaded && parts.size() == 1) return {};
        depth[0] = depths(p, 0);
        tbb::parallel_for(size_t(0), wanted.leaf.size(), [&](size_t b) {
            for (size_t n = b * 512; n < (b + 1) * 512; ++n) {
                if (!solids.empty() && wanted.has(n) && hidden(solids, *parts[p], wanted.world(n, media[0].density)))
                    continue;
                for (size_t c = 0; c < channels; ++c) {
                    double tau = 0;
                    for (size_t m = 0; m < media.size(); ++m) tau += media[m].sigma_t[int(c)] * depth[m][n];
                    transmittance[n * channels + c] += float(std::exp(-tau) / double(parts.size()));
                }
            }
        });
    }
    if (!shaded) transmittance.clear();
    return transmittance;
}

void compare_with_rays(const BrickMap& density, const Medium& medium,
                       const std::vector<std::shared_ptr<const LightModel>>& parts, const SolidRays& solids,
                       const TransmittanceOptions& o, const WantedPoints& wanted,
                       const std::vector<float>& transmittance, size_t channels, TransmittanceReport& report)
{
    std::vector<size_t> sample;
    const size_t step = std::max<size_t>(1, size_t(report.voxels) / size_t(std::max(1, o.error_samples)));
    size_t seen = 0;
    for (size_t n = 0; n < wanted.leaf.size() * 512; ++n)
        if (wanted.has(n))
            if (seen++ % step == step / 2) sample.push_back(n);
    std::vector<double> error(sample.size());
    tbb::parallel_for(size_t(0), sample.size(), [&](size_t s) {
        double exact = 0;
        const Vec3d x = wanted.world(sample[s], density);
        for (const auto& part : parts)
            if (solids.empty() || !hidden(solids, *part, x))
                exact += std::exp(-medium.sigma_t_per_density[0] * depth_to_light(density, *part, x));
        error[s] = std::abs(exact / double(parts.size()) - transmittance[sample[s] * channels]);
    });
    report.compared = int(error.size());
    for (const double e : error) {
        report.mean_error += e / double(error.size());
        report.max_error = std::max(report.max_error, e);
    }
}

int64_t dark_points(const std::vector<float>& transmittance, size_t channels, const WantedPoints& wanted)
{
    int64_t dark = 0;
    for (size_t n = 0; n < wanted.leaf.size() * 512; ++n)
        dark += wanted.has(n) && std::all_of(&transmittance[n * channels], &transmittance[n * channels] + channels,
                                             [](float t) { return t == 0; });
    return dark;
}

}  // namespace vdbcloud
