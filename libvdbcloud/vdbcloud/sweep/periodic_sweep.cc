#include "vdbcloud/sweep/periodic_planes.h"

#include "vdbcloud/core/error.h"

namespace vdbcloud {

using periodic::each;
using plane_kernel::batch;
using plane_kernel::Job;

namespace {

constexpr int slot_stride[3] = {64, 8, 1};

constexpr size_t most_kept = size_t(1) << 28;  // of the pieces of all directions [bytes]

}  // namespace

bool PeriodicSweep::takes(const Vec3i& period) { return (period[0] > 0) + (period[1] > 0) + (period[2] > 0) == 2; }

PeriodicSweep::Impl::Impl(const VoxelIndex& of, const std::vector<SweepFace>& list)
    : index(of), blocks(of.blocks()), rays(blocks), box(blocks), face_count(list.size())
{
    w = blocks.period()[0] == 0 ? 0 : blocks.period()[1] == 0 ? 1 : 2;
    u = ActiveBox::axes(w)[0];
    v = ActiveBox::axes(w)[1];
    tu = blocks.period()[u];
    tv = blocks.period()[v];
    nu = 8 * tu;
    nv = 8 * tv;
    if (blocks.count() == 0) return;
    int last = blocks.at(0)[w];
    first_layer = last;
    for (size_t b = 0; b < blocks.count(); ++b) {
        first_layer = std::min(first_layer, blocks.at(b)[w]);
        last = std::max(last, blocks.at(b)[w]);
    }
    layers = last - first_layer + 1;
    tiles.assign(size_t(layers) * size_t(tu * tv), -1);
    for (size_t b = 0; b < blocks.count(); ++b) {
        const Vec3i& at = blocks.at(b);
        tiles[size_t(((at[w] - first_layer) * tu + at[u]) * tv + at[v])] = int32_t(b);
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
    to.moments.resize(size_t(with.moment_terms));
    for (auto& moment : to.moments) moment.assign(blocks.slots(), 0.0f);
    sums.assign(face_count, {0, 0, 0});
    for (int side = 0; side < 2; ++side) {
        from_medium[side].assign(with_planes ? box.cells(2 * w + side) : 0, 0.0);
        from_sky[side] = from_medium[side];
    }
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
    }
    leave(exit, sign, ways, false);
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
                point[u] = row;
                point[v] = column;
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

void PeriodicSweep::Impl::finish(const SweepSet& with, SweepResult& to, PlaneLight* planes)
{
    each(int(blocks.count()), large, [&](int b) {
        for (size_t x = 0; x < 8; ++x) {
            const uint64_t mask = blocks.mask(size_t(b))[x];
            for (size_t n = 0; ~mask && n < 64; ++n)
                for (auto& moment : to.moments)
                    if (!(mask >> n & 1)) moment[size_t(b) * 512 + x * 64 + n] = 0;
        }
    });
    to.tally.resize(face_count);
    for (size_t n = 0; n < face_count; ++n) to.tally[n] = {float(sums[n][0]), float(sums[n][1]), float(sums[n][2])};
    if (ground) ground->reflect();
    if (!planes) return;
    set_half_ranges(with, *planes);
    for (size_t face = 0; face < 6; ++face) {
        planes->from_medium[face].clear();
        planes->from_sky[face].clear();
    }
    for (size_t side = 0; side < 2; ++side) {
        const size_t face = size_t(2 * w) + side;
        planes->from_medium[face].assign(from_medium[side].begin(), from_medium[side].end());
        planes->from_sky[face].assign(from_sky[side].begin(), from_sky[side].end());
    }
}

PeriodicSweep::PeriodicSweep(const VoxelIndex& index, const std::vector<SweepFace>& faces)
    : impl_(std::make_unique<Impl>(index, faces))
{
}
PeriodicSweep::~PeriodicSweep() = default;

void PeriodicSweep::run(const SweepSet& set, const SweepFields& fields, SweepResult& result, PlaneLight* planes,
                        SweepGround* ground)
{
    Impl& my = *impl_;
    my.start(set, fields, result, planes, ground);
    std::vector<Impl::Way> ways[2];  // down and up along the axis across the planes
    for (size_t m = 0; m < set.count(); ++m) {
        Impl::Way way{{}, m, set.inflow.empty() ? 0.0f : set.inflow[m], {}};
        for (int a = 0; a < 3; ++a) way.step[a] = set.direction[m][a] / my.index.spacing()[a];
        if (way.step[my.w] == 0)
            throw InputError("a direction along periodic axes only: expected one that leaves the medium");
        way.views = my.views_of(way.step);
        ways[way.step[my.w] > 0].push_back(way);
    }
    // Light that ends on a ground comes first. Over a black one the order is that without a ground.
    const bool upper_first = my.ground && !my.ground->black() && my.ground->face() % 2;
    for (const bool upwards : {upper_first, !upper_first}) {
        my.upward = my.ground && (my.ground->face() % 2 == 1) != upwards;
        if (my.upward && !my.ground->black()) my.ground->reflect();
        const std::vector<Impl::Way>& all = ways[upwards];
        for (size_t n = 0; n < all.size() && my.layers > 0; n += batch)
            my.sweep(upwards ? 1 : -1,
                     {all.begin() + std::ptrdiff_t(n), all.begin() + std::ptrdiff_t(std::min(n + batch, all.size()))});
    }
    my.finish(set, result, planes);
}

size_t PeriodicSweep::bytes() const
{
    size_t in_pieces = 0;
    for (const auto& of : impl_->pieces) in_pieces += of.bytes();
    return in_pieces + 4 * impl_->exits.size() + 4 * impl_->cell(impl_->nu, 0) * (2 * (2 * batch + 1)) +
           impl_->face_count * 64;
}

}  // namespace vdbcloud
