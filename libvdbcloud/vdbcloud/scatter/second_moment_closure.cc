// The balance of each cell from what a sweep has gathered: the source of phi - phi_L.
#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/release.h"
#include "vdbcloud/scatter/active_slots.h"
#include "vdbcloud/scatter/block_rows.h"
#include "vdbcloud/scatter/second_moment.h"

#include <cmath>

namespace vdbcloud {

using namespace eight;

namespace {

/// Factors of the moments' harmonics (harmonics.h).
const double of_fluence = std::sqrt(4 * pi), of_current = std::sqrt(4 * pi / 3), of_zz = std::sqrt(16 * pi / 45),
             of_xx_less_yy = std::sqrt(16 * pi / 15), of_mixed = std::sqrt(4 * pi / 15);

/// A weight of the medium alone, so that light adds up.
double blend(double weight, double diffusion, double sweep) { return sweep + weight * (diffusion - sweep); }

/// Moments of swept light.
struct Moments {
    const float *zero, *zz, *xx_less_yy;
    std::array<const float*, 3> current, mixed;  // by axis; by the axis that is neither a nor b
};

/// The law of the fluxes through the lower faces of an axis.
struct FaceLaw {
    double inverse_length, inverse_area, gradient_share;  // the share of a conductance that a gradient of t has
    double half_length;
    const float *conductance, *thickest;
};

/// diffusive() of the lower faces of a row. A thin voxel beside a far thicker one counts for an eighth of that: its
/// light comes from there, with the errors it has there. (Without that pores in thick matter converge slowly.)
template<int axis>
VDBCLOUD_INLINE Doubles weights(const BlockRows& rows, const float* thickest, double half_length, int x, int y)
{
    const Doubles thickness =
        as<double>(rows.at<axis, -1>(thickest, x, y) + rows.at<axis, 0>(thickest, x, y)) * all(half_length);
    const Doubles square = thickness * thickness;
    return square / (all(0.25) + square);
}

/// The largest of a voxel's value and an eighth of its neighbours' values.
VDBCLOUD_CLONES void find_thickest(const BlockRows& rows, const float* sigma, float* to)
{
    const auto larger = [](const Floats& a, const Floats& b) { return a < b ? b : a; };
    for (int x = 0; x < 8; ++x)
        for (int y = 0; y < 8; ++y) {
            const Floats beside = larger(larger(larger(rows.at<0, -1>(sigma, x, y), rows.at<0, 1>(sigma, x, y)),
                                                larger(rows.at<1, -1>(sigma, x, y), rows.at<1, 1>(sigma, x, y))),
                                         larger(rows.at<2, -1>(sigma, x, y), rows.at<2, 1>(sigma, x, y)));
            const Floats own = rows.at<0, 0>(sigma, x, y);
            store(to + rows.slot(x, y), lanes_of(rows.active<0, 0>(x, y)) ? larger(own, beside * all(0.125f)) : own);
        }
}

/// Additive fluxes through the lower faces of an axis.
struct Additive {
    const double *own, *shared;  // null: none
    double scale;                // of `shared`
};

/// The part of the additive fluxes that sweeps replace: less where diffusion has its share.
template<int axis>
VDBCLOUD_INLINE void replaced(const BlockRows& rows, const Additive& of, const float* thickest, double half_length,
                              double* to)
{
    for (int x = 0; x < 8; ++x)
        for (int y = 0; y < 8; ++y) {
            const size_t slot = rows.slot(x, y);
            Doubles flux{};
            if (of.own) flux += load(of.own + slot);
            if (of.shared) flux += all(of.scale) * load(of.shared + slot);
            const Doubles inner =
                as<double>(lanes_of(rows.active<axis, 0>(x, y) & rows.active<axis, -1>(x, y)) ? all(1.0f) : all(0.0f));
            store(to + slot, inner * (flux - weights<axis>(rows, thickest, half_length, x, y) * flux));
        }
}

VDBCLOUD_CLONES void replaced(int axis, const BlockRows& rows, const Additive& of, const float* thickest,
                              double half_length, double* to)
{
    switch (axis) {
    case 0: return replaced<0>(rows, of, thickest, half_length, to);
    case 1: return replaced<1>(rows, of, thickest, half_length, to);
    default: return replaced<2>(rows, of, thickest, half_length, to);
    }
}

/// t_aa, t_ab = int (s_a s_b - delta_ab / 3) L, of a row.
template<int axis, int d>
VDBCLOUD_INLINE Doubles diagonal(const Moments& m, const BlockRows& rows, int x, int y)
{
    const Doubles zz = all(of_zz) * as<double>(rows.at<axis, d>(m.zz, x, y));
    if (axis == 2) return zz;
    const Doubles difference = all(of_xx_less_yy) * as<double>(rows.at<axis, d>(m.xx_less_yy, x, y));
    return ((axis == 0 ? difference : -difference) - zz) * all(0.5);
}

/// d t / d b, one-sided where a neighbour is missing. `inverse`: factor of the difference of two neighbours.
template<int b>
VDBCLOUD_INLINE Floats gradient(const float* t, const BlockRows& rows, int x, int y, float inverse)
{
    const unsigned below = rows.active<b, -1>(x, y), above = rows.active<b, 1>(x, y);
    const Floats own = rows.at<b, 0>(t, x, y);
    const Floats from = lanes_of(below) ? rows.at<b, -1>(t, x, y) : own;
    const Floats to = lanes_of(above) ? rows.at<b, 1>(t, x, y) : own;
    return (to - from) * (lanes_of(below & above) ? all(inverse) : all(2 * inverse));
}

template<int axis>
VDBCLOUD_INLINE void cross_gradients(const Moments& m, const BlockRows& rows, const float* inverse, float* to)
{
    constexpr int b = axis == 0 ? 1 : 0, c = axis == 2 ? 1 : 2;
    for (int x = 0; x < 8; ++x)
        for (int y = 0; y < 8; ++y)
            store(to + rows.slot(x, y), gradient<b>(m.mixed[3 - axis - b], rows, x, y, inverse[b]) +
                                            gradient<c>(m.mixed[3 - axis - c], rows, x, y, inverse[c]));
}

/// Flux through the lower faces of one block; 0 where a face is not between two voxels.
template<int axis>
VDBCLOUD_INLINE void lower_fluxes(const Moments& m, const FaceLaw& law, const BlockRows& rows, const float* cross,
                                  float* lower)
{
    for (int x = 0; x < 8; ++x)
        for (int y = 0; y < 8; ++y) {
            const size_t slot = rows.slot(x, y);
            const unsigned inner = rows.active<axis, 0>(x, y) & rows.active<axis, -1>(x, y);
            if (!inner) {
                store(lower + slot, all(0.0f));
                continue;
            }
            const Doubles gradient =
                (diagonal<axis, 0>(m, rows, x, y) - diagonal<axis, -1>(m, rows, x, y)) * all(law.inverse_length) +
                as<double>(load(cross + slot) + rows.at<axis, -1>(cross, x, y)) * all(0.5);
            const Doubles fluences = as<double>(rows.at<axis, -1>(m.zero, x, y) - load(m.zero + slot));
            const Doubles diffusion =
                as<double>(rows.at<axis, -1>(law.conductance, x, y)) *
                (fluences * all(of_fluence * law.inverse_area) - gradient * all(law.gradient_share));
            // The current through the face: by four centres, or two where there are no more.
            const float* current = m.current[axis];
            const Doubles two = as<double>(rows.at<axis, -1>(current, x, y)) + as<double>(load(current + slot));
            const Doubles next =
                as<double>(rows.at<axis, -2>(current, x, y)) + as<double>(rows.at<axis, 1>(current, x, y));
            const auto four = lanes_of(rows.active<axis, -2>(x, y) & rows.active<axis, 1>(x, y));
            const Doubles outer = as<double>(four ? all(1.0f) : all(0.0f));
            const Doubles own = all(of_current / 2) * (two + outer * (two - next) * all(0.125)),
                          weight = weights<axis>(rows, law.thickest, law.half_length, x, y);
            store(lower + slot, lanes_of(inner) ? as<float>(own + weight * (diffusion - own)) : all(0.0f));
        }
}

/// rhs += the fluxes into each voxel through the faces of an axis.
template<int axis, typename T>
VDBCLOUD_INLINE void add_fluxes(const BlockRows& rows, const T* lower, double area, double* rhs)
{
    for (int x = 0; x < 8; ++x)
        for (int y = 0; y < 8; ++y) {
            const size_t slot = rows.slot(x, y);
            const Doubles in = as<double>(load(lower + slot)) - as<double>(rows.at<axis, 1>(lower, x, y));
            store(rhs + slot, load(rhs + slot) + in * all(area));
        }
}

VDBCLOUD_CLONES void cross_gradients(int axis, const Moments& m, const BlockRows& rows, const float* inverse, float* to)
{
    switch (axis) {
    case 0: return cross_gradients<0>(m, rows, inverse, to);
    case 1: return cross_gradients<1>(m, rows, inverse, to);
    default: return cross_gradients<2>(m, rows, inverse, to);
    }
}

VDBCLOUD_CLONES void lower_fluxes(int axis, const Moments& m, const FaceLaw& law, const BlockRows& rows,
                                  const float* cross, float* lower)
{
    switch (axis) {
    case 0: return lower_fluxes<0>(m, law, rows, cross, lower);
    case 1: return lower_fluxes<1>(m, law, rows, cross, lower);
    default: return lower_fluxes<2>(m, law, rows, cross, lower);
    }
}

template<typename T>
VDBCLOUD_INLINE void add_fluxes_of(int axis, const BlockRows& rows, const T* lower, double area, double* rhs)
{
    switch (axis) {
    case 0: return add_fluxes<0>(rows, lower, area, rhs);
    case 1: return add_fluxes<1>(rows, lower, area, rhs);
    default: return add_fluxes<2>(rows, lower, area, rhs);
    }
}

VDBCLOUD_CLONES void add_fluxes(int axis, const BlockRows& rows, const float* lower, double area, double* rhs)
{
    add_fluxes_of(axis, rows, lower, area, rhs);
}

VDBCLOUD_CLONES void take_fluxes(int axis, const BlockRows& rows, const double* lower, double area, double* rhs)
{
    add_fluxes_of(axis, rows, lower, -area, rhs);
}

template<typename F>
void each_block(const Blocks& blocks, const F& f)
{
    tbb::parallel_for(size_t(0), blocks.count(), [&](size_t block) { f(BlockRows(blocks, block)); });
}

Moments moments_of(const std::vector<std::vector<float>>& moments)
{
    const auto of = [&](int l, int m) { return moments[size_t(harmonic(l, m))].data(); };
    return {of(0, 0), of(2, 0), of(2, 2), {of(1, 1), of(1, -1), of(1, 0)}, {of(2, -1), of(2, 1), of(2, -2)}};
}

}  // namespace

/// Fluence and second moment of swept light at one voxel.
class SecondMoment::Swept {
public:
    Swept(const P1Operator& p1, const Moments& moments, const std::vector<float>& thickest)
        : blocks_(p1.blocks()), spacing_(p1.index().spacing()), m_(moments), thickest_(thickest)
    {
    }

