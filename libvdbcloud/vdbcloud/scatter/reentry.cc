#include "vdbcloud/scatter/multiple_scattering.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/random.h"
#include "vdbcloud/voxels/emptiness.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace vdbcloud {

namespace {

/// True if a ray (voxel coordinates) meets an active voxel before it leaves the blocks' bounds. Counts its steps.
bool hits(const Blocks& blocks, const Emptiness& emptiness, Vec3d p, const Vec3d& d, const Vec3i& lo, const Vec3i& hi,
          size_t& steps)
{
    for (int step = 0; step < 100000; ++step, ++steps) {
        const Vec3d at(std::floor(p[0] + 0.5), std::floor(p[1] + 0.5), std::floor(p[2] + 0.5));
        for (int a = 0; a < 3; ++a)
            if (blocks.period()[a] == 0 && ((at[a] < lo[a] && d[a] <= 0) || (at[a] > hi[a] && d[a] >= 0))) return false;
        const Vec3i voxel{int(at[0]), int(at[1]), int(at[2])};
        const size_t slot = blocks.slot(voxel);
        if (blocks.active(slot)) return true;
        const bool exists = slot / Blocks::size < blocks.count();
        const Vec3i block(voxel[0] >> 3, voxel[1] >> 3, voxel[2] >> 3);
        // Periodic axes wrap, which cells of several blocks do not.
        const int bits = exists ? 0 : 3 + (blocks.period() == Vec3i(0) ? emptiness.bits(block) : 0);
        double t = std::numeric_limits<double>::infinity();
        for (int a = 0; a < 3; ++a) {
            if (d[a] == 0) continue;
            const double low = double(voxel[a] & -(int64_t(1) << bits)) - 0.5;
            t = std::min(t, ((d[a] > 0 ? low + double(int64_t(1) << bits) : low) - p[a]) / d[a]);
        }
        p += d * (std::max(t, 0.0) + 1e-6);
    }
    return false;
}

/// The plane of the box through which a ray from a point of the box leaves; -1: none, along periodic axes alone.
int plane_of(const ActiveBox& box, const Vec3d& p, const Vec3d& d)
{
    int face = -1;
    double nearest = std::numeric_limits<double>::infinity();
    for (int a = 0; a < 3; ++a) {
        if (box.periodic[size_t(a)] || d[a] == 0) continue;
        const double t = ((d[a] > 0 ? box.last[a] + 0.5 : box.first[a] - 0.5) - p[a]) / d[a];
        if (t >= nearest) continue;
        nearest = t;
        face = 2 * a + (d[a] > 0);
    }
    return face;
}

/// From components along the index axes.
Vec3d in_world(const VoxelIndex& index, const Vec3d& v)
{
    return v[0] * index.axis(0) + v[1] * index.axis(1) + v[2] * index.axis(2);
}

/// Power that rays carry away from exposed voxels.
struct Bundle {
    size_t steps = 0;                  // of rays through the blocks' bounds
    double back = 0;                   // of rays that meet the medium again
    std::array<double, 6> by_plane{};  // of the others
    std::array<double, 6> by_face{};   // the same power by the face that it passes
    double ahead = 0;                  // of by_plane, into the hemisphere of `reflected`

    double carried() const { return std::accumulate(by_plane.begin(), by_plane.end(), back); }
    double through_faces() const { return std::accumulate(by_face.begin(), by_face.end(), 0.0); }

