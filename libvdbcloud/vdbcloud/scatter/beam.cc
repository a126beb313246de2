#include "vdbcloud/scatter/beam.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/optics/optical_depth.h"
#include "vdbcloud/scatter/free_flux.h"
#include "vdbcloud/sweep/light_lattice.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbcloud {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

Vec3d unit_vector(int axis, double length)
{
    Vec3d v(0, 0, 0);
    v[axis] = length;
    return v;
}

template<typename F>
void each_active(const Blocks& blocks, const F& f)
{
    tbb::parallel_for(size_t(0), blocks.count(), [&](size_t b) {
        for (size_t slot = b * 512; slot < b * 512 + 512; ++slot)
            if (blocks.active(slot)) f(slot);
    });
}

Vec3d as_double(const Vec3i& v) { return Vec3d(v.x(), v.y(), v.z()); }

/// Depths at voxel + offset for all voxels of the blocks that `wanted` names (all if it is empty); 0 in the others.
std::vector<float> lattice_depths(const VoxelIndex& index, const BrickMap& density, const Light& light, const Vec3d& offset,
                                  int rays_per_voxel, const std::vector<char>& wanted, const Progress& progress)
{
    const Blocks& blocks = index.blocks();
    VoxelBlocks targets;
    for (size_t b = 0; b < blocks.count(); ++b)
        if (wanted.empty() || wanted[b]) targets.block.push_back(blocks.at(b));
    targets.value.assign(targets.block.size() * 512, 0.0f);
    lattice_depth(density, light.to_light.unit(), {rays_per_voxel, offset}, targets, progress);
    if (wanted.empty()) {
        targets.value.resize(blocks.slots(), 0.0f);
        return std::move(targets.value);
    }
    std::vector<float> all(blocks.slots(), 0.0f);
    size_t from = 0;
    for (size_t b = 0; b < blocks.count(); ++b)
        if (wanted[b]) {
            std::copy_n(targets.value.begin() + ptrdiff_t(from), 512, all.begin() + ptrdiff_t(b * 512));
            from += 512;
        }
    return all;
}

/// Depth from one point of block coordinates to a point light.
float lamp_depth(const VoxelIndex& index, const BrickMap& density, const Light& light, const Vec3d& voxel)
{
    const Vec3d x = index.world(voxel), to = light.position - x;
    const double r = to.length();
    return r > 0 ? float(density_depth(density, {x, to / r}, 0, r)) : 0.0f;
}

/// Where an exposed face is asked, relative to its centre [voxels]: half a voxel out of the cell along the beam, which
/// travels along `travel` [unit, index space]; at most one voxel.
Vec3d beyond_face(const Vec3d& travel, int axis, int up)
{
    const double along = travel[axis] * (up ? 1 : -1);  // > 0 where the beam leaves
    if (along == 0) return Vec3d(0, 0, 0);
    return travel * std::copysign(std::min(0.5 / std::abs(along), 1.0), along);
}

/// Direction of travel of the light at a point, in index space.
Vec3d index_travel(const VoxelIndex& index, const Vec3d& world_travel)
{
    Vec3d d;
    for (int a = 0; a < 3; ++a) d[a] = world_travel.dot(index.axis(a)) / index.spacing()[a];
    return d.unit();
}

/// Signed solid angle under which a triangle is seen from the origin (Van Oosterom & Strackee 1983).
double solid_angle(const Vec3d& a, const Vec3d& b, const Vec3d& c)
{
    const double la = a.length(), lb = b.length(), lc = c.length();
    return 2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + a.dot(c) * lb + b.dot(c) * la);
}

/// A point light inside a voxel brings its whole power, 4 pi I, into it; the faces then carry out what leaves.
void add_lamp_inside(const P1Operator& p1, const Light& light, const std::vector<std::pair<P1Source*, double>>& channels)
{
    if (light.kind != LightKind::Point) return;
    const VoxelIndex& index = p1.index();
    const Vec3d from_origin = light.position - index.world(Vec3d(0, 0, 0));
    Vec3i voxel;
    for (int a = 0; a < 3; ++a) voxel[a] = int(std::floor(from_origin.dot(index.axis(a)) / index.spacing()[a] + 0.5));
    const size_t slot = index.blocks().slot(voxel);
    if (!index.blocks().active(slot)) return;
    const double power = 4 * M_PI, w0 = p1.scaling(slot).albedo;
    for (const auto& [to, strength] : channels) {
        to->rhs[slot] += strength * w0 * power / (p1.hbar() * p1.hbar());
        to->beam_in += strength * power;
        to->deposited += strength * power;
        to->first_scatter += strength * w0 * power;
    }
}