    /// Weight of diffusion on an exposed face of a voxel.
    double weight(int axis, size_t slot) const { return diffusive(double(thickest_[slot]) * spacing_[axis]); }

    double fluence(size_t slot) const { return of_fluence * double(m_.zero[slot]); }

    double diagonal(int axis, size_t slot) const
    {
        const double zz = of_zz * double(m_.zz[slot]);
        if (axis == 2) return zz;
        const double difference = of_xx_less_yy * double(m_.xx_less_yy[slot]);
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
            const float* t = m_.mixed[size_t(3 - axis - b)];
            const double difference = double(t[has_above ? above : slot]) - double(t[has_below ? below : slot]);
            sum += of_mixed * difference / (spacing_[b] * (has_below && has_above ? 2 : 1));
        }
        return sum;
    }

private:
    const Blocks& blocks_;
    Vec3d spacing_;
    Moments m_;
    const std::vector<float>& thickest_;
};

void SecondMoment::close_face(const Swept& swept, P1Source& source, size_t exposed, int face, const FaceTally& tally,
                              double additive_outflow) const
{
    const ExposedVoxel& voxel = p1_.exposed()[exposed];
    const int axis = face / 2, outward = face % 2 ? 1 : -1;
    const double h = p1_.index().spacing()[axis], area = p1_.face_area(axis), sky = source.sky_inflow[size_t(face)];
    const double g = p1_.conductance(voxel, face), fluence = swept.fluence(voxel.slot);
    const double normal = (tally.second - swept.diagonal(axis, voxel.slot)) / (h / 2);
    const double additive = -(normal + outward * swept.cross_gradient(axis, voxel.slot)) / p1_.sigma_tr(voxel.slot);
    const double correction = tally.current - p1_.face_weight(voxel, face) * (tally.fluence - sky) / 2;
    const double diffusion =
        g * (fluence - sky) + additive_outflow + p1_.boundary_flux(voxel, face, additive, correction) * area;
    const double leaving = blend(swept.weight(axis, voxel.slot), diffusion, tally.current * area);
    source.rhs[voxel.slot] -= leaving - additive_outflow;  // the source's own is in rhs
    source.outflow[exposed][size_t(face)] = leaving - g * (fluence - sky);
}