    /// Makes the faces' power that of the rays, whose weight is 1 in the mean only. Where all rays leave through the
    /// planes of their faces, the two then agree without noise.
    void match_faces()
    {
        const double total = through_faces(), factor = total > 0 ? carried() / total : 0;
        for (double& power : by_face) power *= factor;
    }
    void operator+=(const Bundle& other)
    {
        steps += other.steps;
        back += other.back;
        ahead += other.ahead;
        for (size_t f = 0; f < 6; ++f) {
            by_plane[f] += other.by_plane[f];
            by_face[f] += other.by_face[f];
        }
    }
    /// Share that goes into the hemisphere, less the share that would if each face shone evenly.
    double moved_ahead(const Hemisphere& hemisphere) const
    {
        double excess = ahead;
        for (size_t f = 0; f < 6; ++f) excess -= hemisphere.of_face(int(f)) * by_face[f];
        return carried() > 0 ? excess / carried() : 0;
    }
    std::array<double, 6> moved() const
    {
        std::array<double, 6> shares{};
        const double total = carried();
        for (size_t f = 0; f < 6 && total > 0; ++f) shares[f] = (by_plane[f] - by_face[f]) / total;
        return shares;
    }
};

/// Weight of a ray along s by P1's radiance phi + 3 s.F, of mean 1 over a cosine distribution about the normal.
class RadianceWeight {
public:
    RadianceWeight(double phi, Vec3d flux, const Vec3d& normal) : phi_(phi), flux_(flux)
    {
        const double longest = longest_flux * std::max(phi, 0.0), length = flux.length();
        if (length > longest) flux_ *= longest / length;
        mean_ = phi_ + 2 * flux_.dot(normal);
    }
    double operator()(const Vec3d& s) const { return mean_ > 0 ? (phi_ + 3 * flux_.dot(s)) / mean_ : 1; }

private:
    double phi_, mean_;
    Vec3d flux_;
};

/// The light that leaves a medium, and what rays need of it.
struct Outflow {
    const P1Operator& p1;
    const P1Source& source;
    const std::vector<double>& phi;
    const std::array<std::vector<float>, 3>* flux;
    const Sky* sky;
    int channel;
    const Hemisphere& hemisphere;
    ActiveBox box{p1.blocks()};
    Emptiness emptiness{p1.blocks()};
    Vec3i lo{0, 0, 0}, hi{0, 0, 0};  // of the blocks

    /// `each` rays from the k-th exposed voxel: of its light, and of the sky's that enters there and goes straight on.
    std::pair<Bundle, Bundle> rays_from(size_t k, size_t each) const;
    Vec3d flux_at(size_t slot) const
    {
        return flux ? Vec3d((*flux)[0][slot], (*flux)[1][slot], (*flux)[2][slot]) : Vec3d(0.0);
    }
};

/// The outward normal of the surface at a voxel, where it is known and looks out of the exposed faces. `of_faces`: the
/// mean of the exposed faces' normals. It depends on the shape of voxels: long ones show a face across an edge, cubes
/// two or three.
Vec3d surface_normal(const ExposedVoxel& voxel, const Vec3d& of_faces)
{
    constexpr double least = 0.25;  // cosine
    Vec3d normal;
    for (int a = 0; a < 3; ++a) normal[a] = voxel.falling >> a & 1 ? voxel.weight[a] : -voxel.weight[a];
    return voxel.falling >> 3 && normal.dot(of_faces) > least ? normal.unit() : of_faces;
}

std::pair<Bundle, Bundle> Outflow::rays_from(size_t k, size_t each) const
{
    const VoxelIndex& index = p1.index();
    const ExposedVoxel& voxel = p1.exposed()[k];
    Bundle light, straight;
    Vec3d normal(0, 0, 0);
    for (size_t face = 0; face < 6; ++face) {
        // Light that leaves to the ground meets nothing else.
        if (!(voxel.faces >> face & 1) || voxel.grounded >> face & 1) continue;
        const int a = int(face / 2);
        normal[a] += face % 2 ? voxel.weight[a] : -voxel.weight[a];
        light.by_face[face] =
            std::max(0.0, p1.conductance(voxel, int(face)) * phi[voxel.slot] + double(source.outflow[k][face]));
        if (sky) straight.by_face[face ^ 1] = voxel.weight[a] * p1.face_area(a) * source.sky_inflow[face];
    }
    if (!(normal.length() > 1e-3)) return {};
    normal = surface_normal(voxel, normal.unit());
    const Vec3d t = (std::abs(normal[0]) < 0.5 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0)).cross(normal).unit(),
                u = normal.cross(t);
    const Vec3i at = p1.blocks().voxel(voxel.slot);
    Vec3d middle(at[0], at[1], at[2]);  // of the exposed faces, by power
    for (size_t face = 0; face < 6 && light.through_faces() > 0; ++face)
        middle[int(face / 2)] += (face % 2 ? 0.5 : -0.5) * light.by_face[face] / light.through_faces();
    const RadianceWeight weight(phi[voxel.slot], flux_at(voxel.slot), normal);
    const double share = light.through_faces() / double(each), of_sky = straight.through_faces() / double(each);
    const double sky_mean = of_sky > 0 ? sky->mean_inflow(in_world(index, normal))[channel] : 0;
    for (size_t r = 0; r < each; ++r) {
        const double z2 = uniform(hash_bits(17, k, r, 0)), turn = 2 * pi * uniform(hash_bits(17, k, r, 1));
        const double c = std::sqrt(z2), s = std::sqrt(1 - z2);
        const Vec3d direction = normal * c + t * (s * std::cos(turn)) + u * (s * std::sin(turn));
        Vec3d d = direction;
        for (int a = 0; a < 3; ++a) d[a] /= index.spacing()[a] / p1.hbar();
        // Start some voxels out along the normal, so that the staircase of the surface does not count as a hit.
        const int plane =
            hits(p1.blocks(), emptiness, middle + normal * 1.5, d, lo, hi, light.steps) ? -1 : plane_of(box, middle, d);
        const double power = share * weight(direction);
        (plane < 0 ? light.back : light.by_plane[size_t(plane)]) += power;
        if (plane >= 0) light.ahead += hemisphere.of_direction(direction) * power;
        const int through = of_sky > 0 ? plane_of(box, middle, -d) : -1;
        if (through < 0) continue;
        const double from_sky = of_sky * sky->radiance(in_world(index, direction))[channel] / sky_mean;
        straight.by_plane[size_t(through)] += from_sky;
        straight.ahead += hemisphere.of_direction(-direction) * from_sky;
    }
    light.match_faces();
    straight.match_faces();
    return {light, straight};
}

}  // namespace

