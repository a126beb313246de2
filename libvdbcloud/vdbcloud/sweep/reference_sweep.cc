#include "vdbcloud/core/error.h"
#include "vdbcloud/sweep/block_walk.h"
#include "vdbcloud/sweep/ground_sums.h"
#include "vdbcloud/sweep/patch_light.h"
#include "vdbcloud/sweep/transport_sweep.h"
#include "vdbcloud/sweep/void_rays.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_map>

namespace vdbcloud {

namespace {

/// One direction through one medium.
class Scalar {
public:
    /// `ground`: where directions that come from beneath begin, instead of the sky; null: none. `patch`: what changes
    /// their beginning in the sky; null: nothing. `walls`: null: none.
    Scalar(const VoxelIndex& index, const VoidRays& rays, const SweepFields& fields, const Vec3d& direction,
           const float* basis, double sky, const GroundSums* ground, const PatchLight* patch, const WallLight* walls)
        : blocks_(index.blocks()), rays_(rays), sigma_(*fields.sigma_t), emission_(fields.emission), sky_(sky),
          ground_(ground && !ground->leaves(direction) ? ground : nullptr), patch_(patch),
          radiance_(blocks_.slots(), 0.0), q_(blocks_.slots(), 0.0)
    {
        if (walls)
            for (const SweepWalls::Voxel& voxel : walls->walls->voxels)
                wall_[voxel.slot] = double(walls->along(voxel, direction));
        for (int a = 0; a < 3; ++a) step_[a] = direction[a] / index.spacing()[a];
        w_ = -1;
        for (int a = 0; a < 3; ++a)
            if (!blocks_.period()[a] && step_[a] != 0 && (w_ < 0 || std::abs(step_[a]) > std::abs(step_[w_]))) w_ = a;
        if (w_ < 0) throw InputError("a direction along periodic axes only: expected one that leaves the medium");
        for (size_t k = 0; k < fields.source->size(); ++k)
            for (size_t slot = 0; slot < q_.size(); ++slot) q_[slot] += double(basis[k]) * (*fields.source)[k][slot];
    }

    void sweep()
    {
        std::vector<std::pair<int, size_t>> order;  // planes upstream first
        for (size_t slot = 0; slot < blocks_.count() * 512; ++slot)
            order.push_back({step_[w_] > 0 ? blocks_.voxel(slot)[w_] : -blocks_.voxel(slot)[w_], slot});
        std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
        for (const auto& [plane, slot] : order) {
            const auto wall = wall_.find(slot);
            radiance_[slot] = wall != wall_.end() ? wall->second : at_voxel(blocks_.voxel(slot), slot);
        }
    }

    double radiance(size_t slot) const { return radiance_[slot]; }

    /// L on a face of an active voxel.
    double on_face(size_t slot, int face) const
    {
        const int axis = face / 2, outward = face % 2 ? 1 : -1, u = (axis + 1) % 3, v = (axis + 2) % 3;
        if (step_[axis] == 0) return radiance_[slot];
        const bool leaves = step_[axis] * outward > 0;
        const auto aside = [&](int a) { return std::min(0.5 * std::abs(step_[a] / step_[axis]), 1.0); };
        double radiance = 0;  // where light passed the plane of centres
        for (int n = 0; n < 4; ++n) {
            Vec3i from = blocks_.voxel(slot);
            if (!leaves) from[axis] += outward;
            if (n & 1) from[u] -= step_[u] > 0 ? 1 : -1;
            if (n & 2) from[v] -= step_[v] > 0 ? 1 : -1;
            const double weight = (n & 1 ? aside(u) : 1 - aside(u)) * (n & 2 ? aside(v) : 1 - aside(v));
            if (weight > 0) radiance += weight * value(from).radiance;
        }
        if (!leaves) return radiance;
        const double e = std::exp(-0.5 * sigma_[slot] / std::abs(step_[axis]));
        return radiance * e + q_[slot] * (1 - e);
    }

    /// L where a ray comes from the sky.
    double sky(const Vec3d& point) const { return sky_ + (patch_ ? patch_->change(point, step_) : 0); }

