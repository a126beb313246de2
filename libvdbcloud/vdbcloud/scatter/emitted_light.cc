#include "vdbcloud/scatter/emitted_light.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/scatter/active_slots.h"
#include "vdbcloud/scatter/emission_cost.h"
#include "vdbcloud/scatter/emission_gather.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace vdbcloud {

namespace {

using Arrays = std::vector<std::vector<float>>;

/// Scattered light of emitting voxels is followed up to this many collisions, or until another adds less than this
/// share of the power.
constexpr int most_collisions = 2;
constexpr double least_gain = 0.01;

bool emits(const std::vector<const std::vector<float>*>& emission, size_t slot)
{
    return std::any_of(emission.begin(), emission.end(), [&](const auto* j) { return (*j)[slot] > 0; });
}

/// Sum over the slots, in their order.
template<typename F>
double total(const Blocks& blocks, const F& f)
{
    std::vector<double> part(blocks.count(), 0.0);
    tbb::parallel_for(size_t(0), blocks.count(), [&](size_t b) {
        for (size_t slot = b * Blocks::size; slot < (b + 1) * Blocks::size; ++slot)
            if (blocks.active(slot)) part[b] += f(slot);
    });
    return std::accumulate(part.begin(), part.end(), 0.0);
}

/// Computes the light of all channels of a group.
class Emitters {
public:
    Emitters(const P1Operator& p1, const BeamMedium& medium, const std::vector<const std::vector<float>*>& emission,
             const Hemisphere& hemisphere)
        : p1_(p1), blocks_(p1.blocks()), emission_(emission), hemisphere_(hemisphere),
          degree_(std::max(p1.mean_cosine() != 0 ? p1.delta().last_degree() : 0, 1)),
          depth_(*medium.bricks(), medium.extinction()), sigma_(blocks_.slots(), 0.0f)
    {
        const Vec3d& h = p1.index().spacing();
        volume_ = h[0] * h[1] * h[2];
        each_active(blocks_,
                    [&](size_t slot) { sigma_[slot] = float(p1.scaling(slot).extinction * p1.sigma_t(slot)); });
        jump_ = over_tents(sigma_);  // a face of a cube: 5/6 of its extinction
        each_active(blocks_, [&](size_t slot) {
            jump_[slot] = std::min(6 * std::abs(jump_[slot] / std::max(jump_[slot], sigma_[slot]) -
                                                sigma_[slot] / std::max(jump_[slot], sigma_[slot])),
                                   1.0f);
        });
        for (const std::vector<float>* j : emission) {
            source_.push_back(*j);
            light_.emplace_back();
        }
    }

    std::vector<EmittedLight> run()
    {
        for (EmittedLight& light : light_) {
            light.moments.assign(size_t(harmonic_count(degree_)), std::vector<float>(blocks_.slots(), 0.0f));
            light.scattered.assign(blocks_.slots(), 0.0f);
        }
        follow_collisions();
        gather(voxels([](size_t) { return true; }), true);
        for (size_t c = 0; c < light_.size(); ++c) finish(c);
        return std::move(light_);
    }

private:
    std::vector<const std::vector<float>*> pointers(const Arrays& of) const
    {
        std::vector<const std::vector<float>*> to;
        for (const auto& array : of) to.push_back(&array);
        return to;
    }

    /// The active voxels of each block for which `wanted` is true.
    template<typename F>
    std::vector<BlockMask> voxels(const F& wanted) const
    {
        std::vector<BlockMask> masks(blocks_.count(), BlockMask{});
        for (size_t b = 0; b < blocks_.count(); ++b)
            for (size_t n = 0; n < Blocks::size; ++n)
                if (blocks_.active(b * Blocks::size + n) && wanted(b * Blocks::size + n))
                    masks[b][n / 64] |= uint64_t(1) << (n % 64);
        return masks;
    }

