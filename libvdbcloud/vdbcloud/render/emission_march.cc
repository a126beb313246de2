#include "vdbcloud/render/emission_march.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/render/cell_rule.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbcloud {

namespace {

constexpr double far = std::numeric_limits<double>::infinity();

/// Cells of an emitting volume that are gathered at a time: a ray that ends early leaves few of them unused.
constexpr size_t batch = 32;

/// Gauss's rules on [0, 1].
struct Node {
    double s, weight;
};
constexpr Node three[] = {{0.1127016653792583, 5 / 18.0}, {0.5, 8 / 18.0}, {0.8872983346207417, 5 / 18.0}};
constexpr Node four[] = {{0.06943184420297371, 0.17392742256872692},
                         {0.33000947820757187, 0.32607257743127307},
                         {0.6699905217924281, 0.32607257743127307},
                         {0.9305681557970263, 0.17392742256872692}};

/// Largest optical depth of a part for the rule of 3 and for the rule of 4 points.
constexpr double thin = 0.05, thick = 0.5;

/// Transmittance beyond which nothing is visible.
const double dark = std::exp(-opaque);

double largest(const Vec3d& v) { return std::max({v[0], v[1], v[2]}); }
double least_of(const Vec3d& v) { return std::min({v[0], v[1], v[2]}); }

}  // namespace

EmissionMarch::EmissionMarch(const PathScene& scene) : scene_(scene), emitting_(scene.emission.volumes().size())
{
    for (const PreparedVolume& volume : scene.media.volumes) media_.push_back({volume.sigma_t, {}, 0});
}

Vec3d EmissionMarch::exact(const PathMedia& media) { return march(media, dark, 0); }

Vec3d EmissionMarch::sampled(const PathMedia& media, double dim, PathRandom& random)
{
    return march(media, dim * (1 - random.next()), dim);
}

Vec3d EmissionMarch::unattenuated(const PathMedia& media, double end)
{
    Vec3d all(0);
    double to = 0;
    do {
        const double from = to;
        to = gather_emission(media, from, end);
        for (const auto& pieces : emitting_)
            for (const Emitting& piece : pieces) {
                if (piece.t0 >= to) break;
                // A piece that crosses the batch's end comes again, from there on, with the next batch.
                const double length = piece.t1 - piece.t0, s = std::min(1.0, (to - piece.t0) / length);
                for (int c = 0; c < 3; ++c) all[c] += length * piece.channels[c].integral(s);
            }
    } while (to < end);
    return all;
}

/// `least`: transmittance of the brightest channel at which the march ends. Below `roulette` the part of all marches
/// that goes on is the transmittance over `roulette`, and light is brighter by the inverse of that part.
Vec3d EmissionMarch::march(const PathMedia& media, double least, double roulette)
{
    const double end = scene_.media.repeats ? media.end() : media.stop(), deepest = -std::log(least);
    Vec3d all(0), tau(0);
    double behind = 0;
    for (double from = 0;;) {
        const double to = gather_emission(media, from, end);
        from = far;
        for (const auto& pieces : emitting_)
            if (!pieces.empty()) from = std::min(from, pieces.front().t0);
        if (!(from < to)) return all;
        tau += media.optical_depth(behind, from);
        if (least_of(tau) > deepest) return all;
        gather_media(media, from, to);

        for (const auto& pieces : emitting_) {
            for (Attenuating& medium : media_) medium.at = 0;
            Vec3d before = tau;
            double t = from;
            for (size_t k = 0; k < pieces.size() && t < to && least_of(before) <= deepest;) {
                const Emitting& piece = pieces[k];
                if (piece.t1 <= t) {
                    ++k;
                    continue;
                }
                const double next = next_border(t, std::min(t < piece.t0 ? piece.t0 : piece.t1, to));
                const Vec3d step = depth(t, next);
                if (t >= piece.t0) {
                    const double brightest = std::exp(-least_of(before));
                    all += std::max(1.0, roulette / brightest) * quadrature(piece, t, next, before, step);
                }
                before += step;
                t = next;
            }
        }
        behind = from;
        from = to;
    }
}