    /// L at a voxel's centre; nothing where the ray comes from the sky.
    std::optional<double> at_centre(const Vec3i& voxel) const
    {
        const size_t slot = blocks_.slot(voxel);
        if (slot < blocks_.count() * 512) return radiance_[slot];
        return through_void(Vec3d(voxel.x(), voxel.y(), voxel.z()));
    }

    /// L at the middle of a cell of the box's plane; nothing where the ray comes from the sky.
    std::optional<double> on_plane(const Vec3i& voxel, int face) const
    {
        const size_t slot = blocks_.slot(voxel);
        return slot < blocks_.count() * 512 ? on_face(slot, face) : through_void(in_plane(voxel, face));
    }
    static Vec3d in_plane(const Vec3i& voxel, int face)
    {
        Vec3d point(voxel.x(), voxel.y(), voxel.z());
        point[face / 2] += face % 2 ? inside_plane : -inside_plane;
        return point;
    }

private:
    struct Point {
        double radiance, sigma, q;
    };

    /// L at a point in a missing block; nothing where the ray comes from the sky.
    std::optional<double> through_void(const Vec3d& point) const
    {
        const auto hit = rays_.trace(point, step_);
        if (hit.block < 0) return ground_ ? std::optional(ground_->radiance(point, step_)) : std::nullopt;
        double sum = 0;
        for (int axis = 0; axis < 3; ++axis)
            if (hit.axes >> axis & 1) sum += on_block(hit, axis) / __builtin_popcount(unsigned(hit.axes));
        return sum;
    }

    /// After the half voxel beyond a centre, along an axis; the extinction falls to 0 over a whole one.
    double emergent(size_t slot, int axis) const
    {
        const double e = std::exp(-0.5 * sigma_[slot] / std::abs(step_[axis]));
        return radiance_[slot] * e + q_[slot] * (1 - e);
    }

    Point value(const Vec3i& voxel) const
    {
        const size_t slot = blocks_.slot(voxel);
        if (slot < blocks_.count() * 512) return {radiance_[slot], sigma_[slot], q_[slot]};
        const Vec3d point(voxel.x(), voxel.y(), voxel.z());
        return {through_void(point).value_or(sky(point)), 0, 0};
    }

    /// What leaves a block through its downstream face across `axis`, where a ray meets it.
    double on_block(const VoidRays::Hit& hit, int axis) const
    {
        static constexpr int stride[3] = {64, 8, 1};
        const int other[2] = {axis == 0 ? 1 : 0, axis == 2 ? 1 : 2};
        int cell[2];
        double f[2];
        for (int k = 0; k < 2; ++k) {  // light met the centres' plane half a step before
            const double at = std::clamp(hit.at[other[k]] - 0.5 * step_[other[k]] / std::abs(step_[axis]), 0.0, 7.0);
            cell[k] = std::min(int(at), 6);
            f[k] = at - cell[k];
        }
        const size_t base = size_t(hit.block) * 512 + (step_[axis] > 0 ? 7 * stride[axis] : 0);
        // A ray through an edge may meet a face that touches another block.
        const bool open =
            size_t(blocks_.neighbours(size_t(hit.block))[2 * axis + (step_[axis] > 0)]) == blocks_.count();
        double sum = 0;
        for (int n = 0; n < 4; ++n) {
            const size_t slot = base + (cell[0] + (n & 1)) * stride[other[0]] + (cell[1] + (n >> 1)) * stride[other[1]];
            sum +=
                (n & 1 ? f[0] : 1 - f[0]) * (n & 2 ? f[1] : 1 - f[1]) * (open ? emergent(slot, axis) : radiance_[slot]);
        }
        return sum;
    }

