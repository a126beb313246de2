// The same weather turned or mirrored: every preset has twins that must become its turned or mirrored image.
#include "air.h"

#include "vdbcloud/sim/presets.h"
#include "vdbcloud/sim/sounding.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

namespace vdbcloud::sim {
namespace {

using namespace test;

/// A change of the horizontal axes that maps solutions to solutions: (x, y) -> (y, x), (L - x, y) or (x, L - y).
enum class Turn { Exchange, MirrorX, MirrorY };

/// Velocities along x and y change places, or their sign.
Quantity turned(Turn turn, Quantity q)
{
    if (turn != Turn::Exchange) return q;
    return q == Quantity::U ? Quantity::V : q == Quantity::V ? Quantity::U : q;
}

std::array<double, 2> turned(Turn turn, const Lattice& l, double x, double y)
{
    if (turn == Turn::Exchange) return {y, x};
    return turn == Turn::MirrorX ? std::array<double, 2>{l.n[0] * l.h[0] - x, y}
                                 : std::array<double, 2>{x, l.n[1] * l.h[1] - y};
}

Preset turned(Turn turn, Preset s)
{
    Lattice& l = s.parameters.lattice;
    const Lattice before = l;
    for (Bubble& b : s.parameters.bubbles) {
        const auto to = turned(turn, before, b.centre[0], b.centre[1]);
        b.centre = {to[0], to[1], b.centre[2]};
    }
    for (Patch& patch : s.parameters.floor.patches)
        patch.centre = turned(turn, before, patch.centre[0], patch.centre[1]);
    const auto negated = [](std::vector<double>& wind) {
        for (double& w : wind) w = -w;
    };
    LargeScale& forcing = s.parameters.large_scale;
    s.parameters.coriolis *= -1;  // images in a mirror turn the other way
    if (turn == Turn::MirrorX) negated(s.sounding.u), negated(forcing.u_g);
    if (turn == Turn::MirrorY) negated(s.sounding.v), negated(forcing.v_g);
    if (turn == Turn::Exchange) {
        std::swap(l.n[0], l.n[1]), std::swap(l.h[0], l.h[1]), std::swap(l.side[0], l.side[1]);
        std::swap(s.sounding.u, s.sounding.v), std::swap(forcing.u_g, forcing.v_g);
    }
    return s;
}

/// Values of quantity `q` of a lattice `l`, as the twin has them. Lower faces become upper ones: in a periodic box the
/// last is the first, and a wall has no velocity.
std::vector<double> turned(Turn turn, const Lattice& l, Quantity q, const std::vector<double>& values)
{
    const int nx = l.n[0], ny = l.n[1];
    std::vector<double> out(values.size());
    for (int k = 0; k < l.n[2]; ++k)
        for (int j = 0; j < ny; ++j)
            for (int i = 0; i < nx; ++i) {
                const size_t from = size_t((k * ny + j) * nx + i);
                int x = i, y = j;
                double sign = 1;
                if (turn == Turn::MirrorX) x = q == Quantity::U ? (nx - i) % nx : nx - 1 - i;
                if (turn == Turn::MirrorY) y = q == Quantity::V ? (ny - j) % ny : ny - 1 - j;
                if ((turn == Turn::MirrorX && q == Quantity::U) || (turn == Turn::MirrorY && q == Quantity::V))
                    sign = -1;
                out[turn == Turn::Exchange ? size_t((k * nx + i) * ny + j) : size_t((k * ny + y) * nx + x)] =
                    sign * values[from];
            }
    return out;
}

/// The image of the first face of an open side is beyond the last cell, where no plane of values has it.
bool has_no_image(Turn turn, const Lattice& l, Quantity q, size_t cell)
{
    if (turn == Turn::MirrorY)
        return q == Quantity::V && l.side[1] == Side::Open && cell / size_t(l.n[0]) % size_t(l.n[1]) == 0;
    return turn == Turn::MirrorX && q == Quantity::U && l.side[0] == Side::Open && cell % size_t(l.n[0]) == 0;
}

constexpr Quantity quantities[] = {Quantity::U,     Quantity::V,    Quantity::W,  Quantity::Theta,
                                   Quantity::Water, Quantity::Rain, Quantity::Dye};

/// A preset on few cells, in double, so that rounding stays far below what is compared.
Preset small(const std::string& name, std::array<int, 3> cells)
{
    Preset s = preset(name);
    Parameters& p = s.parameters;
    const Lattice before = p.lattice;
    for (const size_t d : {0, 1, 2}) {
        if (cells[d] > 1) p.lattice.h[d] *= double(before.n[d]) / cells[d];
        p.lattice.n[d] = cells[d];
    }
    rescale_forcing(p, before);
    p.precision = Precision::Double;
    add_wind(s.sounding, 3, -2, 1e-3, 5e-4);
    return s;
}

/// Largest difference of a run and the image of its twin, relative to the largest value of each quantity's changes.
void expect_twins(const Preset& s, Turn turn, bool given_start, double until)
{
    const Lattice& l = s.parameters.lattice;
    const Preset t = turned(turn, s);
    auto a = Simulation::make(s.parameters, s.sounding), b = Simulation::make(t.parameters, t.sounding);
    std::vector<std::vector<double>> first;
    for (const Quantity q : quantities) {
        first.push_back(a->has(q) ? all(*a, q) : std::vector<double>());
        if (a->has(q) && given_start) b->set(turned(turn, q), turned(turn, l, q, first.back()));
    }
    a->advance_to(until), b->advance_to(until);
    EXPECT_EQ(a->budget().steps, b->budget().steps);
    EXPECT_GT(a->budget().w_max, 1e-3) << "nothing moves";
    size_t n = 0;
    for (const Quantity q : quantities) {
        const std::vector<double>& start = first[n++];
        ASSERT_EQ(a->has(q), b->has(turned(turn, q)));
        if (!a->has(q)) continue;
        const auto end = all(*a, q);
        // Rounding of 1e-16 grows with the steps and with the flow: 1e-9 of the change is far above, any missing term
        // far below.
        const double scale = std::max(largest_difference(end, start), 1e-6 * largest(end));
        auto image = turned(turn, l, q, end), twin = all(*b, turned(turn, q));
        for (size_t c = 0; c < twin.size(); ++c)
            if (has_no_image(turn, l, q, c)) twin[c] = image[c];
        EXPECT_LE(largest_difference(image, twin), 1e-9 * scale) << int(q);
    }
}

/// A fire of seconds makes eddies that rounding changes within a minute.
double twin_time(const std::string& name, double wanted) { return std::min(wanted, 60 * preset(name).minutes / 4); }

TEST(Twins, EveryPresetIsTheImageOfItsTurnedAndMirroredTwin)
{
    for (const std::string& name : preset_names())
        for (const Turn turn : {Turn::Exchange, Turn::MirrorX, Turn::MirrorY}) {
            SCOPED_TRACE(name + " turn " + std::to_string(int(turn)));
            expect_twins(small(name, {14, 11, 12}), turn, true, twin_time(name, 90));
        }
}

TEST(Twins, SlicesOfEveryPresetAlongXAndYAgreeWithTheirNoise)
{
    for (const std::string& name : preset_names()) {
        SCOPED_TRACE(name);
        // The twin makes its own start: bubbles, patches and noise are those of the slice along x.
        Preset slice = small(name, {24, 1, 16});
        slice.parameters.coriolis = 0;
        expect_twins(slice, Turn::Exchange, false, twin_time(name, 120));
    }
}

TEST(Twins, AllEffectsAtOnceHaveTwins)
{
    for (const TimeScheme scheme : {TimeScheme::Rk3, TimeScheme::HugeStep})
        for (const Side side : {Side::Periodic, Side::Wall})
            for (const Turn turn : {Turn::Exchange, Turn::MirrorX, Turn::MirrorY}) {
                Preset s = small("cumulus", {13, 10, 12});
                Parameters& p = s.parameters;
                p.time_scheme = scheme;
                p.lattice.side = {side, Side::Periodic};
                p.rain = p.anelastic = p.dye = p.subgrid = true;
                p.friction_time = 2000, p.viscosity = 2, p.diffusivity = 1, p.radiation = 50, p.wind_relaxation = 90;
                p.coriolis = 1e-3, p.surface = {0, 1e-3, 2e-3, 3e-3, 305};
                p.large_scale.z = {0, 2000}, p.large_scale.w = {0.1, -0.3}, p.large_scale.water = {1e-6, -1e-6};
                p.large_scale.u_g = {9, 5}, p.large_scale.v_g = {1, -2}, p.large_scale.theta = {1e-3, -1e-3};
                p.bubbles.push_back({{2000, 1700, 1200}, 1200, 700, 2, 1e-2, 1});  // rains at once
                SCOPED_TRACE("scheme " + std::to_string(int(scheme)) + " side " + std::to_string(int(side)) + " turn " +
                             std::to_string(int(turn)));
                expect_twins(s, turn, true, 60);
            }
    Preset s = small("cumulus", {13, 10, 12});
    s.parameters.rain = true, s.parameters.bubbles.push_back({{2000, 1700, 1200}, 1200, 700, 2, 1e-2, 1});
    auto wet = Simulation::make(s.parameters, s.sounding);
    wet->advance_to(60);
    EXPECT_GT(largest(all(*wet, Quantity::Rain)), 1e-6) << "this scene has rain";
}

TEST(Twins, OpenSidesHaveTwins)
{
    for (const Turn turn : {Turn::Exchange, Turn::MirrorX, Turn::MirrorY}) {
        Preset s = small("cumulus", {13, 10, 12});
        s.parameters.noise = {};  // a start with noise needs the upper faces, which cannot be given
        s.parameters.lattice.side = {Side::Open, Side::Wall};
        SCOPED_TRACE(int(turn));
        expect_twins(s, turn, false, 60);
    }
}

}  // namespace
}  // namespace vdbcloud::sim