    /// Replaces moments and mean fluence (kept in `scattered`) of the wanted voxels; planes on request.
    void gather(const std::vector<BlockMask>& wanted, bool planes)
    {
        const auto source = pointers(source_);
        const EmissionTree tree(p1_.index(), source, sigma_);
        const EmissionGather rays(p1_.index(), tree, source, depth_, sigma_, degree_);
        const size_t values = rays.values();
        tbb::parallel_for(size_t(0), blocks_.count(), [&](size_t b) {
            if (std::all_of(wanted[b].begin(), wanted[b].end(), [](uint64_t word) { return word == 0; })) return;
            std::vector<double> out;
            rays.block(b, wanted[b], out);
            for (size_t n = 0; n < Blocks::size; ++n)
                for (size_t c = 0; c < light_.size(); ++c) {
                    const double* from = out.data() + (n * light_.size() + c) * values;
                    for (size_t k = 0; k + 1 < values; ++k) light_[c].moments[k][b * Blocks::size + n] = float(from[k]);
                    light_[c].scattered[b * Blocks::size + n] = float(from[values - 1]);
                }
        });
        if (!planes) return;
        for (int face = 0; face < 6; ++face) {
            std::vector<double> ahead;
            const std::vector<double> out = rays.plane(face, hemisphere_, ahead);
            const auto [u, v] = ActiveBox::axes(face / 2);
            for (size_t c = 0; c < light_.size(); ++c) {
                light_[c].reflected += ahead[c] * p1_.index().spacing()[u] * p1_.index().spacing()[v];
                auto& plane = light_[c].planes[size_t(face)];
                for (size_t cell = c; cell < out.size(); cell += light_.size()) plane.push_back(float(out[cell]));
            }
        }
    }

    double power(const std::vector<float>& of) const
    {
        return 4 * pi * volume_ * total(blocks_, [&](size_t slot) { return double(of[slot]); });
    }

    /// Adds to Q the isotropic part of light that collides within emitting voxels, collision by collision.
    void follow_collisions()
    {
        std::vector<uint8_t> wanted(blocks_.slots(), 0);  // emitting voxels and their neighbours, for the tents
        for (size_t slot = 0; slot < blocks_.count() * Blocks::size; ++slot)
            if (blocks_.active(slot) && emits(emission_, slot))
                for (int k = 0; k < 27; ++k)
                    wanted[blocks_.slot(blocks_.voxel(slot) + Vec3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1))] = 1;
        const std::vector<BlockMask> emitters = voxels([&](size_t slot) { return wanted[slot] != 0; });
        for (int collision = 1; collision <= most_collisions; ++collision) {
            gather(emitters, false);
            double gain = 0;
            for (size_t c = 0; c < light_.size(); ++c) {
                average_at_jumps(light_[c]);
                std::vector<float> next = *emission_[c];
                each_active(blocks_, [&](size_t slot) {
                    if (!emits(emission_, slot)) return;
                    const double rate = p1_.scaling(slot).albedo * sigma_[slot] / (4 * pi);
                    next[slot] += float(rate * light_[c].scattered[slot]);
                });
                const double before = power(source_[c]), after = power(next);
                if (before > 0) gain = std::max(gain, after / before - 1);
                if (after > before) light_[c].collisions = collision;
                source_[c] = std::move(next);
            }
            if (gain < least_gain) return;
        }
    }