    double at_voxel(const Vec3i& voxel, size_t slot) const
    {
        const double ds = 1 / std::abs(step_[w_]);  // length of a step from plane to plane
        const int u = (w_ + 1) % 3, v = (w_ + 2) % 3;
        const double pu = voxel[u] - snapped(step_[u] * ds), pv = voxel[v] - snapped(step_[v] * ds);
        const int iu = int(std::floor(pu)), iv = int(std::floor(pv));
        const double fu = pu - iu, fv = pv - iv;
        double radiance = 0, sigma = 0, source = 0;
        for (int n = 0; n < 4; ++n) {
            const double weight = (n & 1 ? fu : 1 - fu) * (n & 2 ? fv : 1 - fv);
            if (weight == 0) continue;
            Vec3i from = voxel;
            from[w_] -= step_[w_] > 0 ? 1 : -1;
            from[u] = iu + (n & 1);
            from[v] = iv + (n >> 1);
            const Point p = value(from);
            radiance += weight * p.radiance;
            sigma += weight * p.sigma;
            source += weight * p.sigma * p.q;
        }
        const double before = sigma > 0 ? source / sigma : q_[slot], q = sigma_[slot] > 0 ? q_[slot] : before;
        const double tau = 0.5 * (sigma + sigma_[slot]) * ds, e = std::exp(-tau), lost = -std::expm1(-tau);
        const double lean = 0.5 * (sigma_[slot] - sigma) * ds / (6 + tau * (3 + tau));
        const double weight = emission_ ? emission_weight(sigma, sigma_[slot], ds) * lost : slope(tau) - lean;
        return radiance * e + q * lost + (before - q) * weight;
    }

    static double slope(double tau) { return tau > 1e-5 ? -std::expm1(-tau) / tau - std::exp(-tau) : tau / 2; }

    static double emission_weight(double before, double sigma, double ds)
    {
        const double x = sigma * ds, part = before + sigma > 0 ? before / (before + sigma) : 0.0;
        return x > 1e-4 ? 2 * part * slope(x) / -std::expm1(-x) : part * (1 - x / 6);
    }

    const Blocks& blocks_;
    const VoidRays& rays_;
    const std::vector<float>& sigma_;
    bool emission_;
    double sky_;
    const GroundSums* ground_;
    const PatchLight* patch_;
    Vec3d step_;  // voxels per world unit
    int w_;
    std::vector<double> radiance_, q_;
    std::unordered_map<size_t, double> wall_;  // by slot
};

}  // namespace

namespace {

/// Sums of PlaneLight.
class PlaneSums {
public:
    PlaneSums(const Blocks& blocks, const SweepSet& set) : box_(blocks)
    {
        medium_along_.fill(std::vector<double>(set.count(), 0.0));
        sky_along_ = medium_along_;
        for (int face = 0; face < 6; ++face)
            medium_[face].assign(box_.cells(face), 0.0), sky_[face].assign(box_.cells(face), 0.0);
    }

    void add(const Scalar& one, const SweepSet& set, size_t m)
    {
        for (int face = 0; face < 6; ++face) {
            const double out = set.weight[m] * (face % 2 ? 1 : -1) * set.direction[m][face / 2];
            for (size_t cell = 0; out > 0 && cell < box_.cells(face); ++cell) {
                const Vec3i voxel = box_.voxel(face, cell);
                const auto radiance = one.on_plane(voxel, face);
                const double power = out * radiance.value_or(one.sky(Scalar::in_plane(voxel, face)));
                (radiance ? medium_ : sky_)[face][cell] += power;
                (radiance ? medium_along_ : sky_along_)[size_t(face)][m] += power;
            }
        }
    }

