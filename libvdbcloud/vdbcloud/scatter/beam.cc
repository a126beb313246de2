#include "vdbcloud/scatter/beam.h"

#include "vdbcloud/core/release.h"
#include "vdbcloud/scatter/active_slots.h"
#include "vdbcloud/scatter/exposed_beam.h"
#include "vdbcloud/scatter/free_flux.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

Vec3d unit_vector(int axis, double length)
{
    Vec3d v(0, 0, 0);
    v[axis] = length;
    return v;
}

Vec3d as_double(const Vec3i& v) { return Vec3d(v.x(), v.y(), v.z()); }

/// exp(-tau), and exp(-tau) - 1, to rounding of each, from one of them.
struct Transmitted {
    double part, less;
    explicit Transmitted(double tau)
        : part(tau < 0.5 ? 1 : std::exp(-tau)), less(tau < 0.5 ? std::expm1(-tau) : part - 1)
    {
        if (tau < 0.5) part += less;
    }
};

/// Notes the absorbed part of what a cell takes from a beam, where the source asks for it.
void add_absorbed(const P1Operator& p1, size_t slot, double deposit, P1Source& to)
{
    if (!to.beam_absorbed.empty()) to.beam_absorbed[slot] += (1 - p1.scaling(slot).albedo) * deposit;
}

/// The slot of the voxel that a point source is in; an inactive one where it is in none.
size_t slot_of_source(const VoxelIndex& index, const Light& light)
{
    const auto point = light->source();
    if (!point) return index.blocks().count() * 512;
    const Vec3d from_origin = point->position - index.world(Vec3d(0, 0, 0));
    Vec3i voxel;
    for (int a = 0; a < 3; ++a) voxel[a] = int(std::floor(from_origin.dot(index.axis(a)) / index.spacing()[a] + 0.5));
    return index.blocks().slot(voxel);
}

/// A point source inside a voxel deposits its whole power there; the flux through the faces subtracts what leaves.
void add_source_inside(const P1Operator& p1, const Light& light,
                       const std::vector<std::pair<P1Source*, double>>& channels)
{
    const size_t slot = slot_of_source(p1.index(), light);
    if (!p1.blocks().active(slot)) return;
    const double power = light->source()->power, w0 = p1.scaling(slot).albedo;
    for (const auto& [to, strength] : channels) {
        to->rhs[slot] += strength * w0 * power / (p1.hbar() * p1.hbar());
        to->beam_in += strength * power;
        to->deposited += strength * power;
        to->first_scatter += strength * w0 * power;
        add_absorbed(p1, slot, strength * power / (p1.hbar() * p1.hbar()), *to);
    }
}

}  // namespace

FreeFlux::FreeFlux(const P1Operator& p1, const Light& light) : index_(p1.index()), light_(light)
{
    const auto to_light = light->common_direction();
    same_everywhere_ = to_light.has_value();
    for (int a = 0; a < 3 && to_light; ++a) constant_[a] = -to_light->dot(index_.axis(a)) * p1.face_area(a);
    unit_ = p1.hbar() * p1.hbar();
}

double FreeFlux::operator()(size_t slot, int axis, int up) const
{
    if (same_everywhere_) return constant_[axis];
    const Vec3d centre = as_double(index_.blocks().voxel(slot)) + unit_vector(axis, up ? 0.5 : -0.5);
    const int b = (axis + 1) % 3, c = (axis + 2) % 3;
    std::array<Vec3d, 4> corner;
    for (int k = 0; k < 4; ++k)
        corner[k] =
            index_.world(centre + unit_vector(b, k == 1 || k == 2 ? 0.5 : -0.5) + unit_vector(c, k >= 2 ? 0.5 : -0.5));
    return light_->power_through(corner, index_.axis(axis)) / unit_;
}