    void finish(size_t c)
    {
        EmittedLight& light = light_[c];
        const VoxelIndex& index = p1_.index();
        const ActiveBox box(blocks_);
        double out = 0;
        for (int face = 0; face < 6; ++face) {
            const auto [u, v] = ActiveBox::axes(face / 2);
            const auto& cells = light.planes[size_t(face)];
            light.out_by_plane[size_t(face)] =
                std::accumulate(cells.begin(), cells.end(), 0.0) * index.spacing()[u] * index.spacing()[v];
            out += light.out_by_plane[size_t(face)];
        }
        average_at_jumps(light);
        const double collided =
            volume_ * total(blocks_, [&](size_t slot) { return double(sigma_[slot]) * light.scattered[slot]; });
        const double factor = out + collided > 0 ? power(source_[c]) / (out + collided) : 1.0;
        light.scaled_by = factor - 1;
        light.emitted = power(*emission_[c]);
        for (auto& moment : light.moments)
            for (float& value : moment) value = float(factor * value);
        light.reflected *= factor;
        for (size_t face = 0; face < 6; ++face) {
            light.out_by_plane[face] *= factor;
            for (float& value : light.planes[face]) value = float(factor * value);
        }
        light.absorbed.assign(blocks_.slots(), 0.0f);
        light.fluence = light.absorbed;
        light.followed = light.absorbed;
        if (p1_.mean_cosine() != 0) light.forward.fill(light.absorbed);
        static constexpr int order[3] = {1, -1, 0};
        each_active(blocks_, [&](size_t slot) {
            const double rate = factor * sigma_[slot] * light.scattered[slot], w0 = p1_.scaling(slot).albedo;
            const double not_j = double(source_[c][slot]) - (*emission_[c])[slot];
            light.absorbed[slot] = float((1 - w0) * rate);
            light.scattered[slot] = float(w0 * rate - 4 * pi * not_j);
            light.fluence[slot] = float(std::sqrt(4 * pi) * light.moments[0][slot]);
            light.followed[slot] = float(not_j + w0 * (sigma_[slot] * double(light.fluence[slot]) - rate) / (4 * pi));
            for (size_t a = 0; a < 3 && p1_.mean_cosine() != 0; ++a)
                light.forward[a][slot] = float(p1_.q1_factor(slot) * std::sqrt(4 * pi / 3) *
                                               light.moments[size_t(harmonic(1, order[a]))][slot]);
        });
        sort_by_face(light);
    }

    /// The mean over each voxel's tent of a field that is linear from centre to centre: weights 1/6, 2/3, 1/6 along
    /// each axis. Voxels beside that are not active count as the voxel's own.
    std::vector<float> over_tents(std::vector<float> field) const
    {
        for (int a = 0; a < 3; ++a) {
            const std::vector<float> of = field;
            each_active(blocks_, [&](size_t slot) {
                double sum = 4.0 * of[slot];
                for (const int face : {2 * a, 2 * a + 1}) {
                    const size_t beside = blocks_.neighbour(slot, face);
                    sum += of[blocks_.active(beside) ? beside : slot];
                }
                field[slot] = float(sum / 6);
            });
        }
        return field;
    }

    /// Where extinction jumps, makes the mean fluence of a thin voxel the mean over its tent: extinction is trilinear.
    /// The fluence has a kink there. Elsewhere the tents would only smooth it.
    void average_at_jumps(EmittedLight& light) const
    {
        const std::vector<float> tent = over_tents(light.moments[0]);
        each_active(blocks_, [&](size_t slot) {
            const double mean = std::sqrt(4 * pi) * tent[slot], thin = 1 - diffusive(sigma_[slot] * p1_.hbar());
            light.scattered[slot] = float(light.scattered[slot] + thin * jump_[slot] * (mean - light.scattered[slot]));
        });
    }

    /// Divides the power that leaves by the flux at the voxels that have exposed faces.
    void sort_by_face(EmittedLight& light) const
    {
        static constexpr int order[3] = {1, -1, 0};
        std::array<double, 6> outward{};
        for (const ExposedVoxel& voxel : p1_.exposed())
            for (size_t face = 0; face < 6; ++face)
                if (voxel.faces >> face & 1)
                    outward[face] += (face % 2 ? 1 : -1) * p1_.face_area(int(face / 2)) *
                                     light.moments[size_t(harmonic(1, order[face / 2]))][voxel.slot];
        const double net = std::accumulate(outward.begin(), outward.end(), 0.0);
        const double power = std::accumulate(light.out_by_plane.begin(), light.out_by_plane.end(), 0.0);
        for (size_t face = 0; face < 6; ++face)
            light.out_by_face[face] = net > 0 ? outward[face] * power / net : light.out_by_plane[face];
    }