/// Sums density x length from a point towards the light through voxels of constant density, wrapping periodic axes.
class PeriodicMarch {
public:
    PeriodicMarch(const VoxelIndex& of, const std::vector<float>& values, const Light& light)
        : index_(of), density_(values)
    {
        const Vec3d to = light.to_light.unit();
        lo_ = Vec3i(std::numeric_limits<int>::max());
        hi_ = Vec3i(std::numeric_limits<int>::min());
        for (size_t b = 0; b < of.blocks().count(); ++b)
            for (int a = 0; a < 3; ++a) {
                lo_[a] = std::min(lo_[a], of.blocks().at(b)[a] * 8);
                hi_[a] = std::max(hi_[a], of.blocks().at(b)[a] * 8 + 7);
            }
        bool leaves = false;
        for (int a = 0; a < 3; ++a) {
            step_[a] = to.dot(of.axis(a)) / of.spacing()[a];
            if (std::abs(step_[a]) < 1e-12) step_[a] = 0;
            leaves = leaves || (of.blocks().period()[a] == 0 && step_[a] != 0);
        }
        if (light.kind != LightKind::Directional || !leaves)
            throw InputError("light '" + light.name + "': in a periodic medium expected a directional light that is not "
                             "parallel to every axis that ends");
    }

    /// Depth from a point (block coordinates) to infinity.
    double operator()(const Vec3d& from) const
    {
        int cell[3];
        double next[3];
        for (int a = 0; a < 3; ++a) {
            const double p = from[a] + 0.5;
            const bool on_face = std::abs(p - std::round(p)) < 1e-9;
            cell[a] = int(on_face ? std::round(p) : std::floor(p));
            if (on_face && step_[a] < 0) --cell[a];
            next[a] = step_[a] > 0 ? (cell[a] + 1 - p) / step_[a] : step_[a] < 0 ? (cell[a] - p) / step_[a] : infinity;
        }
        double t = 0, depth = 0;
        while (inside(cell)) {
            const int a = next[0] <= next[1] ? (next[0] <= next[2] ? 0 : 2) : (next[1] <= next[2] ? 1 : 2);
            depth += density_[index_.blocks().slot(Vec3i(cell[0], cell[1], cell[2]))] * (next[a] - t);
            t = next[a];
            cell[a] += step_[a] > 0 ? 1 : -1;
            next[a] += 1 / std::abs(step_[a]);
        }
        return depth;
    }

    const Vec3i& lo() const { return lo_; }
    const Vec3i& hi() const { return hi_; }
    const Vec3d& step() const { return step_; }

private:
    bool inside(const int* cell) const
    {
        for (int a = 0; a < 3; ++a)
            if (index_.blocks().period()[a] == 0 &&
                ((step_[a] >= 0 && cell[a] > hi_[a]) || (step_[a] <= 0 && cell[a] < lo_[a])))
                return false;
        return true;
    }
    const VoxelIndex& index_;
    const std::vector<float>& density_;
    Vec3d step_;
    Vec3i lo_, hi_;
};

}  // namespace

FreeFlux::FreeFlux(const P1Operator& p1, const Light& light) : index_(p1.index()), light_(light)
{
    for (int a = 0; a < 3; ++a) constant_[a] = -light.to_light.unit().dot(index_.axis(a)) * p1.face_area(a);
    unit_ = p1.hbar() * p1.hbar();
}

double FreeFlux::operator()(size_t slot, int axis, int up) const
{
    if (light_.kind == LightKind::Directional) return constant_[axis];
    const Vec3d centre = as_double(index_.blocks().voxel(slot)) + unit_vector(axis, up ? 0.5 : -0.5);
    const int b = (axis + 1) % 3, c = (axis + 2) % 3;
    Vec3d corner[4];
    for (int k = 0; k < 4; ++k)
        corner[k] = index_.world(centre + unit_vector(b, k == 1 || k == 2 ? 0.5 : -0.5) + unit_vector(c, k >= 2 ? 0.5 : -0.5)) -
                    light_.position;
    const double angle = solid_angle(corner[0], corner[1], corner[2]) + solid_angle(corner[0], corner[2], corner[3]);
    const double side = (corner[0] + corner[2]).dot(index_.axis(axis));  // where the light comes from decides the sign
    return std::copysign(std::abs(angle), side) / unit_;
}