/// The next pieces of all emitting volumes from `from` on. Returns where they end: up to there they are complete.
double EmissionMarch::gather_emission(const PathMedia& media, double from, double end)
{
    double to = end;
    for (size_t n = 0; n < emitting_.size(); ++n) {
        const size_t v = scene_.emission.volumes()[n];
        const PreparedVolume& volume = scene_.media.volumes[v];
        const IndexRay& index = media.index_ray(v);
        auto& pieces = emitting_[n];
        pieces.clear();
        march_cells(volume.density, index, from, to, [&](double t0, double t1, const float*, const Vec3i& cell) {
            const Vec3i at = volume.emission->period().home(cell);
            const float* corners = volume.emission->find(Vec3i(at[0] >> 3, at[1] >> 3, at[2] >> 3));
            if (!corners) return true;
            corners += (at[0] & 7) * BrickMap::sx + (at[1] & 7) * BrickMap::sy + (at[2] & 7);
            const Vec3d p = index.at(t0) - Vec3d(cell[0], cell[1], cell[2]), d = (t1 - t0) * index.direction;
            pieces.push_back(
                {t0, t1, {along(corners, p, d), along(corners + 729, p, d), along(corners + 2 * 729, p, d)}});
            return pieces.size() < batch;
        });
        if (pieces.size() == batch) to = std::min(to, pieces.back().t1);
    }
    return to;
}

void EmissionMarch::gather_media(const PathMedia& media, double from, double to)
{
    double last = from;
    for (const auto& pieces : emitting_)
        if (!pieces.empty()) last = std::max(last, pieces.back().t1);
    for (size_t v = 0; v < media_.size(); ++v) {
        auto& pieces = media_[v].pieces;
        pieces.clear();
        if (media_[v].sigma_t == Vec3d(0.0)) continue;
        const IndexRay& index = media.index_ray(v);
        march_cells(scene_.media.volumes[v].density, index, from, std::min(to, last),
                    [&](double t0, double t1, const float* corners, const Vec3i& cell) {
                        const Vec3d p = index.at(t0) - Vec3d(cell[0], cell[1], cell[2]);
                        pieces.push_back({t0, t1, along(corners, p, (t1 - t0) * index.direction)});
                        return true;
                    });
    }
}

/// The first border of the media's cells on (from, to], or `to`. Forgets the pieces that end at `from` or before.
double EmissionMarch::next_border(double from, double to)
{
    for (Attenuating& medium : media_) {
        while (medium.at < medium.pieces.size() && medium.pieces[medium.at].t1 <= from) ++medium.at;
        if (medium.at == medium.pieces.size()) continue;
        const Piece& piece = medium.pieces[medium.at];
        to = std::min(to, piece.t0 > from ? piece.t0 : piece.t1);
    }
    return to;
}

/// Optical depth of from..to, which crosses no border of a cell.
Vec3d EmissionMarch::depth(double from, double to) const
{
    Vec3d tau(0);
    for (const Attenuating& medium : media_) {
        if (medium.at == medium.pieces.size()) continue;
        const Piece& piece = medium.pieces[medium.at];
        if (piece.t0 > from) continue;
        const double length = piece.t1 - piece.t0, whole = piece.density.integral((to - piece.t0) / length);
        tau += medium.sigma_t * (length * (whole - piece.density.integral((from - piece.t0) / length)));
    }
    return tau;
}

/// Emission of from..to times transmittance. `before`: optical depth up to `from`; `step`: of from..to.
Vec3d EmissionMarch::quadrature(const Emitting& piece, double from, double to, const Vec3d& before,
                                const Vec3d& step) const
{
    const double most = largest(step), length = piece.t1 - piece.t0;
    const int parts = std::max(1, int(std::ceil(most / thick)));
    const bool is_thin = most < thin;
    const Node* const nodes = is_thin ? three : four;
    const double part = (to - from) / parts;
    Vec3d sum(0);
    for (int n = 0; n < parts; ++n)
        for (int k = 0; k < (is_thin ? 3 : 4); ++k) {
            const double t = from + part * (n + nodes[k].s), s = (t - piece.t0) / length;
            const Vec3d emission(piece.channels[0].at(s), piece.channels[1].at(s), piece.channels[2].at(s));
            const Vec3d transmittance = attenuation(before + depth(from, t));
            sum += nodes[k].weight * part * emission * transmittance;
            if (largest(transmittance) < dark) return sum;
        }
    return sum;
}

}  // namespace vdbcloud
