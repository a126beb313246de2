// Sweeps through voxels: the fast one against its definition, and that one against what can be integrated by hand.
#include "vdbcloud/sweep/transport_sweep.h"

#include "support/voxel_field.h"
#include "swept_medium.h"
#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/random.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace vdbcloud {
namespace {

using Medium = test::SweptMedium;
using test::set_of;

constexpr double missing = 0.6;  // share of blocks

double worst_difference(const SweepResult& a, const SweepResult& b, double& largest)
{
    double worst = 0;
    largest = 0;
    for (size_t k = 0; k < a.moments.size(); ++k)
        for (size_t n = 0; n < a.moments[k].size(); ++n) {
            worst = std::max(worst, double(std::abs(a.moments[k][n] - b.moments[k][n])));
            largest = std::max(largest, double(std::abs(b.moments[k][n])));
        }
    for (size_t f = 0; f < a.tally.size(); ++f) {
        worst = std::max(worst, double(std::abs(a.tally[f].current - b.tally[f].current)));
        worst = std::max(worst, double(std::abs(a.tally[f].fluence - b.tally[f].fluence)));
        worst = std::max(worst, double(std::abs(a.tally[f].second - b.tally[f].second)));
    }
    return worst;
}

TEST(TransportSweep, EqualsTheReferenceInAnyDensityForAnyThreadCount)
{
    for (const Vec3d& h : {Vec3d(1.0), Vec3d(0.5, 1.0, 1.7)}) {
        Medium m(test::voxel_field(Vec3i(44, 39, 41), h, [](const Vec3i& p) { return test::clumps(p, 11, missing); }));
        m.add_source([](const Vec3i& p) { return 1 + 0.5 * std::sin(0.3 * p.x() + 0.2 * p.y() - 0.4 * p.z()); });
        for (int k = 1; k < 4; ++k)
            m.add_source([k](const Vec3i& p) {
                return 0.2 * uniform(hash_bits(k, uint64_t(p.x()), uint64_t(p.y()), uint64_t(p.z())));
            });
        for (const auto& [kind, count] : {std::pair(OrdinateKind::Product, 64), {OrdinateKind::LevelSymmetric, 24}}) {
            const SweepSet set = set_of(ordinates(kind, count, 1), 1, 2, 0.3);
            SweepResult slow, fast, again;
            reference_sweep(m.index, m.faces, set, m.fields(), slow);
            TransportSweep sweep(m.index, m.faces);
            sweep.run(set, m.fields(), fast);
            double largest;
            const double worst = worst_difference(fast, slow, largest);
            EXPECT_GT(largest, 1);
            EXPECT_LT(worst, 1e-5 * largest);  // single precision over some 50 voxels
            const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
            again.moments.assign(9, std::vector<float>(m.index.blocks().slots(), 7.0f));
            sweep.run(set, m.fields(), again);  // over what was there, and from what it remembers of the sky
            EXPECT_TRUE(fast.moments == again.moments);
            for (size_t f = 0; f < fast.tally.size(); ++f) ASSERT_EQ(fast.tally[f].current, again.tally[f].current);
        }
    }
}

TEST(TransportSweep, EqualsTheReferenceInAMediumOfManyTiles)
{
    // 24^3 places of blocks, a tenth of them filled: tiles of 2 x 2 columns, six a level, as many as threads need.
    Medium m(test::voxel_field(Vec3i(192), Vec3d(1.0), [](const Vec3i& p) {
        const bool filled = uniform(hash_bits(3, p.x() / 8, p.y() / 8, p.z() / 8)) < 0.1;
        return filled && p.x() % 8 > 1 ? 0.05 + 0.1 * uniform(hash_bits(4, p.x(), p.y(), p.z())) : 0.0;
    }));
    m.add_source([](const Vec3i& p) { return 1 + 0.5 * std::sin(0.3 * p.x() + 0.2 * p.y() - 0.4 * p.z()); });
    const SweepSet set = set_of(ordinates(OrdinateKind::LevelSymmetric, 8, 1), 0, 1, 0.3);
    SweepResult fast, slow;
    TransportSweep(m.index, m.faces).run(set, m.fields(), fast);
    reference_sweep(m.index, m.faces, set, m.fields(), slow);
    double largest;
    const double worst = worst_difference(fast, slow, largest);
    EXPECT_GT(largest, 1);
    EXPECT_LT(worst, 1e-5 * largest);  // single precision
}

TEST(TransportSweep, EqualsTheReferenceForEmission)
{
    Medium m(test::voxel_field(Vec3i(28, 27, 25), Vec3d(0.5, 1.0, 1.7),
                               [](const Vec3i& p) { return test::clumps(p, 11, missing); }));
    m.add_source([](const Vec3i& p) { return uniform(hash_bits(5, p.x(), p.y(), p.z())); });
    const SweepSet set = set_of(ordinates(OrdinateKind::Product, 32, 1), 0, 2, 0.3);
    SweepResult fast, slow, scattered;
    TransportSweep(m.index, m.faces).run(set, m.fields(), scattered);
    m.emission = true;
    TransportSweep(m.index, m.faces).run(set, m.fields(), fast);
    reference_sweep(m.index, m.faces, set, m.fields(), slow);
    double largest = 0;
    const double worst = worst_difference(fast, slow, largest);
    EXPECT_GT(largest, 0.5);
    EXPECT_LT(worst, 1e-5 * largest);
    EXPECT_GT(worst_difference(fast, scattered, largest), 1e-2 * largest) << "another law of the source";
}

TEST(TransportSweep, EqualsTheReferenceAlongAxesAndDiagonals)
{
    // Rays along faces and through edges and corners of blocks and voxels.
    Medium m(
        test::voxel_field(Vec3i(30, 33, 37), Vec3d(1.0), [](const Vec3i& p) { return test::clumps(p, 2, missing); }));
    m.add_source([](const Vec3i& p) { return 1 + 0.5 * std::sin(0.3 * p.x() + 0.2 * p.y() - 0.4 * p.z()); });
    SweepSet set;
    set.source_terms = set.moment_terms = 1;
    for (int n = 0; n < 27; ++n) {
        const Vec3d s(n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1);
        if (s.length() == 0) continue;
        set.direction.push_back(s.unit());
        set.weight.push_back(1.0f);
        set.inflow.push_back(float(n));
        set.source_basis.push_back(1.0f);
        set.moment_basis.push_back(float(n % 4 - 1));
    }
    SweepResult slow, fast;
    reference_sweep(m.index, m.faces, set, m.fields(), slow);
    TransportSweep(m.index, m.faces).run(set, m.fields(), fast);
    double largest;
    const double worst = worst_difference(fast, slow, largest);
    EXPECT_GT(largest, 1);
    EXPECT_LT(worst, 1e-5 * largest);
}

/// A symmetry of the cube: axis a of the image is axis permutation[a], mirrored where flip says.
struct Symmetry {
    std::array<int, 3> permutation;
    std::array<bool, 3> flip;
    Vec3i image(const Vec3i& p, int n) const
    {
        Vec3i q;
        for (int a = 0; a < 3; ++a) q[a] = flip[a] ? n - 1 - p[permutation[a]] : p[permutation[a]];
        return q;
    }
    uint8_t image(uint8_t face) const
    {
        for (int a = 0; a < 3; ++a)
            if (permutation[a] == face / 2) return uint8_t(2 * a + ((face % 2 != 0) != flip[a]));
        return face;
    }
};

/// All 48, or the 16 that keep an axis.
std::vector<Symmetry> symmetries(int kept)
{
    std::vector<Symmetry> all;
    std::array<int, 3> permutation{0, 1, 2};
    do {
        for (int flips = 0; flips < 8; ++flips)
            if (kept < 0 || permutation[size_t(kept)] == kept)
                all.push_back({permutation, {(flips & 1) != 0, (flips & 2) != 0, (flips & 4) != 0}});
    } while (std::next_permutation(permutation.begin(), permutation.end()));
    return all;
}

TEST(TransportSweep, HasTheSymmetriesOfItsQuadrature)
{
    // The image of a medium has the image of its light: fluence and flux in every voxel, and what passes its faces.
    // Voids, gaps between blocks and rays through edges of blocks included.
    constexpr int n = 32;
    const auto density = [](const Vec3i& p) { return test::clumps(p, 23, missing); };
    const auto source = [](const Vec3i& p) { return 1 + std::sin(0.7 * p.x() + 0.1 * p.y() - 0.3 * p.z()); };
    for (const auto& [kind, count, kept] :
         {std::tuple(OrdinateKind::LevelSymmetric, 24, -1), {OrdinateKind::Product, 32, 1}}) {
        const SweepSet set = set_of(ordinates(kind, count, 1, 1), 0, 1, 0.3);
        Medium m(test::voxel_field(Vec3i(n), Vec3d(0.8), density));
        m.add_source(source);
        SweepResult result;
        TransportSweep(m.index, m.faces).run(set, m.fields(), result);
        const auto group = symmetries(kept);
        ASSERT_EQ(group.size(), kept < 0 ? 48u : 16u);
        double asymmetry = 0;  // of the medium itself: what the comparison would see if it compared nothing
        for (const Symmetry& symmetry : group) {
            std::vector<float> of_density(n * n * n), of_source(n * n * n);
            const auto at = [](const Vec3i& p) { return size_t((p.x() * n + p.y()) * n + p.z()); };
            for (Vec3i p(0); p.x() < n; ++p.x())
                for (p.y() = 0; p.y() < n; ++p.y())
                    for (p.z() = 0; p.z() < n; ++p.z()) {
                        of_density[at(symmetry.image(p, n))] = float(density(p));
                        of_source[at(symmetry.image(p, n))] = float(source(p));
                    }
            Medium image(test::voxel_field(Vec3i(n), Vec3d(0.8), [&](const Vec3i& p) { return of_density[at(p)]; }));
            image.add_source([&](const Vec3i& p) { return of_source[at(p)]; });
            SweepResult mirrored;
            TransportSweep(image.index, image.faces).run(set, image.fields(), mirrored);

            const Blocks& blocks = m.index.blocks();
            static constexpr int moment_of[3] = {3, 1, 2};  // degree 1 along x, y, z
            for (size_t slot = 0; slot < blocks.count() * 512; ++slot) {
                if (!blocks.active(slot)) continue;
                const size_t there = image.index.blocks().slot(symmetry.image(blocks.voxel(slot), n));
                ASSERT_NEAR(mirrored.moments[0][there], result.moments[0][slot], 2e-5);
                asymmetry = std::max(asymmetry, double(std::abs(mirrored.moments[0][slot] - result.moments[0][slot])));
                for (int a = 0; a < 3; ++a) {
                    const float here = result.moments[size_t(moment_of[symmetry.permutation[size_t(a)]])][slot];
                    ASSERT_NEAR(mirrored.moments[size_t(moment_of[a])][there], symmetry.flip[size_t(a)] ? -here : here,
                                2e-5);
                }
            }
            std::map<std::pair<uint32_t, uint8_t>, FaceTally> of_face;
            for (size_t f = 0; f < image.faces.size(); ++f)
                of_face[{image.faces[f].slot, image.faces[f].face}] = mirrored.tally[f];
            for (size_t f = 0; f < m.faces.size(); ++f) {
                const auto there = image.index.blocks().slot(symmetry.image(blocks.voxel(m.faces[f].slot), n));
                const FaceTally& tally = of_face.at({uint32_t(there), symmetry.image(m.faces[f].face)});
                ASSERT_NEAR(tally.current, result.tally[f].current, 2e-5);
                ASSERT_NEAR(tally.fluence, result.tally[f].fluence, 2e-5);
                ASSERT_NEAR(tally.second, result.tally[f].second, 2e-5);
            }
        }
        EXPECT_GT(asymmetry, 0.1);
    }
}

TEST(TransportSweep, StaysBetweenSkyAndSourceAtAnyOpticalDepth)
{
    // Voxels of 1e-12 to 1e8 mean free paths, all alike and side by side.
    const std::vector<double> scales{1e-12, 1e-6, 1, 1e4, 1e8, 0};
    for (const double scale : scales) {
        Medium m(test::voxel_field(Vec3i(24), Vec3d(1.0), [&](const Vec3i& p) {
            const double u = uniform(hash_bits(9, uint64_t(p.x()), uint64_t(p.y()), uint64_t(p.z())));
            if (test::clumps(p, 31, missing) == 0) return 0.0;
            return scale > 0 ? scale * (0.5 + u) : scales[size_t(5 * u)];
        }));
        m.add_source([](const Vec3i& p) { return std::sqrt(4 * pi) * ((p.x() + p.y() + p.z()) % 3 ? 0.25 : 2.0); });
        const SweepSet set = set_of(ordinates(OrdinateKind::Product, 32, 1), 0, 0, 0.5);
        SweepResult fast, slow;
        TransportSweep(m.index, m.faces).run(set, m.fields(), fast);
        reference_sweep(m.index, m.faces, set, m.fields(), slow);
        const double unit = std::sqrt(4 * pi);  // M_00 of L = 1
        for (size_t slot = 0; slot < m.index.blocks().count() * 512; ++slot) {
            if (!m.index.blocks().active(slot)) continue;
            ASSERT_TRUE(std::isfinite(fast.moments[0][slot])) << scale;
            ASSERT_GE(fast.moments[0][slot], 0.25 * unit - 1e-5) << scale;
            ASSERT_LE(fast.moments[0][slot], 2 * unit + 1e-5) << scale;
        }
        double largest;
        const double worst = worst_difference(fast, slow, largest);
        EXPECT_LT(worst, 1e-5 * largest) << scale;
    }
}

TEST(TransportSweep, IsZeroWithoutVoxelsOrDirections)
{
    Medium m(test::voxel_field(Vec3i(8), Vec3d(1.0), [](const Vec3i&) { return 0.0; }));
    m.add_source([](const Vec3i&) { return 1.0; });
    SweepResult result;
    TransportSweep sweep(m.index, m.faces);
    sweep.run(set_of(ordinates(OrdinateKind::Product, 8, 1), 0, 1, 1.0), m.fields(), result);
    ASSERT_EQ(result.moments.size(), 4u);
    for (const auto& moment : result.moments) EXPECT_EQ(moment, std::vector<float>(m.index.blocks().slots(), 0.0f));
    EXPECT_TRUE(result.tally.empty());
    Medium one(test::voxel_field(Vec3i(8), Vec3d(1.0), [](const Vec3i& p) { return p == Vec3i(3, 0, 7) ? 1.0 : 0.0; }));
    one.add_source([](const Vec3i&) { return 1.0; });
    SweepSet none;
    none.source_terms = none.moment_terms = 1;
    TransportSweep(one.index, one.faces).run(none, one.fields(), result);  // no directions
    EXPECT_EQ(result.moments, std::vector<std::vector<float>>(1, std::vector<float>(one.index.blocks().slots(), 0.0f)));
    EXPECT_EQ(result.tally.size(), 6u);
}

TEST(TransportSweep, KeepsTheWhiteFurnace)
{
    Medium m(
        test::voxel_field(Vec3i(40, 40, 40), Vec3d(0.7), [](const Vec3i& p) { return test::clumps(p, 5, missing); }));
    m.add_source([](const Vec3i&) { return std::sqrt(4 * pi); });  // Y_00 times this is 1
    const SweepSet set = set_of(ordinates(OrdinateKind::Product, 32, 1), 0, 2, 1.0);
    SweepResult result;
    TransportSweep(m.index, m.faces).run(set, m.fields(), result);
    const Blocks& blocks = m.index.blocks();
    for (size_t slot = 0; slot < blocks.count() * 512; ++slot) {
        if (!blocks.active(slot)) continue;
        ASSERT_NEAR(result.moments[0][slot], std::sqrt(4 * pi), 2e-5);
        for (int k = 1; k < 9; ++k) ASSERT_NEAR(result.moments[k][slot], 0, 2e-5);
    }
    ASSERT_FALSE(m.faces.empty());
    for (const FaceTally& tally : result.tally) {
        ASSERT_NEAR(tally.current, 0, 2e-5);
        ASSERT_NEAR(tally.fluence, 4 * pi, 5e-5);
        ASSERT_NEAR(tally.second, 0, 2e-5);
    }
}

TEST(TransportSweep, IsExactInLayersForSourcesLinearInOpticalDepth)
{
    // A slab along y, periodic across, q = a + b tau(y): L(mu) = q - mu b + (...) e^(-tau/mu), known in closed form.
    const int n = 24;
    const double h = 0.1, sigma = 7, a = 2, b = 0.5;
    Medium m(test::voxel_field(Vec3i(8, n, 8), Vec3d(h), [&](const Vec3i&) { return sigma; }), {true, false, true});
    m.add_source([&](const Vec3i& p) { return a + b * sigma * h * (p.y() + 0.5); });  // depth grows with y
    SweepSet set;
    set.source_terms = set.moment_terms = 1;
    for (const Vec3d& s : {Vec3d(0, 1, 0), Vec3d(0.8, 0.6, 0), Vec3d(-0.48, -0.6, 0.64), Vec3d(0.96, 0.28, 0)}) {
        set.direction = {s};
        set.weight = set.source_basis = set.moment_basis = {1.0f};
        set.inflow = {3.0f};
        SweepResult result;
        reference_sweep(m.index, m.faces, set, m.fields(), result);
        const double mu = std::abs(s.y()), slope = s.y() > 0 ? b : -b;
        // The first half voxel has the constant q of its voxel.
        const double first = sigma * h / 2 / mu, edge = s.y() > 0 ? 0.5 : n - 0.5;
        const double q_first = a + b * sigma * h * edge,
                     start = 3 * std::exp(-first) + q_first * (1 - std::exp(-first));
        for (int j = 0; j < n; ++j) {
            const double depth = std::abs(j + 0.5 - edge) * sigma * h;
            const double q = a + b * sigma * h * (j + 0.5);
            const double exact = q - slope * mu + (start - q_first + slope * mu) * std::exp(-depth / mu);
            EXPECT_NEAR(result.moments[0][m.index.blocks().slot(Vec3i(3, j, 5))], exact, 2e-6) << s << ' ' << j;
        }
    }
}

TEST(TransportSweep, CarriesLightAcrossAGapOf40000Voxels)
{
    // An emitting cloud and a dark one, 40 000 voxels apart along x: only directions along the gap see it.
    for (int gap : {20, 40000}) {
        const int far = 16 + gap;
        Medium m(test::voxel_clouds({{Vec3i(0, 0, 0), Vec3i(15, 15, 15)}, {Vec3i(far, 0, 0), Vec3i(far + 15, 15, 15)}},
                                    Vec3d(1.0), 0.2));
        m.add_source([&](const Vec3i& p) { return p.x() < 16 ? 1.0 : 0.0; });
        SweepSet set;
        set.source_terms = set.moment_terms = 1;
        set.direction = {Vec3d(1, 0, 0)};
        set.weight = set.source_basis = set.moment_basis = {1.0f};
        SweepResult result;
        TransportSweep(m.index, m.faces).run(set, m.fields(), result);
        const double left = 1 - std::exp(-0.2 * 16);
        for (int i = 0; i < 16; ++i)
            EXPECT_NEAR(result.moments[0][m.index.blocks().slot(Vec3i(far + i, 7, 3))],
                        left * std::exp(-0.2 * (i + 0.5)), 1e-5);
    }
}

TEST(TransportSweep, AttenuatesABeamAtFirstOrder)
{
    // Inflow 1 through a smooth ball without source: L at the centre is exp(-tau) of the exact density. Each plane
    // interpolates once, at O(h^2), and there are O(1/h) of them.
    double error[3];
    for (int k = 0; k < 3; ++k) {
        const int n = 16 << k;
        const double h = 2.0 / n;
        Medium m(test::voxel_field(Vec3i(n), Vec3d(h), [&](const Vec3i& p) {
            const Vec3d x = Vec3d(p.x() + 0.5, p.y() + 0.5, p.z() + 0.5) * h - Vec3d(1.0);
            return std::max(0.0, 3 * std::pow(std::max(0.0, 1 - x.dot(x)), 2));
        }));
        m.add_source([](const Vec3i&) { return 0.0; });
        SweepSet set;
        set.source_terms = set.moment_terms = 1;
        set.direction = {Vec3d(0.36, 0.48, 0.8)};
        set.weight = set.source_basis = set.moment_basis = set.inflow = {1.0f};
        SweepResult result;
        TransportSweep(m.index, m.faces).run(set, m.fields(), result);
        double mean = 0;  // of the eight voxels about the centre; tau is even to first order about it
        for (int c = 0; c < 8; ++c)
            mean +=
                result
                    .moments[0][m.index.blocks().slot(Vec3i(n / 2 - (c & 1), n / 2 - (c >> 1 & 1), n / 2 - (c >> 2)))] /
                8;
        const double tau = 3 * (1 - 2.0 / 3 + 1.0 / 5);  // int_0^1 3 (1 - r^2)^2
        error[k] = std::abs(mean - std::exp(-tau));
    }
    EXPECT_GT(std::log2(error[0] / error[1]), 0.9);
    EXPECT_GT(std::log2(error[1] / error[2]), 0.9);
    EXPECT_LT(error[2], 5e-3);
}

TEST(TransportSweep, BalancesEmissionAndOutflowToFirstOrder)
{
    // Power of a glowing ball through its staircase of faces against emission less absorption; hard and
    // soft edge.
    for (const auto& [hard, most] : {std::pair(true, 0.10), {false, 0.02}}) {
        double defect[2];
        for (int k = 0; k < 2; ++k) {
            const int n = 16 << k;
            const double h = 1.0 / n;
            Medium m(test::voxel_field(Vec3i(n), Vec3d(h), [&, hard = hard](const Vec3i& p) {
                const Vec3d x = (Vec3d(p.x(), p.y(), p.z()) + Vec3d(0.5)) * h - Vec3d(0.5);
                const double inside = 1 - x.dot(x) / 0.2;
                return inside < 0 ? 0.0 : hard ? 10.0 : 20 * inside;
            }));
            m.add_source([](const Vec3i&) { return std::sqrt(4 * pi); });
            SweepResult result;
            TransportSweep(m.index, m.faces)
                .run(set_of(ordinates(OrdinateKind::Product, 32, 1), 0, 0, 0), m.fields(), result);
            double gain = 0, out = 0;
            for (size_t slot = 0; slot < m.index.blocks().count() * 512; ++slot)
                gain += m.sigma[slot] * h * std::sqrt(4 * pi) * (std::sqrt(4 * pi) - result.moments[0][slot]);
            for (const FaceTally& face : result.tally) out += face.current;
            defect[k] = std::abs(out / gain - 1);
        }
        EXPECT_LT(defect[1], most) << hard;
        EXPECT_GT(defect[0] / defect[1], 1.7) << hard << ' ' << defect[0] << ' ' << defect[1];
    }
}

TEST(TransportSweep, RefusesMediaThatRepeatAlongAllAxes)
{
    Medium m(test::voxel_field(Vec3i(8), Vec3d(1.0), [](const Vec3i&) { return 1.0; }), {true, true, true});
    EXPECT_THROW(TransportSweep(m.index, m.faces), InputError);
}

}  // namespace
}  // namespace vdbcloud
