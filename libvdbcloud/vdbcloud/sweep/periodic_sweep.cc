#include "vdbcloud/sweep/periodic_planes.h"

#include "vdbcloud/core/error.h"

#include <cmath>

namespace vdbcloud {

using periodic::each;
using plane_kernel::batch;
using plane_kernel::Job;

namespace {

constexpr int slot_stride[3] = {64, 8, 1};

constexpr size_t most_kept = size_t(1) << 28;  // of the pieces of all directions [bytes]

}  // namespace

PeriodicSweep::Impl::Impl(const VoxelIndex& of, const std::vector<SweepFace>& list, int across)
    : index(of), blocks(of.blocks()), rays(blocks), box(blocks), w(across), u(ActiveBox::axes(across)[0]),
      v(ActiveBox::axes(across)[1]), face_count(list.size())
{
    for (const int a : {u, v})
        if (blocks.period()[a] == 0) aside = a;
    tu = blocks.period()[u];
    tv = blocks.period()[v];
    Vec3i first(0, 0, 0), last(-1, -1, -1);
    for (int a = 0; a < 3 && blocks.count() > 0; ++a) {
        first[a] = last[a] = blocks.at(0)[a];
        for (size_t b = 0; b < blocks.count(); ++b) {
            first[a] = std::min(first[a], blocks.at(b)[a]);
            last[a] = std::max(last[a], blocks.at(b)[a]);
        }
    }
    if (aside >= 0) {
        (aside == u ? tu : tv) = last[aside] - first[aside] + 3;
        (aside == u ? first_u : first_v) = first[aside] - 1;
    }
    nu = 8 * tu;
    nv = 8 * tv;
    if (blocks.count() == 0) return;
    first_layer = first[w];
    layers = last[w] - first_layer + 1;
    tiles.assign(size_t(layers) * size_t(tu * tv), -1);
    for (size_t b = 0; b < blocks.count(); ++b) {
        const Vec3i& at = blocks.at(b);
        tiles[size_t(((at[w] - first_layer) * tu + at[u] - first_u) * tv + at[v] - first_v)] = int32_t(b);
    }
    for (int layer = 0; layer < layers; ++layer) {
        const auto begin = tiles.begin() + layer * tu * tv;
        whole.push_back(std::find(begin, begin + tu * tv, -1) == begin + tu * tv);
        has_voids = has_voids || !whole.back();
    }
    large = nu * nv >= 4096;
    faces.resize(size_t(8 * layers));
    for (size_t n = 0; n < list.size(); ++n) {
        const Vec3i voxel = blocks.voxel(list[n].slot);
        faces[size_t(voxel[w] - 8 * first_layer)].push_back({uint32_t(n), voxel, list[n].face});
    }
}

void PeriodicSweep::Impl::start(const SweepSet& with, const SweepFields& of, SweepResult& to, PlaneLight* planes,
                                SweepGround* on_ground)
{
    set = &with;
    fields = &of;
    result = &to;
    with_planes = planes;
    ground.reset();
    if (on_ground) ground.emplace(blocks, *on_ground);
    sums.assign(face_count, {0, 0, 0});
    for (int face = 0; face < 6; ++face) {
        from_medium[size_t(face)].assign(with_planes ? box.cells(face) : 0, 0.0);
        from_sky[size_t(face)] = from_medium[size_t(face)];
    }
    medium_along.fill(std::vector<double>(with_planes ? with.count() : 0, 0.0));
    sky_along = medium_along;
    const size_t size = cell(nu, 0);
    for (int k = 0; k < 2; ++k) {
        sigma[k].assign(size, 0.0f);
        for (int d = 0; d < batch; ++d) {
            radiance[k][d].assign(size, 0.0f);
            source[k][d].assign(size, 0.0f);
        }
    }
    if (known != with.direction) {
        known = with.direction;
        pieces.assign(with.count(), {});
    }
    if (has_voids) exits.assign(blocks.count() * batch * 192, 0.0f);
}

void PeriodicSweep::Impl::sweep(int sign, const std::vector<Way>& ways)
{
    offsets.clear();
    for (const Way& way : ways) offsets.emplace_back(way.step, w, u, v, nu, nv);
    const int first = 8 * first_layer, last = first + 8 * layers - 1;
    const int begin = sign > 0 ? first : last, exit = sign > 0 ? box.last[w] : box.first[w];
    std::vector<float> basis(size_t(set->source_terms) * batch, 0.0f), weight(size_t(set->moment_terms) * batch, 0.0f);
    for (size_t d = 0; d < ways.size(); ++d) {
        const size_t m = ways[d].number;
        for (int k = 0; k < set->source_terms; ++k)
            basis[size_t(k * batch) + d] = set->source_basis[m * size_t(set->source_terms) + size_t(k)];
        for (int k = 0; k < set->moment_terms; ++k)
            weight[size_t(k * batch) + d] =
                set->weight[m] * set->moment_basis[m * size_t(set->moment_terms) + size_t(k)];
    }
    Job job;
    job.directions = int(ways.size());
    job.offsets = offsets.data();
    job.sigma = fields->sigma_t->data();
    job.emission = fields->emission;
    for (const auto& term : *fields->source) job.source.push_back(term.data());
    for (auto& moment : result->moments) job.moments.push_back(moment.data());
    job.basis = basis.data();
    job.weight = weight.data();
    job.rows = nu;
    job.columns = nv;
    job.contiguous = slot_stride[v] == 1;
    enter(begin - sign, ways);
    if (has_voids) each(int(ways.size()), true, [&](int d) { find_pieces(sign, d, ways[size_t(d)]); });
    for (int p = begin; p >= first && p <= last; p += sign) {
        now = 1 - now;
        cross_plane(p, ways, job);
        if (has_voids)
            each(int(ways.size()), true, [&](int d) {
                for (int n = 0; n < tu * tv; ++n) keep_exits(p, n / tv, n % tv, d, ways[size_t(d)]);
                if (!whole[size_t(layer_of(p))]) fill_voids(p, d, ways[size_t(d)]);
            });
        tally(p, sign, ways);
        if (p == exit) leave(p, sign, ways, true);
        leave_aside(p, ways, true);
    }
    leave(exit, sign, ways, false);
    for (int p = box.first[w]; p <= box.last[w]; ++p) leave_aside(p, ways, false);
    if (has_voids) forget(ways);
}

/// The plane before the first: all of it lies outside the blocks.
void PeriodicSweep::Impl::enter(int p, const std::vector<Way>& ways)
{
    std::fill(sigma[now].begin(), sigma[now].end(), 0.0f);
    for (size_t d = 0; d < ways.size(); ++d) {
        std::fill(source[now][d].begin(), source[now][d].end(), 0.0f);
        if (!(upward && ground)) {
            std::fill(radiance[now][d].begin(), radiance[now][d].end(), ways[d].sky);
            continue;
        }
        Vec3d point;
        point[w] = p;
        for (int row = 0; row < nu; ++row)
            for (int column = 0; column < nv; ++column) {
                point[u] = 8 * first_u + row;
                point[v] = 8 * first_v + column;
                radiance[now][d][cell(row, column)] = float(outside(ways[d], point));
            }
        close_rows(radiance[now][d].data(), 0, nu);
    }
}

/// The voxels of existing blocks, and their part of the moments.
void PeriodicSweep::Impl::cross_plane(int p, const std::vector<Way>& ways, Job& job)
{
    const int layer = layer_of(p);
    for (size_t d = 0; d < ways.size(); ++d) {
        job.before[d] = {radiance[1 - now][d].data(), source[1 - now][d].data()};
        job.here[d] = {radiance[now][d].data(), source[now][d].data()};
    }
    job.sigma_before = sigma[1 - now].data();
    job.sigma_here = sigma[now].data();
    each(nu, large, [&](int row) {
        const size_t in_block = size_t((p & 7) * slot_stride[w] + (row & 7) * slot_stride[u]);
        plane_kernel::sweep_row(job, row, &tiles[size_t((layer * tu + (row >> 3)) * tv)], tv, in_block);
    });
}

/// Drops what was found for the directions of a batch where all directions together take too much memory.
void PeriodicSweep::Impl::forget(const std::vector<Way>& ways)
{
    size_t kept = 0;
    for (const Pieces& of : pieces) kept += of.bytes();
    for (size_t d = 0; kept > most_kept && d < ways.size(); ++d) pieces[ways[d].number] = {};
}

/// The directions of one run, all of them with planes across w.
void PeriodicSweep::Impl::run(const std::vector<Way>& all)
{
    std::vector<Way> ways[2];  // down and up along the axis across the planes
    for (const Way& way : all) ways[way.step[w] > 0].push_back(way);
    // Light that ends on a ground comes first. Over a black one the order is that without a ground.
    const bool upper_first = ground && !ground->black() && ground->face() % 2;
    for (const bool upwards : {upper_first, !upper_first}) {
        upward = ground && (ground->face() % 2 == 1) != upwards;
        if (upward && !ground->black()) ground->reflect();
        const std::vector<Way>& of = ways[upwards];
        for (size_t n = 0; n < of.size() && layers > 0; n += batch)
            sweep(upwards ? 1 : -1,
                  {of.begin() + std::ptrdiff_t(n), of.begin() + std::ptrdiff_t(std::min(n + batch, of.size()))});
    }
    if (ground) ground->reflect();
}

PeriodicSweep::PeriodicSweep(const VoxelIndex& index, const std::vector<SweepFace>& faces) : blocks_(index.blocks())
{
    for (int a = 0; a < 3; ++a)
        if (blocks_.period()[a] == 0) impl_[size_t(a)] = std::make_unique<Impl>(index, faces, a);
}
PeriodicSweep::~PeriodicSweep() = default;

/// The axis across the planes for a direction.
int PeriodicSweep::across(const Vec3d& step) const
{
    int w = -1;
    for (int a = 0; a < 3; ++a)
        if (impl_[size_t(a)] && step[a] != 0 && (w < 0 || std::abs(step[a]) > std::abs(step[w]))) w = a;
    if (w < 0) throw InputError("a direction along periodic axes only: expected one that leaves the medium");
    return w;
}

void PeriodicSweep::run(const SweepSet& set, const SweepFields& fields, SweepResult& result, PlaneLight* planes,
                        SweepGround* ground)
{
    std::array<std::vector<Impl::Way>, 3> ways;  // by the axis across the planes
    for (const auto& impl : impl_) {
        if (!impl) continue;
        if (ground && impl->aside >= 0)
            throw InputError("a ground under a medium that repeats along one axis: expected none, or two");
        impl->start(set, fields, result, planes, ground);
    }
    result.moments.resize(size_t(set.moment_terms));
    for (auto& moment : result.moments) moment.assign(blocks_.slots(), 0.0f);
    for (size_t m = 0; m < set.count(); ++m) {
        Impl::Way way{{}, m, set.inflow.empty() ? 0.0f : set.inflow[m], {}};
        const Impl& any = *(impl_[0] ? impl_[0] : impl_[1] ? impl_[1] : impl_[2]);
        for (int a = 0; a < 3; ++a) way.step[a] = set.direction[m][a] / any.index.spacing()[a];
        const size_t w = size_t(across(way.step));
        way.views = impl_[w]->views_of(way.step);
        ways[w].push_back(way);
    }
    for (size_t a = 0; a < 3; ++a)
        if (impl_[a]) impl_[a]->run(ways[a]);
    finish(set, result, planes);
}

void PeriodicSweep::finish(const SweepSet& set, SweepResult& to, PlaneLight* planes) const
{
    each(int(blocks_.count()), blocks_.count() >= 64, [&](int b) {
        for (size_t x = 0; x < 8; ++x) {
            const uint64_t mask = blocks_.mask(size_t(b))[x];
            for (size_t n = 0; ~mask && n < 64; ++n)
                for (auto& moment : to.moments)
                    if (!(mask >> n & 1)) moment[size_t(b) * 512 + x * 64 + n] = 0;
        }
    });
    std::vector<std::array<double, 3>> sums;
    std::array<std::vector<double>, 6> from_medium, from_sky;
    const auto add = [](std::vector<double>& sum, const std::vector<double>& more) {
        sum.resize(more.size(), 0.0);
        for (size_t n = 0; n < more.size(); ++n) sum[n] += more[n];
    };
    for (const auto& impl : impl_) {
        if (!impl) continue;
        sums.resize(impl->face_count, {0, 0, 0});
        for (size_t n = 0; n < sums.size(); ++n)
            for (size_t k = 0; k < 3; ++k) sums[n][k] += impl->sums[n][k];
        for (size_t face = 0; face < 6; ++face) {
            add(from_medium[face], impl->from_medium[face]);
            add(from_sky[face], impl->from_sky[face]);
        }
    }
    to.tally.resize(sums.size());
    for (size_t n = 0; n < sums.size(); ++n) to.tally[n] = {float(sums[n][0]), float(sums[n][1]), float(sums[n][2])};
    if (!planes) return;
    set_half_ranges(set, *planes);
    for (const auto& impl : impl_)
        for (size_t face = 0; impl && face < 6; ++face) {
            add(planes->medium_along[face], impl->medium_along[face]);
            add(planes->sky_along[face], impl->sky_along[face]);
        }
    for (size_t face = 0; face < 6; ++face) {
        planes->from_medium[face].assign(from_medium[face].begin(), from_medium[face].end());
        planes->from_sky[face].assign(from_sky[face].begin(), from_sky[face].end());
    }
}

size_t PeriodicSweep::bytes() const
{
    size_t total = 0;
    for (const auto& impl : impl_) {
        if (!impl) continue;
        for (const auto& of : impl->pieces) total += of.bytes();
        total += 4 * impl->exits.size() + 4 * impl->cell(impl->nu, 0) * (2 * (2 * batch + 1)) + impl->face_count * 64;
    }
    return total;
}

}  // namespace vdbcloud