void add_beam(const P1Operator& p1, const BeamDepths& depths, double extinction,
              const std::vector<std::pair<P1Source*, double>>& channels)
{
    const Blocks& blocks = p1.blocks();
    const FreeFlux free(p1, depths.light);
    const ExposedBeam at_exposed(p1, depths, extinction);
    const double unit = p1.hbar() * p1.hbar();
    const bool forward = p1.mean_cosine() != 0;
    if (forward) p1.stencil();  // for q1_share()

    // U on lower faces and on exposed upper faces, and U - free.common(): where a medium is thin, what a cell loses is
    // a difference that U keeps to few digits.
    std::vector<double> u(blocks.slots(), 0.0), upper(p1.exposed().size(), 0.0), less(blocks.slots(), 0.0),
        upper_less(p1.exposed().size(), 0.0);
    add_source_inside(p1, depths.light, channels);
    for (int a = 0; a < 3; ++a) {
        for (const auto& [source, strength] : channels)
            if (forward) source->through_faces(a);
        const double common = free.common(a);
        each_active(blocks, [&](size_t slot) {
            const Transmitted t(extinction * double(depths.lower[a][slot]));
            u[slot] = free(slot, a, 0) * t.part;
            less[slot] = common * t.less;
        });
        // What is lost between faces of U `lower` and `upper`: the exacter of two differences.
        const auto lost_between = [&](double lower, double lower_less, double above, double above_less) {
            const bool thin =
                common != 0 && std::max(std::abs(lower_less), std::abs(above_less)) < std::abs(common) / 2;
            return thin ? lower_less - above_less : lower - above;
        };
        double in = 0, out = 0;  // through exposed faces
        for (size_t k = 0; k < p1.exposed().size(); ++k) {
            const ExposedVoxel& voxel = p1.exposed()[k];
            for (int up = 0; up < 2; ++up) {
                if (!(voxel.faces >> (2 * a + up) & 1)) continue;
                const auto t = at_exposed(k, 2 * a + up);
                const double value = free(voxel.slot, a, up) * t.part;
                const double sight = depths.sight(voxel.slot);
                (up ? upper[k] : u[voxel.slot]) = value;
                (up ? upper_less[k] : less[voxel.slot]) = common * t.less;
                ((up ? value < 0 : value > 0) ? in : out) += sight * std::abs(value);
            }
        }
        std::vector<double> scattered(blocks.count(), 0.0), lost(blocks.count(), 0.0);
        tbb::parallel_for(size_t(0), blocks.count(), [&](size_t b) {
            for (size_t slot = b * 512; slot < b * 512 + 512; ++slot) {
                if (!blocks.active(slot)) continue;
                const size_t below = beside(blocks, slot, 2 * a), above = beside(blocks, slot, 2 * a + 1);
                const bool has_below = blocks.active(below), has_above = blocks.active(above);
                // Cells with an exposed upper face follow below.
                const double deposit =
                    has_above ? depths.sight(slot) * lost_between(u[slot], less[slot], u[above], less[above]) : 0.0;
                const double w0 = p1.scaling(slot).albedo;
                scattered[b] += w0 * deposit;
                lost[b] += deposit;
                double source = w0 * deposit, lower = 0;  // and Q1's flux through the lower face
                if (forward) {
                    const double al = has_below ? depths.sight(slot, below) * p1.q1_share(a, below) * u[slot] : 0.0;
                    const double au = has_above ? depths.sight(slot, above) * p1.q1_share(a, slot) * u[above] : 0.0;
                    source += al - au;
                    lower = al / p1.face_area(a);
                }
                for (const auto& [to, strength] : channels) {
                    to->rhs[slot] += strength * source;
                    add_absorbed(p1, slot, strength * deposit, *to);
                    if (forward) to->through[a][slot] += strength * lower;
                }
            }
        });
        double first_scatter = 0, deposited = 0;
        for (double s : scattered) first_scatter += s;
        for (double s : lost) deposited += s;
        for (size_t k = 0; k < p1.exposed().size(); ++k) {
            const ExposedVoxel& voxel = p1.exposed()[k];
            const double q = p1.q1_factor(voxel.slot) / p1.sigma_tr(voxel.slot), w0 = p1.scaling(voxel.slot).albedo;
            for (int up = 0; up < 2; ++up) {
                if (!(voxel.faces >> (2 * a + up) & 1)) continue;
                const double sight = depths.sight(voxel.slot), outward = sight * (up ? upper[k] : -u[voxel.slot]);
                const double leaving =
                    p1.boundary_flux(voxel, 2 * a + up, q * outward / p1.face_area(a)) * p1.face_area(a);
                const double deposit =
                    up ? sight * lost_between(u[voxel.slot], less[voxel.slot], upper[k], upper_less[k]) : 0.0;
                const double source = w0 * deposit - leaving;
                first_scatter += w0 * deposit;
                deposited += deposit;
                for (const auto& [to, strength] : channels) {
                    to->rhs[voxel.slot] += strength * source;
                    if (up) add_absorbed(p1, voxel.slot, strength * deposit, *to);
                    to->outflow[k][2 * a + up] += strength * leaving;
                }
            }
        }
        for (const auto& [to, strength] : channels) {
            to->beam_in += unit * strength * in;
            to->beam_out += unit * strength * out;
            to->deposited += unit * strength * deposited;
            to->first_scatter += unit * strength * first_scatter;
        }
    }
}