/// sigma_t' as it weighs diffusion: see weights().
std::vector<float> SecondMoment::thickest() const
{
    std::vector<float> values(p1_.blocks().slots(), 0.0f);
    each_block(p1_.blocks(), [&](const BlockRows& rows) { find_thickest(rows, sigma_->data(), values.data()); });
    return values;
}

/// Calls f(k, face) for each exposed face, in the order of the tallies.
template<typename F>
void SecondMoment::each_face(const F& f) const
{
    for (size_t k = 0; k < p1_.exposed().size(); ++k)
        for (int face = 0; face < 6; ++face)
            if (p1_.exposed()[k].faces >> face & 1) f(k, face);
}

/// Takes from the source's right side what sweeps replace: the inflow of the sky, and additive fluxes, which it frees.
/// Returns the additive outflow of each exposed face.
std::vector<double> SecondMoment::take_replaced(P1Source& source) const
{
    const Blocks& blocks = p1_.blocks();
    const std::vector<float> thick = thickest();
    std::vector<double> lower(blocks.slots(), 0.0);
    for (int a = 0; a < 3; ++a) {
        const std::vector<double>& own = source.through[size_t(a)];
        const std::vector<double>* shared = source.shared_through ? &(*source.shared_through)[size_t(a)] : nullptr;
        const Additive of{own.empty() ? nullptr : own.data(), !shared || shared->empty() ? nullptr : shared->data(),
                          source.shared_scale};
        if (!of.own && !of.shared) continue;
        const double half = p1_.index().spacing()[a] / 2, area = p1_.face_area(a);
        each_block(blocks, [&](const BlockRows& rows) { replaced(a, rows, of, thick.data(), half, lower.data()); });
        each_block(blocks, [&](const BlockRows& rows) { take_fluxes(a, rows, lower.data(), area, source.rhs.data()); });
        release(source.through[size_t(a)]);
    }
    source.shared_through = nullptr;
    std::vector<double> outflow;
    outflow.reserve(faces_);
    each_face([&](size_t k, int face) {
        const ExposedVoxel& voxel = p1_.exposed()[k];
        source.rhs[voxel.slot] -= p1_.conductance(voxel, face) * source.sky_inflow[size_t(face)];
        outflow.push_back(source.outflow[k][size_t(face)]);
    });
    return outflow;
}