    const P1Operator& p1_;
    const Blocks& blocks_;
    const std::vector<const std::vector<float>*>& emission_;
    const Hemisphere& hemisphere_;
    const int degree_;
    const SegmentDepth depth_;
    std::vector<float> sigma_;  // sigma_t'
    std::vector<float> jump_;   // 1 where extinction jumps, 0 where it is smooth
    double volume_ = 1;
    Arrays source_;  // Q
    std::vector<EmittedLight> light_;
};

}  // namespace

double share_by_rays(const Blocks& blocks, const std::vector<const std::vector<float>*>& emission)
{
    const double emitting = total(blocks, [&](size_t slot) { return emits(emission, slot) ? 1.0 : 0.0; });
    return share_by_rays(emitting, double(blocks.active_count()));
}

std::vector<EmittedLight> emitted_light(const P1Operator& scaled, const BeamMedium& medium,
                                        const std::vector<const std::vector<float>*>& emission,
                                        const Hemisphere& reflected_into)
{
    return Emitters(scaled, medium, emission, reflected_into).run();
}

namespace {

/// The part of F that light scattered forward adds, as add_beam() does for a beam.
void add_forward(const P1Operator& p1, const EmittedLight& light, P1Source& source)
{
    const Blocks& blocks = p1.blocks();
    for (int a = 0; a < 3; ++a) {
        const std::vector<float>& forward = light.forward[size_t(a)];
        std::vector<double>& through = source.through_faces(a);
        std::vector<float> lower(blocks.slots(), 0.0f);
        each_active(blocks, [&](size_t slot) {
            const size_t below = blocks.neighbour(slot, 2 * a);
            if (!blocks.active(below)) return;
            lower[slot] = float((double(forward[below]) + forward[slot]) / (p1.sigma_tr(below) + p1.sigma_tr(slot)));
        });
        each_active(blocks, [&](size_t slot) {
            const size_t above = blocks.neighbour(slot, 2 * a + 1);
            source.rhs[slot] += (double(lower[slot]) - (blocks.active(above) ? lower[above] : 0.0f)) * p1.face_area(a);
            through[slot] += double(lower[slot]);
        });
        for (size_t k = 0; k < p1.exposed().size(); ++k) {
            const ExposedVoxel& voxel = p1.exposed()[k];
            for (int up = 0; up < 2; ++up) {
                if (!(voxel.faces >> (2 * a + up) & 1)) continue;
                const double outward = (up ? 1 : -1) * double(forward[voxel.slot]) / p1.sigma_tr(voxel.slot);
                const double leaving = p1.boundary_flux(voxel, 2 * a + up, outward) * p1.face_area(a);
                source.rhs[voxel.slot] -= leaving;
                source.outflow[k][size_t(2 * a + up)] += leaving;
            }
        }
    }
}

}  // namespace

void add_emitted(const P1Operator& p1, const EmittedLight& light, P1Source& source)
{
    const Blocks& blocks = p1.blocks();
    each_active(blocks, [&](size_t slot) {
        source.rhs[slot] += p1.hbar() * light.scattered[slot];
        if (!source.beam_absorbed.empty()) source.beam_absorbed[slot] += p1.hbar() * light.absorbed[slot];
    });
    if (!light.forward[0].empty()) add_forward(p1, light, source);
    source.emitted += light.emitted;
    source.emission_absorbed +=
        std::pow(p1.hbar(), 3) * total(blocks, [&](size_t slot) { return double(light.absorbed[slot]); });
    for (size_t face = 0; face < 6; ++face) source.emission_out[face] += light.out_by_face[face];
    source.uncollided = &light.fluence;
}

}  // namespace vdbcloud