    void write(const SweepSet& set, PlaneLight& to) const
    {
        set_half_ranges(set, to);
        to.medium_along = medium_along_;
        to.sky_along = sky_along_;
        for (size_t face = 0; face < 6; ++face) {
            to.from_medium[face].assign(medium_[face].begin(), medium_[face].end());
            to.from_sky[face].assign(sky_[face].begin(), sky_[face].end());
        }
    }

private:
    ActiveBox box_;
    std::vector<double> medium_[6], sky_[6];
    std::array<std::vector<double>, 6> medium_along_, sky_along_;
};

/// The directions of a set; over a ground those that leave through it come first.
template<typename Ground>
std::vector<size_t> order_of(const SweepSet& set, const Ground* ground)
{
    std::vector<size_t> order(set.count());
    for (size_t m = 0; m < order.size(); ++m) order[m] = m;
    if (ground)
        std::stable_partition(order.begin(), order.end(), [&](size_t m) { return ground->leaves(set.direction[m]); });
    return order;
}

}  // namespace

void reference_sweep(const VoxelIndex& index, const std::vector<SweepFace>& faces, const SweepSet& set,
                     const SweepFields& fields, SweepResult& result, PlaneLight* planes, SweepGround* with_ground,
                     WallLight* walls)
{
    const Blocks& blocks = index.blocks();
    PlaneSums on_planes(blocks, set);
    const VoidRays rays(blocks);
    std::optional<GroundSums> ground;
    std::optional<PatchLight> patch;
    std::optional<WallSums> on_walls;
    if (walls) on_walls.emplace(*walls);
    if (with_ground && with_ground->patch)
        patch.emplace(blocks, set, *with_ground);
    else if (with_ground)
        ground.emplace(blocks, *with_ground);
    const std::vector<size_t> order = patch && !patch->black()     ? order_of(set, &*patch)
                                      : ground && !ground->black() ? order_of(set, &*ground)
                                                                   : order_of<GroundSums>(set, nullptr);
    bool reflected = (!ground || ground->black()) && (!patch || patch->black());
    std::vector<std::vector<double>> moments(size_t(set.moment_terms), std::vector<double>(blocks.slots(), 0.0));
    std::vector<std::array<double, 3>> tally(faces.size(), {0, 0, 0});
    for (const size_t m : order) {
        const bool to_ground = ground && ground->leaves(set.direction[m]),
                   to_patch = patch && patch->leaves(set.direction[m]);
        if (!to_ground && !to_patch && !reflected) {
            if (ground) ground->reflect();
            if (patch) patch->reflect();
            reflected = true;
        }
        Scalar one(index, rays, fields, set.direction[m], set.source_basis.data() + m * set.source_terms,
                   set.inflow.empty() ? 0.0 : double(set.inflow[m]), ground ? &*ground : nullptr,
                   patch && !patch->black() && !to_patch ? &*patch : nullptr, walls);
        one.sweep();
        for (size_t block = 0; on_walls && block < blocks.count(); ++block)
            on_walls->add(block, set.direction[m], double(set.weight[m]),
                          [&](size_t slot) { return one.radiance(block * Blocks::size + slot); });
        for (size_t cell = 0; to_patch && cell < with_ground->patch->cells(); ++cell)
            if (const auto radiance = one.at_centre(with_ground->patch->middle(cell)))
                patch->gather(cell, m, *radiance);
        if (to_ground) {
            const double out = set.weight[m] * std::abs(set.direction[m][ground->face() / 2]);
            ground->gather_unit(out);
            for (size_t cell = 0; cell < ground->cells(); ++cell)
                ground->gather(cell, out * one.on_plane(ground->voxel(cell), ground->face())
                                               .value_or(set.inflow.empty() ? 0.0 : double(set.inflow[m])));
        }
        if (planes) on_planes.add(one, set, m);
        for (int k = 0; k < set.moment_terms; ++k) {
            const double factor = double(set.weight[m]) * set.moment_basis[m * set.moment_terms + k];
            for (size_t slot = 0; slot < blocks.count() * 512; ++slot)
                if (blocks.active(slot)) moments[k][slot] += factor * one.radiance(slot);
        }
        for (size_t f = 0; f < faces.size(); ++f) {
            const double cosine = (faces[f].face % 2 ? 1 : -1) * set.direction[m][faces[f].face / 2];
            const double weighted = set.weight[m] * one.on_face(faces[f].slot, faces[f].face);
            tally[f][0] += cosine * weighted;
            tally[f][1] += weighted;
            tally[f][2] += (cosine * cosine - 1.0 / 3) * weighted;
        }
    }
    if (ground) ground->reflect();
    if (patch && patch->black()) patch->reflect();
    result.moments.resize(moments.size());
    for (size_t k = 0; k < moments.size(); ++k) result.moments[k].assign(moments[k].begin(), moments[k].end());
    result.tally.resize(faces.size());
    for (size_t f = 0; f < faces.size(); ++f)
        result.tally[f] = {float(tally[f][0]), float(tally[f][1]), float(tally[f][2])};
    if (on_walls) on_walls->write();
    if (planes) on_planes.write(set, *planes);
    if (planes && patch) patch->write(index.spacing(), *planes);
}

}  // namespace vdbcloud