namespace {

/// Mean of U over the half of a cell next to a face, less U on that face; U is `other` on the opposite face.
double half_cell_deviation(double face, double other)
{
    if (face == 0) return 0;
    if (other == 0 || (other > 0) != (face > 0)) return (other - face) / 4;
    const double k = (std::log(std::abs(face)) - std::log(std::abs(other))) / 2;
    if (k < -40)
        return std::copysign(std::sqrt(std::abs(face)) * std::sqrt(std::abs(other)), face) / -k;  // exp would overflow
    return face * (std::abs(k) < 1e-4 ? -k / 2 : -std::expm1(-k) / k - 1);
}

}  // namespace

void add_beam_profile(const P1Operator& p1, const BeamDepths& depths, double extinction,
                      const std::vector<std::pair<P1Source*, double>>& channels)
{
    const Blocks& blocks = p1.blocks();
    const FreeFlux free(p1, depths.light);
    const ExposedBeam at_exposed(p1, depths, extinction);
    const auto factor = [&](size_t slot) { return p1.scaling(slot).albedo + p1.q1_factor(slot) / p1.sigma_tr(slot); };
    for (int a = 0; a < 3; ++a) {
        std::vector<double> lower(blocks.slots(), 0.0), upper(blocks.slots(), 0.0), flux(blocks.slots(), 0.0);
        each_active(blocks, [&](size_t slot) {
            lower[slot] = free(slot, a, 0) * std::exp(-extinction * double(depths.lower[a][slot]));
        });
        each_active(blocks, [&](size_t slot) {
            const size_t above = beside(blocks, slot, 2 * a + 1);
            if (blocks.active(above)) upper[slot] = lower[above];
        });
        for (size_t k = 0; k < p1.exposed().size(); ++k)
            for (int up = 0; up < 2; ++up)
                if (const size_t slot = p1.exposed()[k].slot; p1.exposed()[k].faces >> (2 * a + up) & 1)
                    (up ? upper : lower)[slot] = free(slot, a, up) * at_exposed(k, 2 * a + up).part;
        each_active(blocks, [&](size_t slot) {  // through lower faces between cells
            const size_t below = beside(blocks, slot, 2 * a);
            if (!blocks.active(below)) return;
            const double own = p1.sigma_tr(slot), other = p1.sigma_tr(below);
            flux[slot] = depths.sight(slot, below) *
                         (own * factor(slot) * half_cell_deviation(lower[slot], upper[slot]) +
                          other * factor(below) * half_cell_deviation(lower[slot], lower[below])) /
                         (own + other);
        });
        for (const auto& [to, strength] : channels) {
            std::vector<double>& through = to->through_faces(a);
            each_active(blocks, [&, to = to, strength = strength](size_t slot) {
                const size_t above = beside(blocks, slot, 2 * a + 1);
                to->rhs[slot] += strength * (flux[slot] - (blocks.active(above) ? flux[above] : 0.0));
                through[slot] += strength * flux[slot] / p1.face_area(a);
            });
        }
        for (size_t k = 0; k < p1.exposed().size(); ++k)
            for (int up = 0; up < 2; ++up) {
                const ExposedVoxel& voxel = p1.exposed()[k];
                if (!(voxel.faces >> (2 * a + up) & 1)) continue;
                const double lo = lower[voxel.slot], hi = upper[voxel.slot];
                const double outward = depths.sight(voxel.slot) * factor(voxel.slot) *
                                       (up ? half_cell_deviation(hi, lo) : -half_cell_deviation(lo, hi));
                const double leaving = p1.boundary_flux(voxel, 2 * a + up, outward / p1.face_area(a)) * p1.face_area(a);
                for (const auto& [to, strength] : channels) {
                    to->rhs[voxel.slot] -= strength * leaving;
                    to->outflow[k][2 * a + up] += strength * leaving;
                }
            }
    }
}