BeamDepths beam_depths(const VoxelIndex& index, const std::vector<ExposedVoxel>& exposed, const BrickMap& density,
                       const Light& light, int rays_per_voxel, const Progress& progress)
{
    const Blocks& blocks = index.blocks();
    BeamDepths depths;
    depths.light = light;
    depths.exposed.resize(exposed.size());
    if (light.kind == LightKind::Point) {
        for (int a = 0; a < 3; ++a) {
            depths.lower[a].assign(blocks.slots(), 0.0f);
            each_active(blocks, [&](size_t slot) {
                depths.lower[a][slot] =
                    lamp_depth(index, density, light, as_double(blocks.voxel(slot)) + unit_vector(a, -0.5));
            });
        }
        tbb::parallel_for(size_t(0), exposed.size(), [&](size_t k) {
            for (int face = 0; face < 6; ++face) {
                if (!(exposed[k].faces >> face & 1)) continue;
                const Vec3d centre =
                    as_double(blocks.voxel(exposed[k].slot)) + unit_vector(face / 2, face % 2 ? 0.5 : -0.5);
                const Vec3d away = index.world(centre) - light.position;
                const Vec3d shift = away.length() > 0 ? beyond_face(index_travel(index, away), face / 2, face % 2) : Vec3d(0.0);
                depths.exposed[k][face] = lamp_depth(index, density, light, centre + shift);
            }
        });
        return depths;
    }
    int done = 0;
    const auto part = [&] {
        const double before = done++;
        return progress ? Progress([&progress, before](double f) { return progress((before + f) / 9); }) : Progress();
    };
    const Vec3d travel = index_travel(index, -light.to_light.unit());
    for (int a = 0; a < 3; ++a) {
        depths.lower[a] = lattice_depths(index, density, light, unit_vector(a, -0.5), rays_per_voxel, {}, part());
        for (int up = 0; up < 2; ++up) {
            const int face = 2 * a + up;
            std::vector<char> wanted(blocks.count(), 0);
            bool any = false;
            for (const ExposedVoxel& voxel : exposed)
                if (voxel.faces >> face & 1) {
                    wanted[voxel.slot / 512] = 1;
                    any = true;
                }
            if (!any || travel[a] == 0) continue;
            const Vec3d offset = unit_vector(a, up ? 0.5 : -0.5) + beyond_face(travel, a, up);
            const auto beyond = lattice_depths(index, density, light, offset, rays_per_voxel, wanted, part());
            for (size_t k = 0; k < exposed.size(); ++k)
                if (exposed[k].faces >> face & 1) depths.exposed[k][face] = beyond[exposed[k].slot];
        }
    }
    return depths;
}

BeamDepths periodic_beam_depths(const VoxelIndex& index, const std::vector<ExposedVoxel>& exposed,
                                const std::vector<float>& density, const Light& light)
{
    const PeriodicMarch march(index, density, light);
    BeamDepths depths;
    depths.light = light;
    const Blocks& blocks = index.blocks();
    for (int a = 0; a < 3; ++a) {
        depths.lower[a].assign(blocks.slots(), 0.0f);
        each_active(blocks, [&](size_t slot) {
            depths.lower[a][slot] = float(march(as_double(blocks.voxel(slot)) + unit_vector(a, -0.5)));
        });
    }
    depths.exposed.resize(exposed.size());
    tbb::parallel_for(size_t(0), exposed.size(), [&](size_t k) {
        const Vec3d centre = as_double(blocks.voxel(exposed[k].slot));
        for (int face = 0; face < 6; ++face)
            depths.exposed[k][face] =
                exposed[k].faces >> face & 1 ? float(march(centre + unit_vector(face / 2, face % 2 ? 0.5 : -0.5))) : 0.0f;
    });
    return depths;
}