OutflowRays trace_outflow(const P1Operator& p1, const P1Source& source, const std::vector<double>& phi,
                          const std::array<std::vector<float>, 3>* flux, const Sky* sky, int channel,
                          const Hemisphere& hemisphere, int rays)
{
    OutflowRays result;
    if (rays <= 0) return result;
    result.reentry = 0;
    const size_t exposed = p1.exposed().size();
    if (exposed == 0) return result;
    Outflow outflow{p1, source, phi, flux, sky, channel, hemisphere};
    for (int a = 0; a < 3; ++a) {
        outflow.lo[a] = (outflow.box.first[a] >> 3) * 8;
        outflow.hi[a] = (outflow.box.last[a] >> 3) * 8 + 7;
    }
    const size_t samples = std::min(exposed, size_t(rays)), each = std::max<size_t>(1, size_t(rays) / samples);
    std::vector<std::pair<Bundle, Bundle>> sampled(samples);
    tbb::parallel_for(size_t(0), samples,
                      [&](size_t n) { sampled[n] = outflow.rays_from(n * exposed / samples, each); });
    Bundle light, straight;
    for (const auto& [of_light, of_sky] : sampled) {
        light += of_light;
        straight += of_sky;
    }
    result.steps = light.steps;
    result.moved = light.moved();
    result.sky_moved = straight.moved();
    result.moved_ahead = light.moved_ahead(hemisphere);
    result.sky_moved_ahead = straight.moved_ahead(hemisphere);
    if (light.carried() > 0) result.reentry = light.back / light.carried();
    return result;
}

double reentry_share(const P1Operator& p1, const P1Source& source, const std::vector<double>& phi, int rays)
{
    return std::max(0.0, trace_outflow(p1, source, phi, nullptr, nullptr, 0, Hemisphere(Vec3d(0, 1, 0)), rays).reentry);
}

}  // namespace vdbcloud