std::vector<float> mean_fluence(const P1Operator& p1, const BeamDepths& depths, double extinction)
{
    const Blocks& blocks = p1.blocks();
    const FreeFlux free(p1, depths.light);
    const ExposedBeam at_exposed(p1, depths, extinction);
    std::vector<double> taken(blocks.slots(), 0.0), lower(blocks.slots(), 0.0);
    std::vector<float> brightest(blocks.slots(), 0.0f);  // T' among a cell's faces
    const auto note = [&](size_t slot, double t) { brightest[slot] = std::max(brightest[slot], float(t)); };
    for (int a = 0; a < 3; ++a) {
        each_active(blocks, [&](size_t slot) {
            const double t = std::exp(-extinction * double(depths.lower[a][slot]));
            lower[slot] = free(slot, a, 0) * t;
            note(slot, t);
        });
        for (size_t k = 0; k < p1.exposed().size(); ++k) {
            const ExposedVoxel& voxel = p1.exposed()[k];
            for (int up = 0; up < 2; ++up) {
                if (!(voxel.faces >> (2 * a + up) & 1)) continue;
                const double t = at_exposed(k, 2 * a + up).part, value = free(voxel.slot, a, up) * t;
                if (value != 0) note(voxel.slot, t);
                if (up)
                    taken[voxel.slot] -= value;
                else
                    lower[voxel.slot] = value;
            }
        }
        each_active(blocks, [&](size_t slot) {
            const size_t above = beside(blocks, slot, 2 * a + 1);
            taken[slot] += lower[slot] - (blocks.active(above) ? lower[above] : 0.0);
            if (blocks.active(above)) note(slot, std::exp(-extinction * double(depths.lower[a][above])));
        });
    }
    release(lower);
    const size_t of_lamp = slot_of_source(p1.index(), depths.light);
    std::vector<float> fluence(blocks.slots(), 0.0f);
    each_active(blocks, [&](size_t slot) {
        const ScaledCell scaling = p1.scaling(slot);
        const double inside = slot == of_lamp ? depths.light->source()->power / (p1.hbar() * p1.hbar()) : 0.0;
        const double rate = scaling.extinction * p1.sigma_t(slot) * p1.hbar();
        const double mean = std::max(taken[slot] + inside, 0.0) / rate;
        // Density is trilinear, so a thin voxel beside a dense voxel removes power at more than its own collision rate.
        // Without the cap its fluence would be too large.
        const double free_of_medium = depths.light->irradiance(p1.index().world(as_double(blocks.voxel(slot))));
        const double most = brightest[slot] * free_of_medium;
        fluence[slot] = float(depths.sight(slot) * (inside > 0 ? mean : std::min(mean, most)));
    });
    return fluence;
}

std::vector<float> beam_fluence(const P1Operator& p1, const BeamDepths& depths, const std::vector<float>& centre,
                                double extinction)
{
    std::vector<float> fluence = mean_fluence(p1, depths, extinction);
    const Blocks& blocks = p1.blocks();
    const size_t of_lamp = slot_of_source(p1.index(), depths.light);
    each_active(blocks, [&](size_t slot) {
        if (slot == of_lamp) return;
        const Vec3d place = p1.index().world(as_double(blocks.voxel(slot)));
        const double x = p1.scaling(slot).extinction * p1.sigma_t(slot) *
                         width_along(p1.index(), depths.light->towards(place).direction);
        const double free_of_medium = depths.light->irradiance(place);
        const double chord =
            depths.sight(slot) * free_of_medium * std::exp(-extinction * double(centre[slot])) / (1 + x * x / 12);
        fluence[slot] = float(chord + diffusive(x) * (fluence[slot] - chord));
    });
    return fluence;
}

}  // namespace vdbcloud
