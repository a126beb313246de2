// Voxels of a block as receivers of emission.
#include "vdbcloud/scatter/emission_receivers.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/optics/spherical_harmonics.h"
#include "vdbcloud/scatter/p1_problem.h"

namespace vdbcloud {

using namespace emission;

/// The voxels of a block as receivers.
struct EmissionGather::Voxels {
    Voxels(const EmissionGather& of, size_t block, const BlockMask& wanted, std::vector<double>& to)
        : my(of), b(block), mask(wanted), out(to), first(8 * of.index_.blocks().at(block))
    {
    }

    bool any(const Tile& tile) const
    {
        for (int x = tile.at[0]; x < tile.at[0] + tile.n[0]; ++x)
            for (int y = tile.at[1]; y < tile.at[1] + tile.n[1]; ++y)
                if (mask[size_t(x)] >> (8 * y + tile.at[2]) & ((uint64_t(1) << tile.n[2]) - 1)) return true;
        return false;
    }

    bool take(const EmissionNode& node, const Tile& tile)
    {
        const Look look = my.look(node, tile, scale);
        if (look.share < least_share) return true;
        if (my.coarse(node, tile, look)) return false;
        const bool by_parts = look.parts;
        const TileDepths depths(tile.n, stride_of(node, look.share, change), [&](const Vec3i& p) {
            if (tile.single() && !by_parts) return look.tau;
            const Vec3d at = tile.low + as_double(p);
            return my.depth_(my.index_.world(at), my.way_out(node, at, by_parts), deepest);
        });
        for (int i = 0; i < tile.n[0]; ++i)
            for (int j = 0; j < tile.n[1]; ++j)
                for (int k = 0; k < tile.n[2]; ++k) {
                    const Vec3i p(i, j, k);
                    if (mask[size_t(tile.at[0] + i)] >> (8 * (tile.at[1] + j) + tile.at[2] + k) & 1)
                        add(node, tile, p, depths(p), by_parts);
                }
        return true;
    }

    void add(const EmissionNode& node, const Tile& tile, const Vec3i& p, double tau, bool by_parts)
    {
        const Vec3d& h = my.index_.spacing();
        const View view(node, my.metric(tile.low + as_double(p)), h, tau, by_parts ? &my.parts_ : nullptr);
        const size_t slot = slot_of(tile.at + p);
        double width = 0;
        for (int a = 0; a < 3; ++a) width += std::pow(view.towards[a] * h[a], 2);
        const double thickness = my.sigma_[b * Blocks::size + slot] * std::sqrt(width);
        const double mean = sinhc(thickness / 2), chord = 1 / (1 + thickness * thickness / 12);
        const double swept = chord + diffusive(thickness) * (mean - chord);
        double y[64];
        evaluate_harmonics(my.degree_, -view.towards, y);
        for (size_t c = 0; c < size_t(my.channels_); ++c) {
            const double fluence = view.of_channel(node, c);
            double* to = out.data() + (slot * size_t(my.channels_) + c) * my.values();
            for (int k = 0; k < my.terms_; ++k) to[k] += fluence * swept * y[k];
            to[my.terms_] += fluence * mean;
        }
    }

    /// The 3^3 voxels about a receiver are added once, whichever of them comes first.
    void near(const EmissionNode&, const Tile& tile)
    {
        const size_t slot = slot_of(tile.at);
        if (done[slot / 64] >> (slot % 64) & 1) return;
        done[slot / 64] |= uint64_t(1) << (slot % 64);
        if (sigma.empty()) load();
        NearEmission::Field about, extinction;
        size_t n = 0;
        for (int x = 0; x < 5; ++x)
            for (int y = 0; y < 5; ++y)
                for (int z = 0; z < 5; ++z, ++n) extinction[n] = sigma[apron(tile.at + Vec3i(x, y, z))];
        for (size_t c = 0; c < size_t(my.channels_); ++c) {
            about.fill(0);
            for (int x = 1; x < 4; ++x)
                for (int y = 1; y < 4; ++y)
                    for (int z = 1; z < 4; ++z)
                        about[size_t((x * 5 + y) * 5 + z)] = emission[c][apron(tile.at + Vec3i(x, y, z))];
            double* to = out.data() + (slot * size_t(my.channels_) + c) * my.values();
            double moments[64] = {};
            my.near_.add(about, extinction, moments);
            for (int k = 0; k < my.terms_; ++k) to[k] += moments[k];
            to[my.terms_] += std::sqrt(4 * pi) * moments[0];
        }
    }

    void load()
    {
        sigma.assign(1728, 0);
        for (size_t c = 0; c < size_t(my.channels_); ++c) emission[c].assign(1728, 0);
        const Blocks& blocks = my.index_.blocks();
        for (int x = 0; x < 12; ++x)
            for (int y = 0; y < 12; ++y)
                for (int z = 0; z < 12; ++z) {
                    const size_t slot = blocks.slot(first + Vec3i(x - 2, y - 2, z - 2)), to = apron(Vec3i(x, y, z));
                    if (!blocks.active(slot)) continue;
                    sigma[to] = my.sigma_[slot];
                    for (size_t c = 0; c < size_t(my.channels_); ++c) emission[c][to] = (*my.emission_[c])[slot];
                }
    }

    static size_t slot_of(const Vec3i& at) { return size_t(at[0] * 64 + at[1] * 8 + at[2]); }
    static size_t apron(const Vec3i& at) { return size_t((at[0] * 12 + at[1]) * 12 + at[2]); }

    const EmissionGather& my;
    const size_t b;
    const BlockMask& mask;
    std::vector<double>& out;
    const Vec3i first;
    double scale = 0;          // least fluence of the receivers, roughly
    double change = 0;         // of extinction in the block, times a voxel's edge
    std::vector<float> sigma;  // of the block and two voxels about it; empty until needed
    std::array<std::vector<float>, 3> emission;
    std::array<uint64_t, 8> done{};
};

void EmissionGather::block(size_t block, const BlockMask& wanted, std::vector<double>& out) const
{
    out.assign(size_t(Blocks::size) * size_t(channels_) * values(), 0.0);
    if (tree_.nodes().empty()) return;
    Voxels voxels(*this, block, wanted, out);
    const Vec3d low = as_double(voxels.first);
    const Tile tile{Vec3i(0, 0, 0), Vec3i(8, 8, 8), low, low + Vec3d(7.0)};
    if (!voxels.any(tile)) return;
    voxels.scale = least_fluence(tile);
    const auto [least, most] = std::minmax_element(sigma_.begin() + ptrdiff_t(block * Blocks::size),
                                                   sigma_.begin() + ptrdiff_t((block + 1) * Blocks::size));
    voxels.change = (*most - *least) * std::cbrt(index_.spacing()[0] * index_.spacing()[1] * index_.spacing()[2]);
    descend(tile, {0}, voxels);
}

}  // namespace vdbcloud