LineDepths line_depths(const VoxelIndex& index, const BrickMap& density, const Light& light)
{
    LineDepths lines;
    const Vec3d z = light.to_light.unit();
    const Vec3d x = (std::abs(z[0]) < 0.5 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0)).cross(z).unit(), y = z.cross(x);
    const double spacing = std::cbrt(index.spacing()[0] * index.spacing()[1] * index.spacing()[2]);
    lines.area = spacing * spacing;
    double lo[3], hi[3];
    std::fill(lo, lo + 3, infinity);
    std::fill(hi, hi + 3, -infinity);
    for (size_t b = 0; b < index.blocks().count(); ++b)
        for (int k = 0; k < 8; ++k) {
            const Vec3d corner(k & 1 ? 8.5 : -1.5, k & 2 ? 8.5 : -1.5, k & 4 ? 8.5 : -1.5);
            const Vec3d p = index.world(8.0 * as_double(index.blocks().at(b)) + corner);
            const double along[3] = {p.dot(x), p.dot(y), p.dot(z)};
            for (int a = 0; a < 3; ++a) {
                lo[a] = std::min(lo[a], along[a]);
                hi[a] = std::max(hi[a], along[a]);
            }
        }
    if (!(hi[0] > lo[0])) return lines;
    const size_t nx = size_t((hi[0] - lo[0]) / spacing) + 1, ny = size_t((hi[1] - lo[1]) / spacing) + 1;
    lines.depth.assign(nx * ny, 0.0);
    tbb::parallel_for(size_t(0), nx, [&](size_t i) {
        for (size_t j = 0; j < ny; ++j) {
            const Vec3d from = x * (lo[0] + spacing * (double(i) + 0.5)) + y * (lo[1] + spacing * (double(j) + 0.5)) + z * lo[2];
            lines.depth[i * ny + j] = density_depth(density, {from, z}, 0, infinity);
        }
    });
    return lines;
}

LineDepths periodic_line_depths(const VoxelIndex& index, const std::vector<float>& density, const Light& light)
{
    const PeriodicMarch march(index, density, light);
    LineDepths lines;
    // Lines start on the side of the box away from the light, across an axis that ends, one in each voxel of that side.
    int across = 0;
    for (int a = 0; a < 3; ++a)
        if (index.blocks().period()[a] == 0 && march.step()[a] != 0) across = a;
    const int b = (across + 1) % 3, c = (across + 2) % 3;
    const Vec3d h = index.spacing();
    lines.area = h[b] * h[c] * std::abs(light.to_light.unit().dot(index.axis(across)));
    Vec3d from;
    from[across] = march.step()[across] > 0 ? march.lo()[across] - 0.5 : march.hi()[across] + 0.5;
    for (int i = march.lo()[b]; i <= march.hi()[b]; ++i)
        for (int j = march.lo()[c]; j <= march.hi()[c]; ++j) {
            from[b] = i + 0.21;  // off the cells' edges
            from[c] = j - 0.17;
            lines.depth.push_back(march(from));
        }
    return lines;
}

double lost_power(const LineDepths& lines, double extinction)
{
    double lost = 0;
    for (double depth : lines.depth) lost -= std::expm1(-extinction * depth);
    return lost * lines.area;
}

