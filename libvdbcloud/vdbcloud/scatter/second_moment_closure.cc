// The balance of each cell from what a sweep has gathered: the source of phi - phi_L.
#include "vdbcloud/core/constants.h"
#include "vdbcloud/scatter/active_slots.h"
#include "vdbcloud/scatter/second_moment.h"

#include <cmath>

namespace vdbcloud {

namespace {

/// A weight of the medium alone, so that light adds up.
double blend(double weight, double diffusion, double sweep) { return sweep + weight * (diffusion - sweep); }

}  // namespace

/// Fluence, current and second moment of swept light.
class SecondMoment::Swept {
public:
    Swept(const P1Operator& p1, const std::vector<std::vector<float>>& moments)
        : blocks_(p1.blocks()), spacing_(p1.index().spacing())
    {
        const auto of = [&](int l, int m) { return moments[size_t(harmonic(l, m))].data(); };
        zero_ = of(0, 0);
        current_ = {of(1, 1), of(1, -1), of(1, 0)};
        mixed_ = {of(2, -1), of(2, 1), of(2, -2)};
        zz_ = of(2, 0);
        xx_less_yy_ = of(2, 2);
    }

    double fluence(size_t slot) const { return std::sqrt(4 * pi) * double(zero_[slot]); }

    /// Component of the current at a voxel's centre.
    double current(int axis, size_t slot) const { return std::sqrt(4 * pi / 3) * double(current_[size_t(axis)][slot]); }

    /// The current through the lower face of a voxel: by four centres, or two where there are no more.
    double current_through(int axis, size_t below, size_t slot) const
    {
        const double inner = current(axis, below) + current(axis, slot);
        const size_t first = beside(blocks_, below, 2 * axis), last = beside(blocks_, slot, 2 * axis + 1);
        if (!blocks_.active(first) || !blocks_.active(last)) return inner / 2;
        return (9 * inner - current(axis, first) - current(axis, last)) / 16;
    }

    /// t_aa, t_ab = int (s_a s_b - delta_ab / 3) L.
    double diagonal(int axis, size_t slot) const
    {
        const double zz = std::sqrt(16 * pi / 45) * double(zz_[slot]);
        if (axis == 2) return zz;
        const double difference = std::sqrt(16 * pi / 15) * double(xx_less_yy_[slot]);
        return ((axis == 0 ? difference : -difference) - zz) / 2;
    }

    /// Sum over the other axes b of d t_ab / d b in a cell, one-sided where a neighbour is missing.
    double cross_gradient(int axis, size_t slot) const
    {
        double sum = 0;
        for (int b = 0; b < 3; ++b) {
            if (b == axis) continue;
            const size_t below = beside(blocks_, slot, 2 * b), above = beside(blocks_, slot, 2 * b + 1);
            const bool has_below = blocks_.active(below), has_above = blocks_.active(above);
            if (!has_below && !has_above) continue;
            const float* t = mixed_[size_t(3 - axis - b)];
            const double difference = double(t[has_above ? above : slot]) - double(t[has_below ? below : slot]);
            sum += std::sqrt(4 * pi / 15) * difference / (spacing_[b] * (has_below && has_above ? 2 : 1));
        }
        return sum;
    }

private:
    const Blocks& blocks_;
    Vec3d spacing_;
    const float *zero_, *zz_, *xx_less_yy_;
    std::array<const float*, 3> current_, mixed_;  // by axis; by the axis that is neither a nor b
};

/// Weight of diffusion on a face between two voxels. A thin voxel beside a far thicker one counts for an eighth of
/// that: its light comes from there, with the errors it has there. (Without that pores in thick matter converge
/// slowly.)
double SecondMoment::weight_between(int axis, size_t below, size_t slot) const
{
    return diffusive((double(thickest_[below]) + thickest_[slot]) / 2 * p1_.index().spacing()[axis]);
}

void SecondMoment::close_face(const Swept& swept, P1Source& source, size_t exposed, int face,
                              const FaceTally& tally) const
{
    const ExposedVoxel& voxel = p1_.exposed()[exposed];
    const int axis = face / 2, outward = face % 2 ? 1 : -1;
    const double h = p1_.index().spacing()[axis], area = p1_.face_area(axis), sky = source.sky_inflow[size_t(face)];
    const double g = p1_.conductance(voxel, face), fluence = swept.fluence(voxel.slot);
    double& outflow = source.outflow[exposed][size_t(face)];
    const double normal = (tally.second - swept.diagonal(axis, voxel.slot)) / (h / 2);
    const double additive = -(normal + outward * swept.cross_gradient(axis, voxel.slot)) / p1_.sigma_tr(voxel.slot);
    const double correction = tally.current - p1_.face_weight(voxel, face) * (tally.fluence - sky) / 2;
    const double diffusion =
        g * (fluence - sky) + outflow + p1_.boundary_flux(voxel, face, additive, correction) * area;
    const double leaving = blend(weight_between(axis, voxel.slot, voxel.slot), diffusion, tally.current * area);
    source.rhs[voxel.slot] -= leaving - outflow + g * sky;  // the source's own are in rhs
    outflow = leaving - g * (fluence - sky);
}

/// Turns the source of phi into that of phi - phi_L, and completes source.outflow.
void SecondMoment::close(P1Source& source) const
{
    const Blocks& blocks = p1_.blocks();
    const Swept swept(p1_, swept_.moments);
    std::vector<double> cross(blocks.slots(), 0.0);
    std::vector<float> lower(blocks.slots(), 0.0f);  // flux through the lower face, without the beam's part
    for (int a = 0; a < 3; ++a) {
        const double h = p1_.index().spacing()[a], area = p1_.face_area(a);
        const std::vector<double>& beam = source.through[size_t(a)];
        const std::vector<float>& conductance = p1_.stencil().face[size_t(a)];
        each_active(blocks, [&](size_t slot) { cross[slot] = swept.cross_gradient(a, slot); });
        each_active(blocks, [&](size_t slot) {
            const size_t below = beside(blocks, slot, 2 * a);
            lower[slot] = 0;
            if (!blocks.active(below) || below == slot) return;
            const double gradient =
                (swept.diagonal(a, slot) - swept.diagonal(a, below)) / h + (cross[slot] + cross[below]) / 2;
            const double diffusion = double(conductance[below]) / area * (swept.fluence(below) - swept.fluence(slot)) -
                                     gradient * 2 / (p1_.sigma_tr(slot) + p1_.sigma_tr(below));
            const double own = swept.current_through(a, below, slot) - (beam.empty() ? 0.0 : beam[slot]);
            lower[slot] = float(blend(weight_between(a, below, slot), diffusion, own));
        });
        each_active(blocks, [&](size_t slot) {
            const size_t above = beside(blocks, slot, 2 * a + 1);
            const double upper = blocks.active(above) && above != slot ? lower[above] : 0.0f;
            source.rhs[slot] += (double(lower[slot]) - upper) * area;
        });
    }
    each_active(blocks, [&](size_t slot) { source.rhs[slot] -= p1_.sigma_a(slot) * p1_.hbar() * fluence(slot); });
    size_t n = 0;
    for (size_t k = 0; k < p1_.exposed().size(); ++k)
        for (int face = 0; face < 6; ++face)
            if (p1_.exposed()[k].faces >> face & 1) close_face(swept, source, k, face, swept_.tally[n++]);
}

}  // namespace vdbcloud
