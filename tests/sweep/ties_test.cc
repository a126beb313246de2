// Directions that cross voxels equally fast along two or three axes: no result may follow the order of the axes.
#include "support/voxel_field.h"
#include "swept_medium.h"
#include "vdbcloud/sweep/light_lattice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace vdbcloud {
namespace {

/// The six orders of the axes: axis k of a permuted body is axis order[k] of the first body.
constexpr int orders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};

template<typename T>
T permuted(const T& v, const int* order)
{
    return T(v[order[0]], v[order[1]], v[order[2]]);
}

/// The voxel of the first body.
Vec3i first(const Vec3i& voxel, const int* order)
{
    Vec3i p;
    for (int k = 0; k < 3; ++k) p[order[k]] = voxel[k];
    return p;
}

/// Directions along diagonals of two and of three axes. The components of the first are those of a quadrature: their
/// ratio is 1 but for rounding.
const Vec3d tied[] = {Vec3d(0.69113739634803428, 0.21132486540518713, 0.69113739634803428),
                      Vec3d(1, 0.3, 1),
                      Vec3d(1, 1, 0.3),
                      Vec3d(-0.3, 1, 1),
                      Vec3d(1, -1, 0.6),
                      Vec3d(-1, 1, 1),
                      Vec3d(1, 1, -1),
                      Vec3d(-1, -0.7, 1)};

constexpr int side = 20;

/// A box whose faces lie within and between blocks, and clumps with missing blocks.
const std::function<double(const Vec3i&)> bodies[] = {
    [](const Vec3i& p) {
        const bool inside = std::min({p[0], p[1], p[2]}) >= 7 && p[0] < 13 && p[1] < 14 && p[2] < 13;
        return inside ? 1.0 + p[0] % 2 : 0.0;
    },
    [](const Vec3i& p) { return test::clumps(p, 11, 0.4); }};

/// Voxel, face (6: the centre) and direction in the axes of the first body.
using Place = std::array<int, 5>;
using Sweep = std::function<void(const test::SweptMedium&, const SweepSet&, SweepResult&)>;

std::map<Place, double> swept(const std::function<double(const Vec3i&)>& density, const int* order, const Sweep& sweep)
{
    test::SweptMedium m(
        test::voxel_field(Vec3i(side), Vec3d(1), [&](const Vec3i& q) { return density(first(q, order)); }));
    m.add_source([&](const Vec3i& q) { return 1 + 0.5 * std::sin(first(q, order).dot(Vec3i(3, 5, 9))); });
    const Blocks& blocks = m.index.blocks();
    std::map<Place, double> seen;
    for (int d = 0; d < int(std::size(tied)); ++d) {
        SweepSet set = test::one_by_one({permuted(tied[d].unit(), order)});
        set.inflow = {0.7f};
        SweepResult result;
        sweep(m, set, result);
        for (size_t slot = 0; slot < blocks.count() * 512; ++slot) {
            if (!blocks.active(slot)) continue;
            const Vec3i p = first(blocks.voxel(slot), order);
            seen[{p[0], p[1], p[2], 6, d}] = result.moments[0][slot];
        }
        for (size_t f = 0; f < m.faces.size(); ++f) {
            const Vec3i p = first(blocks.voxel(m.faces[f].slot), order);
            seen[{p[0], p[1], p[2], 2 * order[m.faces[f].face / 2] + m.faces[f].face % 2, d}] = result.tally[f].fluence;
        }
    }
    return seen;
}

TEST(Ties, SweepsAlongDiagonalsArePermutedWithTheAxes)
{
    const std::map<std::string, Sweep> sweeps{
        {"fast", [](const auto& m, const auto& set,
                    auto& result) { TransportSweep(m.index, m.faces).run(set, m.fields(), result); }},
        {"reference", [](const auto& m, const auto& set, auto& result) {
             reference_sweep(m.index, m.faces, set, m.fields(), result);
         }}};
    for (const auto& density : bodies)
        for (const auto& [name, sweep] : sweeps) {
            const auto expected = swept(density, orders[0], sweep);
            for (const auto& order : orders) {
                double worst = 0, largest = 0;
                Place where{};
                for (const auto& [place, value] : swept(density, order, sweep)) {
                    const double error = std::abs(value - expected.at(place));
                    if (error > worst) worst = error, where = place;
                    largest = std::max(largest, value);
                }
                EXPECT_GT(largest, 1);
                // Single precision over some 20 voxels.
                EXPECT_LT(worst, 3e-6 * largest)
                    << name << ' ' << order[0] << order[1] << order[2] << " at " << where[0] << ',' << where[1] << ','
                    << where[2] << " face " << where[3] << " direction " << tied[where[4]];
            }
        }
}

/// Depths at the voxels of the first body, of rays so few that most targets lie between rays.
std::vector<double> lattice(const std::function<double(const Vec3i&)>& density, const int* order, const Vec3d& to_light,
                            const LatticeOptions& of_first)
{
    const BrickMap bricks(
        *test::voxel_field(Vec3i(side), Vec3d(1), [&](const Vec3i& q) { return density(first(q, order)); }));
    LatticeOptions options = of_first;
    options.offset = permuted(of_first.offset, order);
    std::vector<Vec3i> blocks;
    for (int b = 0; b < 27; ++b) blocks.emplace_back(b / 9, b / 3 % 3, b % 3);
    const auto depth = lattice_depths(bricks, permuted(to_light.unit(), order), blocks, options);
    std::vector<double> seen(24 * 24 * 24);
    for (size_t b = 0; b < blocks.size(); ++b)
        for (int k = 0; k < 512; ++k) {
            const Vec3i p = first(blocks[b] * 8 + Vec3i(k / 64, k / 8 % 8, k % 8), order);
            seen[size_t((p[0] * 24 + p[1]) * 24 + p[2])] = depth[b * 512 + size_t(k)];
        }
    return seen;
}

TEST(Ties, LatticeDepthsAlongDiagonalsArePermutedWithTheAxes)
{
    for (const auto& density : bodies)
        for (const Vec3d& to_light : tied)
            for (const LatticeOptions& options :
                 {LatticeOptions{1, Vec3d(0, -0.5, 0), 1, nullptr}, LatticeOptions{3, Vec3d(0.5, 0.2, 0), 1, nullptr},
                  LatticeOptions{1, Vec3d(0), 2, nullptr}}) {
                const auto expected = lattice(density, orders[0], to_light, options);
                const double deepest = *std::max_element(expected.begin(), expected.end());
                EXPECT_GT(deepest, 1);
                for (const auto& order : orders) {
                    const auto seen = lattice(density, order, to_light, options);
                    double worst = 0;
                    for (size_t n = 0; n < seen.size(); ++n) worst = std::max(worst, std::abs(seen[n] - expected[n]));
                    EXPECT_LT(worst, 1e-6 * deepest)
                        << order[0] << order[1] << order[2] << ' ' << to_light << ' ' << options.rays_per_voxel;
                }
            }
}

}  // namespace
}  // namespace vdbcloud
