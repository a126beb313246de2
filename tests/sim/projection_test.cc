// The projection for all kinds of sides and shapes: the remaining divergence is round-off, and a field without
// divergence is unchanged.
#include "vdbcloud/sim/projection.h"

#include "vdbcloud/core/random.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud::sim {
namespace {

template<typename T>
struct Winds {
    Field<T> u, v, w;
    explicit Winds(const Lattice& l)
    {
        if (!l.flat(0)) u = Field<T>(l);
        if (!l.flat(1)) v = Field<T>(l);
        w = Field<T>(l);
    }
    void fill_halos(const Lattice& l)
    {
        if (u) fill_halo(l, Place::FaceX, u);
        if (v) fill_halo(l, Place::FaceY, v);
        fill_halo(l, Place::FaceZ, w);
    }
    void set_random(const Lattice& l, uint64_t seed)
    {
        int component = 0;
        for (Field<T>* f : {&u, &v, &w}) {
            const int axis = component++;
            if (!*f) continue;
            for (int k = 0; k < l.n[2]; ++k)
                for (int j = 0; j < (axis == 1 ? l.faces(1) : l.n[1]); ++j)
                    for (int i = 0; i < (axis == 0 ? l.faces(0) : l.n[0]); ++i)
                        (*f)(i, j, k) = T(uniform(hash_bits(seed, axis, i, j, k)) - 0.5);
        }
        fill_halos(l);
    }
};

struct Case {
    std::array<int, 3> n;
    std::array<double, 3> h;
    Side x, y;
    bool anelastic;
};

class ProjectionOf : public testing::TestWithParam<Case> {
protected:
    static Lattice lattice() { return {GetParam().n, GetParam().h, {GetParam().x, GetParam().y}}; }
    static BaseDensity density()
    {
        const int nz = GetParam().n[2];
        BaseDensity rho = BaseDensity::uniform(nz);
        if (!GetParam().anelastic) return rho;
        for (int k = 0; k < nz; ++k) rho.centre[size_t(k)] = std::exp(-1.5 * (k + 0.5) / nz);
        for (int k = 0; k <= nz; ++k) rho.face[size_t(k)] = std::exp(-1.5 * k / nz);
        return rho;
    }
    template<typename T>
    static double remaining_divergence()
    {
        const Lattice l = lattice();
        Projection<T> projection(l, density());
        Winds<T> winds(l);
        winds.set_random(l, 11);
        const double before = projection.max_divergence(winds.u, winds.v, winds.w);
        projection.project(winds.u, winds.v, winds.w);
        winds.fill_halos(l);
        EXPECT_GT(before, 0);
        return projection.max_divergence(winds.u, winds.v, winds.w) / before;
    }
};

TEST_P(ProjectionOf, NoiseLeavesRoundOffInDouble) { EXPECT_LT(remaining_divergence<double>(), 2e-14); }

TEST_P(ProjectionOf, NoiseLeavesRoundOffInFloat) { EXPECT_LT(remaining_divergence<float>(), 1e-5); }

TEST_P(ProjectionOf, DivergenceFreeFieldIsUnchanged)
{
    const Lattice l = lattice();
    Projection<double> projection(l, density());
    Winds<double> once(l), twice(l);
    for (Winds<double>* w : {&once, &twice}) {
        w->set_random(l, 5);
        projection.project(w->u, w->v, w->w);
        w->fill_halos(l);
    }
    projection.project(twice.u, twice.v, twice.w);
    twice.fill_halos(l);
    double change = 0;
    for (int k = 0; k < l.n[2]; ++k)
        for (int j = 0; j < l.n[1]; ++j)
            for (int i = 0; i < l.n[0]; ++i) {
                change = std::max(change, std::abs(once.w(i, j, k) - twice.w(i, j, k)));
                if (once.u) change = std::max(change, std::abs(once.u(i, j, k) - twice.u(i, j, k)));
                if (once.v) change = std::max(change, std::abs(once.v(i, j, k) - twice.v(i, j, k)));
            }
    EXPECT_LT(change, 1e-13);
}

/// Where the value at i along an axis of n cells comes from, and its sign: reflections one at a time.
struct Source {
    int index, sign;
};
Source source(int i, int n, Side side, bool normal)
{
    int sign = 1;
    if (side == Side::Open) return {std::max(0, std::min(i, normal ? n : n - 1)), 1};
    const int end = side == Side::Wall && normal ? n : n - 1;
    while (i < 0 || i > end) {
        if (side == Side::Periodic)
            i += i < 0 ? n : -n;
        else if (normal)
            i = i < 0 ? -i : 2 * n - i, sign = -sign;
        else
            i = i < 0 ? -1 - i : 2 * n - 1 - i;
    }
    return {i, side == Side::Wall && normal && (i == 0 || i == n) ? 0 : sign};
}

TEST_P(ProjectionOf, HalosContinueTheWind)
{
    const Lattice l = lattice();
    Projection<float> projection(l, density());
    Winds<float> winds(l);
    winds.set_random(l, 7);
    projection.project(winds.u, winds.v, winds.w);
    const Side sides[] = {l.side[0], l.side[1], Side::Wall};
    int component = 0;
    for (const Field<float>* f : {&winds.u, &winds.v, &winds.w}) {
        const int normal = component++;
        if (!*f) continue;
        const auto beyond = [&](int axis) { return l.flat(axis) ? 0 : halo; };
        for (int k = -beyond(2); k < l.n[2] + beyond(2); ++k)
            for (int j = -beyond(1); j < l.n[1] + beyond(1); ++j)
                for (int i = -beyond(0); i < l.n[0] + beyond(0); ++i) {
                    const int at[] = {i, j, k};
                    Source s[3];
                    for (const int axis : {0, 1, 2})
                        s[axis] = source(at[axis], l.n[size_t(axis)], sides[axis], axis == normal);
                    ASSERT_EQ((*f)(i, j, k),
                              float(s[0].sign * s[1].sign * s[2].sign) * (*f)(s[0].index, s[1].index, s[2].index))
                        << normal << " at " << i << ' ' << j << ' ' << k;
                }
    }
}

/// The correction is a gradient: orthogonal, in the sense of kinetic energy, to every velocity without divergence.
TEST_P(ProjectionOf, ChangeIsOrthogonalToTheResult)
{
    const Lattice l = lattice();
    const BaseDensity rho = density();
    Projection<double> projection(l, rho);
    Winds<double> before(l), after(l);
    before.set_random(l, 3), after.set_random(l, 3);
    projection.project(after.u, after.v, after.w);
    after.fill_halos(l);
    double dot = 0, norm = 0;
    const auto add = [&](const Field<double>& a, const Field<double>& b, int i, int j, int k, double weight) {
        dot += weight * (a(i, j, k) - b(i, j, k)) * b(i, j, k);
        norm += weight * b(i, j, k) * b(i, j, k);
    };
    for (int k = 0; k < l.n[2]; ++k)
        for (int j = 0; j < l.n[1]; ++j)
            for (int i = 0; i < l.n[0]; ++i) {
                // The face of an open side owns half a cell.
                const double r = rho.centre[size_t(k)];
                const bool open_x = l.side[0] == Side::Open, open_y = l.side[1] == Side::Open;
                if (before.u) add(before.u, after.u, i, j, k, open_x && i == 0 ? r / 2 : r);
                if (before.u && open_x && i + 1 == l.n[0]) add(before.u, after.u, i + 1, j, k, r / 2);
                if (before.v) add(before.v, after.v, i, j, k, open_y && j == 0 ? r / 2 : r);
                if (before.v && open_y && j + 1 == l.n[1]) add(before.v, after.v, i, j + 1, k, r / 2);
                if (k > 0) add(before.w, after.w, i, j, k, rho.face[size_t(k)]);
            }
    EXPECT_LT(std::abs(dot), 1e-12 * (norm + 1e-300));
}

INSTANTIATE_TEST_SUITE_P(Shapes, ProjectionOf,
                         testing::Values(Case{{16, 12, 10}, {1, 1, 1}, Side::Periodic, Side::Periodic, false},
                                         Case{{15, 13, 11}, {1, 2, 0.5}, Side::Periodic, Side::Periodic, false},
                                         Case{{16, 12, 10}, {1, 1, 1}, Side::Wall, Side::Wall, false},
                                         Case{{16, 12, 10}, {1, 1, 1}, Side::Open, Side::Open, false},
                                         Case{{9, 14, 17}, {20, 3, 1}, Side::Wall, Side::Periodic, true},
                                         Case{{12, 9, 17}, {3, 1, 20}, Side::Periodic, Side::Open, true},
                                         Case{{24, 1, 16}, {1, 1, 1}, Side::Periodic, Side::Periodic, false},
                                         Case{{1, 24, 16}, {1, 1, 1}, Side::Periodic, Side::Wall, false},
                                         Case{{2, 3, 2}, {1, 1, 1}, Side::Periodic, Side::Wall, false},
                                         Case{{64, 64, 64}, {10, 10, 10}, Side::Periodic, Side::Periodic, true}));

TEST(Projection, PlaneWaveKeepsItsTransversePart)
{
    // u = sin(a x) cos(b z) with w = 0 under a rigid lid: the discrete answer has the same shape, and its weight
    // follows from the discrete wave numbers alone.
    const Lattice l{{32, 1, 24}, {2, 1, 3}, {Side::Periodic, Side::Periodic}};
    const double a = 2 * M_PI / 32 * 3, b = M_PI / 24 * 2;  // phase a cell
    Winds<double> winds(l);
    for (int k = 0; k < 24; ++k)
        for (int i = 0; i < 32; ++i) winds.u(i, 0, k) = std::sin(a * i) * std::cos(b * (k + 0.5));
    winds.fill_halos(l);
    Projection<double> projection(l, BaseDensity::uniform(24));
    projection.project(winds.u, winds.v, winds.w);
    const double kx = 2 * std::sin(a / 2) / 2, kz = 2 * std::sin(b / 2) / 3;
    const double kept = kz * kz / (kx * kx + kz * kz);
    for (int k = 0; k < 24; ++k)
        for (int i = 0; i < 32; ++i)
            ASSERT_NEAR(winds.u(i, 0, k), kept * std::sin(a * i) * std::cos(b * (k + 0.5)), 1e-14);
}

}  // namespace
}  // namespace vdbcloud::sim
