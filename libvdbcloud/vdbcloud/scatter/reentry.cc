#include "vdbcloud/scatter/multiple_scattering.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/random.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <unordered_set>
#include <utility>

namespace vdbcloud {

namespace {

/// Where blocks are, so that a ray crosses emptiness in cells as large as it: of 8, 128 or 2048 voxels.
class Emptiness {
public:
    explicit Emptiness(const Blocks& blocks) : blocks_(blocks), periodic_(blocks.period() != Vec3i(0, 0, 0))
    {
        for (size_t b = 0; b < blocks.count(); ++b) {
            const Vec3i voxel = blocks.at(b) * Blocks::edge;
            tiles_.insert(key(voxel, tile));
            supers_.insert(key(voxel, super));
        }
    }
    /// log2 of the edge of the empty cell about a voxel, 0 if the voxel's block exists.
    int bits(const Vec3i& voxel, size_t slot) const
    {
        if (slot / Blocks::size < blocks_.count()) return 0;
        if (periodic_ || tiles_.count(key(voxel, tile))) return block;
        return supers_.count(key(voxel, super)) ? tile : super;
    }

private:
    static constexpr int block = 3, tile = 7, super = 11;
    /// Equal for voxels 2^28 apart, which makes some steps shorter.
    static uint64_t key(const Vec3i& voxel, int bits)
    {
        const auto part = [&](int a) { return uint64_t(uint32_t(voxel[a] >> bits)) & 0x1fffff; };
        return part(0) << 42 | part(1) << 21 | part(2);
    }
    const Blocks& blocks_;
    bool periodic_;
    std::unordered_set<uint64_t> tiles_, supers_;
};

/// True if a ray (voxel coordinates) meets an active voxel before it leaves the blocks' bounds. Counts its steps.
bool hits(const Blocks& blocks, const Emptiness& emptiness, Vec3d p, const Vec3d& d, const Vec3i& lo, const Vec3i& hi,
          size_t& steps)
{
    for (int step = 0; step < 100000; ++step, ++steps) {
        const Vec3i voxel(int(std::floor(p[0] + 0.5)), int(std::floor(p[1] + 0.5)), int(std::floor(p[2] + 0.5)));
        for (int a = 0; a < 3; ++a)
            if (blocks.period()[a] == 0 && ((voxel[a] < lo[a] && d[a] <= 0) || (voxel[a] > hi[a] && d[a] >= 0)))
                return false;
        const size_t slot = blocks.slot(voxel);
        if (blocks.active(slot)) return true;
        const int bits = emptiness.bits(voxel, slot);
        double t = std::numeric_limits<double>::infinity();
        for (int a = 0; a < 3; ++a) {
            if (d[a] == 0) continue;
            const double low = double(int64_t(voxel[a] >> bits) << bits) - 0.5;
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
        for (size_t f = 0; f < 6; ++f) {
            by_plane[f] += other.by_plane[f];
            by_face[f] += other.by_face[f];
        }
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
    normal.normalize();
    const Vec3d t = (std::abs(normal[0]) < 0.5 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0)).cross(normal).unit(),
                u = normal.cross(t);
    const Vec3i at = p1.blocks().voxel(voxel.slot);
    const Vec3d centre(at[0], at[1], at[2]);
    const RadianceWeight weight(phi[voxel.slot], flux_at(voxel.slot), normal);
    const double share = light.through_faces() / double(each), of_sky = straight.through_faces() / double(each);
    const double sky_mean = of_sky > 0 ? sky->mean_inflow(in_world(index, normal))[channel] : 0;
    for (size_t r = 0; r < each; ++r) {
        const double z2 = uniform(hash_bits(17, k, r, 0)), turn = 2 * pi * uniform(hash_bits(17, k, r, 1));
        const double c = std::sqrt(z2), s = std::sqrt(1 - z2);
        const Vec3d direction = normal * c + t * (s * std::cos(turn)) + u * (s * std::sin(turn));
        Vec3d d = direction;
        for (int a = 0; a < 3; ++a) d[a] /= index.spacing()[a] / p1.hbar();
        // Start two voxels out along the normal, so that the staircase of the surface does not count as a hit.
        const int plane =
            hits(p1.blocks(), emptiness, centre + normal * 2.0, d, lo, hi, light.steps) ? -1 : plane_of(box, centre, d);
        (plane < 0 ? light.back : light.by_plane[size_t(plane)]) += share * weight(direction);
        const int through = of_sky > 0 ? plane_of(box, centre, -d) : -1;
        if (through >= 0)
            straight.by_plane[size_t(through)] +=
                of_sky * sky->radiance(in_world(index, direction))[channel] / sky_mean;
    }
    light.match_faces();
    straight.match_faces();
    return {light, straight};
}

}  // namespace

OutflowRays trace_outflow(const P1Operator& p1, const P1Source& source, const std::vector<double>& phi,
                          const std::array<std::vector<float>, 3>* flux, const Sky* sky, int channel, int rays)
{
    OutflowRays result;
    if (rays <= 0) return result;
    result.reentry = 0;
    const size_t exposed = p1.exposed().size();
    if (exposed == 0) return result;
    Outflow outflow{p1, source, phi, flux, sky, channel};
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
    if (light.carried() > 0) result.reentry = light.back / light.carried();
    return result;
}

double reentry_share(const P1Operator& p1, const P1Source& source, const std::vector<double>& phi, int rays)
{
    return std::max(0.0, trace_outflow(p1, source, phi, nullptr, nullptr, 0, rays).reentry);
}

}  // namespace vdbcloud
