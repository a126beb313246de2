#include "vdbcloud/scatter/multiple_scattering.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/random.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbcloud {

namespace {

/// True if a ray (voxel coordinates) meets an active voxel before it leaves the blocks' bounds.
bool hits(const Blocks& blocks, Vec3d p, const Vec3d& d, const Vec3i& lo, const Vec3i& hi)
{
    for (int step = 0; step < 100000; ++step) {
        const Vec3i voxel(int(std::floor(p[0] + 0.5)), int(std::floor(p[1] + 0.5)), int(std::floor(p[2] + 0.5)));
        for (int a = 0; a < 3; ++a)
            if (blocks.period()[a] == 0 && ((voxel[a] < lo[a] && d[a] <= 0) || (voxel[a] > hi[a] && d[a] >= 0)))
                return false;
        const size_t slot = blocks.slot(voxel);
        if (blocks.active(slot)) return true;
        const int edge = slot / 512 < blocks.count() ? 1 : 8;  // a missing block is crossed in one step
        double t = std::numeric_limits<double>::infinity();
        for (int a = 0; a < 3; ++a) {
            if (d[a] == 0) continue;
            const double low = (edge == 1 ? voxel[a] : (voxel[a] >> 3) * 8) - 0.5;
            t = std::min(t, ((d[a] > 0 ? low + edge : low) - p[a]) / d[a]);
        }
        p += d * (std::max(t, 0.0) + 1e-6);
    }
    return false;
}

}  // namespace

double reentry_share(const P1Operator& p1, const P1Source& source, const std::vector<double>& phi, int rays)
{
    const Blocks& blocks = p1.blocks();
    const auto& exposed = p1.exposed();
    if (exposed.empty() || rays <= 0) return 0;
    Vec3i lo(std::numeric_limits<int>::max()), hi(std::numeric_limits<int>::min());
    for (size_t b = 0; b < blocks.count(); ++b)
        for (int a = 0; a < 3; ++a) {
            lo[a] = std::min(lo[a], 8 * blocks.at(b)[a]);
            hi[a] = std::max(hi[a], 8 * blocks.at(b)[a] + 7);
        }
    const size_t samples = std::min(exposed.size(), size_t(rays)), each = std::max<size_t>(1, size_t(rays) / samples);
    std::vector<double> all(samples, 0.0), back(samples, 0.0);
    tbb::parallel_for(size_t(0), samples, [&](size_t n) {
        const size_t k = n * exposed.size() / samples;
        const ExposedVoxel& voxel = exposed[k];
        Vec3d normal(0, 0, 0);
        double power = 0;
        for (int face = 0; face < 6; ++face) {
            if (!(voxel.faces >> face & 1)) continue;
            normal[face / 2] += face % 2 ? voxel.weight[face / 2] : -voxel.weight[face / 2];
            power += std::max(0.0, p1.conductance(voxel, face / 2) * phi[voxel.slot] + double(source.outflow[k][face]));
        }
        if (!(normal.length() > 1e-3)) return;
        normal.normalize();
        const Vec3d t = (std::abs(normal[0]) < 0.5 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0)).cross(normal).unit(),
                    u = normal.cross(t);
        const Vec3i at = blocks.voxel(voxel.slot);
        for (size_t r = 0; r < each; ++r) {
            const double z2 = uniform(hash_bits(17, k, r, 0)), turn = 2 * pi * uniform(hash_bits(17, k, r, 1));
            const double c = std::sqrt(z2), s = std::sqrt(1 - z2);
            Vec3d d = normal * c + t * (s * std::cos(turn)) + u * (s * std::sin(turn));
            for (int a = 0; a < 3; ++a) d[a] /= p1.index().spacing()[a] / p1.hbar();
            // Start two voxels out along the normal, so that the staircase of the surface does not count as a hit.
            const Vec3d start = Vec3d(at[0], at[1], at[2]) + normal * 2.0;
            all[n] += power;
            if (hits(blocks, start, d, lo, hi)) back[n] += power;
        }
    });
    double total = 0, returned = 0;
    for (size_t n = 0; n < samples; ++n) {
        total += all[n];
        returned += back[n];
    }
    return total > 0 ? returned / total : 0;
}

}  // namespace vdbcloud