/// Turns the source of phi, after take_replaced(), into that of phi - phi_L, and completes source.outflow.
void SecondMoment::close(P1Source& source, const std::vector<double>& outflow) const
{
    const Blocks& blocks = p1_.blocks();
    const Moments moments = moments_of(swept_.moments);
    const std::vector<float> thick = thickest();
    const Swept swept(p1_, moments, thick);
    const P1Closure closure = p1_closure();
    const Vec3d& spacing = p1_.index().spacing();
    std::vector<float> cross(blocks.slots(), 0.0f), lower(blocks.slots(), 0.0f);
    float inverse[3];
    for (int b = 0; b < 3; ++b) inverse[b] = float(of_mixed / (2 * spacing[b]));
    for (int a = 0; a < 3; ++a) {
        const double h = spacing[a], area = p1_.face_area(a);
        // A conductance is that of the matrix, 2 divergence gradient / (sigma_tr + sigma_tr) area / h.
        const FaceLaw law{1 / h,
                          1 / area,
                          h / (area * closure.divergence * closure.gradient),
                          h / 2,
                          p1_.stencil().face[size_t(a)].data(),
                          thick.data()};
        each_block(blocks, [&](const BlockRows& rows) { cross_gradients(a, moments, rows, inverse, cross.data()); });
        each_block(blocks,
                   [&](const BlockRows& rows) { lower_fluxes(a, moments, law, rows, cross.data(), lower.data()); });
        each_block(blocks, [&](const BlockRows& rows) { add_fluxes(a, rows, lower.data(), area, source.rhs.data()); });
    }
    each_active(blocks, [&](size_t slot) { source.rhs[slot] -= p1_.sigma_a(slot) * p1_.hbar() * swept.fluence(slot); });
    size_t n = 0;
    each_face([&](size_t k, int face) {
        close_face(swept, source, k, face, swept_.tally[n], outflow[n]);
        ++n;
    });
}

}  // namespace vdbcloud