void add_beam(const P1Operator& p1, const BeamDepths& depths, double extinction,
              const std::vector<std::pair<P1Source*, double>>& channels)
{
    const Blocks& blocks = p1.blocks();
    const FreeFlux free(p1, depths.light);
    const double unit = p1.hbar() * p1.hbar();
    const bool forward = p1.medium().g != 0;
    for (const auto& [source, strength] : channels)
        for (auto& additive : source->additive)
            if (forward && additive.empty()) additive.assign(blocks.slots(), 0.0f);

    std::vector<double> u(blocks.slots(), 0.0), upper(p1.exposed().size(), 0.0);
    add_lamp_inside(p1, depths.light, channels);
    for (int a = 0; a < 3; ++a) {
        each_active(blocks, [&](size_t slot) {
            u[slot] = free(slot, a, 0) * std::exp(-extinction * double(depths.lower[a][slot]));
        });
        double in = 0, out = 0;  // through exposed faces
        for (size_t k = 0; k < p1.exposed().size(); ++k) {
            const ExposedVoxel& voxel = p1.exposed()[k];
            for (int up = 0; up < 2; ++up) {
                if (!(voxel.faces >> (2 * a + up) & 1)) continue;
                const double value = free(voxel.slot, a, up) * std::exp(-extinction * double(depths.exposed[k][2 * a + up]));
                (up ? upper[k] : u[voxel.slot]) = value;
                ((up ? value < 0 : value > 0) ? in : out) += std::abs(value);
            }
        }
        const auto q_face = [&](size_t i, size_t j) {  // of Q1 / sigma_tr = q U between two cells
            return (p1.q1_factor(i) + p1.q1_factor(j)) / (p1.sigma_tr(i) + p1.sigma_tr(j));
        };
        std::vector<double> scattered(blocks.count(), 0.0);
        tbb::parallel_for(size_t(0), blocks.count(), [&](size_t b) {
            for (size_t slot = b * 512; slot < b * 512 + 512; ++slot) {
                if (!blocks.active(slot)) continue;
                const size_t below = blocks.neighbour(slot, 2 * a), above = blocks.neighbour(slot, 2 * a + 1);
                const bool has_below = blocks.active(below), has_above = blocks.active(above);
                const double deposit = u[slot] - (has_above ? u[above] : 0.0);  // exposed upper faces follow below
                const double w0 = p1.scaling(slot).albedo;
                scattered[b] += w0 * deposit;
                double source = w0 * deposit, mean = 0;
                if (forward) {
                    const double al = has_below ? q_face(below, slot) * u[slot] : 0.0;
                    const double au = has_above ? q_face(slot, above) * u[above] : 0.0;
                    source += al - au;
                    mean = (al + au) / 2 / p1.face_area(a);
                }
                for (const auto& [to, strength] : channels) {
                    to->rhs[slot] += strength * source;
                    if (forward) to->additive[a][slot] += float(strength * mean);
                }
            }
        });
        double first_scatter = 0;
        for (double s : scattered) first_scatter += s;
        for (size_t k = 0; k < p1.exposed().size(); ++k) {
            const ExposedVoxel& voxel = p1.exposed()[k];
            const double q = p1.q1_factor(voxel.slot) / p1.sigma_tr(voxel.slot), w0 = p1.scaling(voxel.slot).albedo;
            for (int up = 0; up < 2; ++up) {
                if (!(voxel.faces >> (2 * a + up) & 1)) continue;
                const double outward = up ? upper[k] : -u[voxel.slot];
                const double leaving = p1.boundary_flux(voxel, a, q * outward / p1.face_area(a)) * p1.face_area(a);
                const double source = (up ? -w0 * upper[k] : 0.0) - leaving;
                if (up) first_scatter -= w0 * upper[k];
                for (const auto& [to, strength] : channels) {
                    to->rhs[voxel.slot] += strength * source;
                    to->outflow[k][2 * a + up] += strength * leaving;
                    if (forward)
                        to->additive[a][voxel.slot] += float(strength * (up ? leaving : -leaving) / 2 / p1.face_area(a));
                }
            }
        }
        for (const auto& [to, strength] : channels) {
            to->beam_in += unit * strength * in;
            to->beam_out += unit * strength * out;
            to->deposited += unit * strength * (in - out);
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
    if (k < -40) return std::copysign(std::sqrt(std::abs(face)) * std::sqrt(std::abs(other)), face) / -k;  // exp would overflow
    return face * (std::abs(k) < 1e-4 ? -k / 2 : -std::expm1(-k) / k - 1);
}

}  // namespace

void add_beam_profile(const P1Operator& p1, const BeamDepths& depths, double extinction,
                      const std::vector<std::pair<P1Source*, double>>& channels)
{
    const Blocks& blocks = p1.blocks();
    const FreeFlux free(p1, depths.light);
    for (const auto& [source, strength] : channels)
        for (auto& additive : source->additive)
            if (additive.empty()) additive.assign(blocks.slots(), 0.0f);
    const auto factor = [&](size_t slot) { return p1.scaling(slot).albedo + p1.q1_factor(slot) / p1.sigma_tr(slot); };
    for (int a = 0; a < 3; ++a) {
        std::vector<double> lower(blocks.slots(), 0.0), upper(blocks.slots(), 0.0), flux(blocks.slots(), 0.0);
        each_active(blocks, [&](size_t slot) {
            lower[slot] = free(slot, a, 0) * std::exp(-extinction * double(depths.lower[a][slot]));
        });
        each_active(blocks, [&](size_t slot) {
            const size_t above = blocks.neighbour(slot, 2 * a + 1);
            if (blocks.active(above)) upper[slot] = lower[above];
        });
        for (size_t k = 0; k < p1.exposed().size(); ++k)
            for (int up = 0; up < 2; ++up)
                if (const size_t slot = p1.exposed()[k].slot; p1.exposed()[k].faces >> (2 * a + up) & 1)
                    (up ? upper : lower)[slot] = free(slot, a, up) * std::exp(-extinction * double(depths.exposed[k][2 * a + up]));
        each_active(blocks, [&](size_t slot) {  // through lower faces between cells
            const size_t below = blocks.neighbour(slot, 2 * a);
            if (!blocks.active(below)) return;
            const double own = p1.sigma_tr(slot), other = p1.sigma_tr(below);
            flux[slot] = (own * factor(slot) * half_cell_deviation(lower[slot], upper[slot]) +
                          other * factor(below) * half_cell_deviation(lower[slot], lower[below])) / (own + other);
        });
        for (const auto& [to, strength] : channels)
            each_active(blocks, [&, to = to, strength = strength](size_t slot) {
                const size_t above = blocks.neighbour(slot, 2 * a + 1);
                const double through = blocks.active(above) ? flux[above] : 0.0;
                to->rhs[slot] += strength * (flux[slot] - through);
                to->additive[a][slot] += float(strength * (flux[slot] + through) / 2 / p1.face_area(a));
            });
        for (size_t k = 0; k < p1.exposed().size(); ++k)
            for (int up = 0; up < 2; ++up) {
                const ExposedVoxel& voxel = p1.exposed()[k];
                if (!(voxel.faces >> (2 * a + up) & 1)) continue;
                const double lo = lower[voxel.slot], hi = upper[voxel.slot];
                const double outward = factor(voxel.slot) * (up ? half_cell_deviation(hi, lo) : -half_cell_deviation(lo, hi));
                const double leaving = p1.boundary_flux(voxel, a, outward / p1.face_area(a)) * p1.face_area(a);
                for (const auto& [to, strength] : channels) {
                    to->rhs[voxel.slot] -= strength * leaving;
                    to->outflow[k][2 * a + up] += float(strength * leaving);
                    to->additive[a][voxel.slot] += float(strength * (up ? leaving : -leaving) / 2 / p1.face_area(a));
                }
            }
    }
}

std::vector<float> beam_fluence(const P1Operator& p1, const BeamDepths& depths, double extinction)
{
    const Blocks& blocks = p1.blocks();
    const FreeFlux free(p1, depths.light);
    std::vector<double> taken(blocks.slots(), 0.0), lower(blocks.slots(), 0.0);
    std::vector<float> least(blocks.slots(), std::numeric_limits<float>::max());  // depth among a cell's lower faces
    const auto note = [&](size_t slot, float depth) { least[slot] = std::min(least[slot], depth); };
    for (int a = 0; a < 3; ++a) {
        each_active(blocks, [&](size_t slot) {
            lower[slot] = free(slot, a, 0) * std::exp(-extinction * double(depths.lower[a][slot]));
            note(slot, depths.lower[a][slot]);
        });
        for (size_t k = 0; k < p1.exposed().size(); ++k) {
            const ExposedVoxel& voxel = p1.exposed()[k];
            for (int up = 0; up < 2; ++up) {
                if (!(voxel.faces >> (2 * a + up) & 1)) continue;
                const double value = free(voxel.slot, a, up) * std::exp(-extinction * double(depths.exposed[k][2 * a + up]));
                if (free(voxel.slot, a, up) != 0) note(voxel.slot, depths.exposed[k][2 * a + up]);
                if (up)
                    taken[voxel.slot] -= value;
                else
                    lower[voxel.slot] = value;
            }
        }
        each_active(blocks, [&](size_t slot) {
            const size_t above = blocks.neighbour(slot, 2 * a + 1);
            taken[slot] += lower[slot] - (blocks.active(above) ? lower[above] : 0.0);
            if (blocks.active(above)) note(slot, depths.lower[a][above]);
        });
    }
    P1Source lamp(p1);  // a lamp inside a cell brings its whole power there
    add_lamp_inside(p1, depths.light, {{&lamp, 1.0}});
    std::vector<float> fluence(blocks.slots(), 0.0f);
    each_active(blocks, [&](size_t slot) {
        const DeltaScaling scaling = p1.scaling(slot);
        const double inside = lamp.rhs[slot] != 0 ? lamp.rhs[slot] / scaling.albedo : 0.0;
        const double rate = scaling.extinction * p1.sigma_t(slot) * p1.hbar();
        const double mean = std::max(taken[slot] + inside, 0.0) / rate;
        // Beside a dense voxel a thin one has a share of its power, as density is trilinear, but not its collision rate.
        double most = std::exp(-extinction * double(least[slot]));
        if (depths.light.kind == LightKind::Point) {
            const double r = (p1.index().world(as_double(blocks.voxel(slot))) - depths.light.position).length();
            most = inside > 0 || r == 0 ? mean : most / (r * r);
        }
        fluence[slot] = float(std::min(mean, most));
    });
    return fluence;
}

}  // namespace vdbcloud
