#include "vdbcloud/scatter/voxel_error.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/voxels/coarser.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace vdbcloud {

namespace {

/// What a solve that serves for a comparison alone needs.
ScatterOptions bare(ScatterOptions options)
{
    options.reentry_rays = options.line_rays = 0;
    options.flux_map = options.heating = false;
    options.keep_moments = 1;
    return options;
}

/// The first axis along which a medium repeats after another number of voxels than a multiple of 16, so that voxels of
/// twice the edge would not fill whole blocks; 3 if there is none.
int odd_axis(const FloatGrid& density, const ScatterOptions& o)
{
    const openvdb::Coord size = density.evalActiveVoxelBoundingBox().dim();
    for (int a = 0; a < 3; ++a)
        if (o.periodic[size_t(a)] && size[a] % 16 != 0) return a;
    return 3;
}

void require_even(const FloatGrid& density, const ScatterOptions& o)
{
    const int a = odd_axis(density, o);
    if (a == 3 || density.empty()) return;
    const int length = density.evalActiveVoxelBoundingBox().dim()[a];
    throw InputError("grid '" + printable(density.getName()) + "': it repeats along " + "xyz"[a] + " after " +
                     std::to_string(length) +
                     " voxels: to measure the error of voxels, expected a multiple of 16, such as " +
                     std::to_string((length / 16 + 1) * 16));
}

/// Reads phi of all channels at a voxel.
class Fluence {
public:
    explicit Fluence(const CollidedLight& light) : scale_(light.channel_scale)
    {
        if (auto one = openvdb::gridPtrCast<FloatGrid>(light.phi)) one_.emplace(one->getConstAccessor());
        if (auto three = openvdb::gridPtrCast<Vec3SGrid>(light.phi)) three_.emplace(three->getConstAccessor());
    }
    Vec3d operator()(const openvdb::Coord& voxel) const
    {
        if (one_) return double(one_->getValue(voxel)) * scale_;
        return Vec3d(three_->getValue(voxel));
    }

private:
    Vec3d scale_;
    std::optional<FloatGrid::ConstAccessor> one_;
    std::optional<Vec3SGrid::ConstAccessor> three_;
};

double difference(const FloatGrid& fine, const CollidedLight& fine_light, const FloatGrid& coarse,
                  const CollidedLight& coarse_light)
{
    const openvdb::Coord first = fine.evalActiveVoxelBoundingBox().min();
    const auto density = fine.getConstAccessor();
    const Fluence in_fine(fine_light), in_coarse(coarse_light);
    Vec3d squares(0, 0, 0), norm(0, 0, 0);
    for (auto v = coarse.cbeginValueOn(); v; ++v) {
        const openvdb::Coord corner(first + (v.getCoord() << 1));
        Vec3d mean(0, 0, 0);
        for (int k = 0; k < 8; ++k) {
            const openvdb::Coord p = corner.offsetBy(k & 1, k >> 1 & 1, k >> 2);
            if (const float w = density.getValue(p); density.isValueOn(p) && w > 0) mean += w / (8.0 * *v) * in_fine(p);
        }
        const Vec3d d = in_coarse(v.getCoord()) - mean;
        squares += *v * d * d;
        norm += *v * mean * mean;
    }
    double worst = 0;
    for (int c = 0; c < 3; ++c)
        if (norm[c] > 0) worst = std::max(worst, std::sqrt(squares[c] / norm[c]));
    return worst;
}

}  // namespace

VoxelError voxel_error(const FloatGrid& density, const Vec3SGrid* tint, const Vec3SGrid* emission, const Medium& medium,
                       const std::vector<Light>& lights, const ScatterOptions& options, const CollidedLight& light,
                       const Progress& progress, Workload& work)
{
    const auto solve = [&](const CoarserMedium& m, double from, double to) {
        ScatterReport report;
        const auto part = [&](double f) { return !progress || progress(from + (to - from) * f); };
        CollidedLight solved =
            scatter_p1(*m.density, m.tint.get(), m.emission.get(), medium, lights, bare(options), part, report);
        work += report.work;
        return solved;
    };
    VoxelError error;
    if (!light.phi) return error;
    require_even(density, options);
    const CoarserMedium twice = coarser(density, tint, emission);
    const CollidedLight of_twice = solve(twice, 0, 0.9);
    error.twice = difference(density, light, *twice.density, of_twice);
    if (odd_axis(*twice.density, options) == 3) {
        const CoarserMedium four = coarser(*twice.density, twice.tint.get(), twice.emission.get());
        error.four = difference(*twice.density, of_twice, *four.density, solve(four, 0.9, 1));
    }
    if (error.four > 0 && error.twice > 0) error.order = std::clamp(std::log2(error.four / error.twice), 1.0, 2.0);
    error.error = error.twice / (std::exp2(error.order) - 1);
    return error;
}

ScatterPlan voxel_error_plan(const FloatGrid& density, const Vec3SGrid* tint, const Vec3SGrid* emission,
                             const Medium& medium, const std::vector<Light>& lights, const ScatterOptions& options,
                             bool count)
{
    const auto plan_of = [&](const CoarserMedium& m) {
        return scatter_plan(*m.density, m.tint.get(), m.emission.get(), medium, lights, bare(options), count);
    };
    require_even(density, options);
    const CoarserMedium twice = coarser(density, tint, emission);
    ScatterPlan plan = plan_of(twice);
    if (odd_axis(*twice.density, options) == 3) {
        const ScatterPlan four = plan_of(coarser(*twice.density, twice.tint.get(), twice.emission.get()));
        plan.work += four.work;
        plan.bytes = std::max(plan.bytes, plan.grid_bytes + four.bytes);
    }
    return plan;
}

}  // namespace vdbcloud
