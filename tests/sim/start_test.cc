// The first air from a file: axes, places, units and lattices of the file, against fields that trilinear values keep.
#include "air.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/grid/up_axis.h"
#include "vdbcloud/sim/snapshot.h"

#include <gtest/gtest.h>

namespace vdbcloud::sim {
namespace {

using namespace test;
using Field3 = std::function<double(double x, double y, double z)>;

/// A box of air whose wind is given, so that the start does not project it: values are what was read.
Parameters box(std::array<int, 3> n, Side side)
{
    Parameters p = bare(n, {1200, 960, 800}, side, side);
    p.momentum = false, p.buoyancy = p.moisture = true;
    p.moist.by = SaturationBy::Height, p.moist.latent_heat = false;  // the temperature of files is theta_l
    return p;
}

/// How a file holds the air.
struct Format {
    UpAxis up = UpAxis::Z;
    bool staggered = true;
    double metres = 1;       ///< in a world unit
    std::array<int, 3> n{};  ///< voxels along x, y and up
    bool says_up = true;
    bool mirrored = false;  ///< index along x runs against x
};

/// The fields of x, y, z in metres, from the corner of the box of `l`, as grids of a format.
GridFile file_of(const Format& f, const Lattice& l, const Field3& u, const Field3& v, const Field3& w, const Field3& t,
                 const Field3& q)
{
    std::array<double, 3> h{};
    for (const size_t d : {0, 1, 2}) h[d] = l.n[d] * l.h[d] / f.n[d];
    const bool y_up = f.up == UpAxis::Y;
    const auto turned = [&](double a, double b, double c) { return y_up ? Vec3d(a, c, b) : Vec3d(a, b, c); };
    const double corner_x = -0.5 * l.n[0] * l.h[0], corner_y = -0.5 * l.n[1] * l.h[1];
    openvdb::Mat4R m = openvdb::Mat4R::identity();
    const Vec3d size = turned(f.mirrored ? -h[0] : h[0], h[1], h[2]),
                first = turned(f.mirrored ? -corner_x - 0.5 * h[0] : corner_x + 0.5 * h[0], corner_y + 0.5 * h[1],
                               0.5 * h[2]);
    for (const int d : {0, 1, 2}) m(d, d) = size[d] / f.metres, m(3, d) = first[d] / f.metres;
    const auto transform = openvdb::math::Transform::createLinearTransform(m);
    auto vel = Vec3SGrid::create();
    auto temperature = FloatGrid::create(), water = FloatGrid::create();
    vel->setName("vel"), temperature->setName("temperature"), water->setName("qt");
    vel->setGridClass(f.staggered ? openvdb::GRID_STAGGERED : openvdb::GRID_UNKNOWN);
    for (int k = 0; k < f.n[2]; ++k)
        for (int j = 0; j < f.n[1]; ++j)
            for (int i = 0; i < f.n[0]; ++i) {
                const openvdb::Coord at = y_up ? openvdb::Coord(i, k, j) : openvdb::Coord(i, j, k);
                const int along = f.mirrored ? f.n[0] - 1 - i : i;
                const double x = (along + 0.5) * h[0], y = (j + 0.5) * h[1], z = (k + 0.5) * h[2];
                // A staggered component lies half a voxel lower in index space.
                const double s = f.staggered ? 0.5 : 0, sx = f.mirrored ? -s : s;
                const Vec3d wind = turned(u(x - sx * h[0], y, z), v(x, y - s * h[1], z), w(x, y, z - s * h[2]));
                vel->tree().setValue(at, Vec3f(wind / f.metres));
                temperature->tree().setValue(at, float(t(x, y, z)));
                water->tree().setValue(at, float(q(x, y, z)));
            }
    GridFile file;
    file.path = "start.vdb";
    file.metadata = std::make_shared<MetaMap>();
    if (f.says_up) write_up_axis(*file.metadata, f.up);
    if (f.metres != 1) set_number(*file.metadata, schema::meters_per_unit, f.metres);
    file.grids = {vel, temperature, water};
    for (const auto& grid : file.grids) grid->setTransform(transform->copy());
    return file;
}

const Field3 linear_u = [](double x, double y, double z) { return 1 + 2e-3 * x - 1e-3 * y + 3e-3 * z; };
const Field3 linear_v = [](double x, double y, double z) { return -2 + 1e-3 * x + 4e-3 * y - 1e-3 * z; };
const Field3 linear_w = [](double x, double y, double z) { return 0.5 - 1e-3 * x + 2e-3 * y + 1e-3 * z; };
const Field3 linear_t = [](double x, double y, double z) { return 290 + 2e-3 * x - 3e-3 * y + 5e-3 * z; };
const Field3 linear_q = [](double x, double y, double z) { return 0.005 + 1e-6 * x + 2e-6 * y - 3e-6 * z; };
const Sounding calm{"calm", {0}, {300}, {0.004}, {0}, {0}, 0};

/// Largest error of a quantity at the cells that lie `margin` [m] within the box.
double error_of(const Simulation& sim, Quantity q, const Field3& exact, double margin)
{
    const Lattice& l = sim.parameters().lattice;
    const auto values = all(sim, q), wanted = values_at(l, q, exact);
    const auto shown = values_at(l, q, [&](double x, double y, double z) {
        const auto within = [&](double at, size_t d) {
            return at >= margin - 1e-6 && at <= l.n[d] * l.h[d] - margin + 1e-6;
        };
        return within(x, 0) && within(y, 1) && within(z, 2) ? 1.0 : 0.0;
    });
    double most = 0;
    size_t count = 0;
    for (size_t c = 0; c < values.size(); ++c) {
        if (shown[c] == 0) continue;
        most = std::max(most, std::abs(values[c] - wanted[c]));
        ++count;
    }
    EXPECT_GT(count, values.size() / 16);
    return most;
}

TEST(Start, LinearFieldsAreKeptByEveryAxisPlaceUnitAndLattice)
{
    for (const UpAxis up : {UpAxis::Y, UpAxis::Z})
        for (const bool staggered : {false, true})
            for (const double metres : {1.0, 0.01, 1000.0})
                for (const bool mirrored : {false, true})
                    for (const std::array<int, 3>& n :
                         {std::array<int, 3>{12, 8, 10}, {6, 4, 5}, {24, 16, 20}, {9, 10, 7}}) {
                        const Parameters p = box({12, 8, 10}, Side::Wall);
                        auto sim = Simulation::make(p, calm);
                        const Format format{up, staggered, metres, n, true, mirrored};
                        const GridFile file =
                            file_of(format, p.lattice, linear_u, linear_v, linear_w, linear_t, linear_q);
                        // The option names the other axis: what the file says counts.
                        const StartReport r = start_from(*sim, file, up == UpAxis::Y ? UpAxis::Z : UpAxis::Y);
                        SCOPED_TRACE(std::to_string(int(up)) + " staggered " + std::to_string(staggered) + " metres " +
                                     std::to_string(metres) + " voxels " + std::to_string(n[0]) + " mirrored " +
                                     std::to_string(mirrored));
                        EXPECT_EQ(r.up, up);
                        EXPECT_EQ(r.centred_wind, !staggered);
                        const bool same = n == p.lattice.n;
                        EXPECT_EQ(r.resampled, !same || !staggered);
                        // One voxel from the walls: beyond their centres values are repeated. Files hold floats: 7
                        // digits of a speed of 8 m/s, of 300 K and of 0.01 kg/kg.
                        const double margin = 210;
                        EXPECT_LT(error_of(*sim, Quantity::U, linear_u, margin), 4e-6);
                        EXPECT_LT(error_of(*sim, Quantity::V, linear_v, margin), 4e-6);
                        EXPECT_LT(error_of(*sim, Quantity::W, linear_w, margin), 4e-6);
                        EXPECT_LT(error_of(*sim, Quantity::Theta, linear_t, margin), 1e-4);
                        EXPECT_LT(error_of(*sim, Quantity::Water, linear_q, margin), 4e-9);
                        if (same && !mirrored && staggered) {
                            EXPECT_LT(error_of(*sim, Quantity::Theta, linear_t, 0), 1e-4) << "up to the walls";
                        }
                    }
}

TEST(Start, PeriodicFieldsConvergeAtSecondOrderUpToTheSides)
{
    const auto wave = [](double x, double y) { return std::sin(2 * M_PI * x / 1200) * std::cos(2 * M_PI * y / 960); };
    const Field3 u = [&](double x, double y, double) { return 5 * wave(x, y); };
    const Field3 t = [&](double x, double y, double) { return 300 + 5 * wave(x, y); };
    const Field3 q = [&](double x, double y, double) { return 0.01 + 1e-3 * wave(x, y); };
    const Field3 none = [](double, double, double) { return 0.0; };
    for (const bool staggered : {false, true}) {
        double error[2][3];
        for (const int fine : {0, 1}) {
            const Parameters p = box({60, 48, 4}, Side::Periodic);
            auto sim = Simulation::make(p, calm);
            const int n = fine ? 24 : 12;
            start_from(*sim, file_of({UpAxis::Y, staggered, 1, {n, n, 4}}, p.lattice, u, none, none, t, q), UpAxis::Y);
            error[fine][0] = rms(all(*sim, Quantity::U), values_at(p.lattice, Quantity::U, u));
            error[fine][1] = rms(all(*sim, Quantity::Theta), values_at(p.lattice, Quantity::Theta, t));
            error[fine][2] = 1000 * rms(all(*sim, Quantity::Water), values_at(p.lattice, Quantity::Water, q));
        }
        for (const int k : {0, 1, 2}) EXPECT_NEAR(std::log2(error[0][k] / error[1][k]), 2, 0.2) << k;
        // Linear interpolation of waves of 12 voxels errs by up to (2 pi / 12)^2 / 8 along either axis.
        EXPECT_LT(error[0][1], 5 * 2 * std::pow(2 * M_PI / 12, 2) / 8);
        EXPECT_GT(error[0][1], 5 * 0.1 * std::pow(2 * M_PI / 12, 2) / 8);
    }
}

TEST(Start, WhereNoVoxelIsActiveTheAirIsTheSoundings)
{
    const Parameters p = box({12, 8, 10}, Side::Wall);
    const Sounding s{"windy", {0, 800}, {300, 304}, {0.004, 0.002}, {3, 5}, {1, 1}, 0};
    GridFile file =
        file_of({UpAxis::Z, true, 1, {12, 8, 10}}, p.lattice, linear_u, linear_v, linear_w, linear_t, linear_q);
    // Only voxels of the lower half and of x beyond 600 m stay active; others hold nonsense.
    const auto keep = [&](auto& grid, const auto& nonsense) {
        for (auto it = grid.beginValueOn(); it; ++it)
            if (it.getCoord().x() < 6 || it.getCoord().z() >= 5) it.setValue(nonsense), it.setValueOff();
    };
    keep(*openvdb::gridPtrCast<FloatGrid>(file.grids[1]), NAN);
    keep(*openvdb::gridPtrCast<FloatGrid>(file.grids[2]), 1e30f);
    keep(*openvdb::gridPtrCast<Vec3SGrid>(file.grids[0]), Vec3f(1e30f));
    auto sim = Simulation::make(p, s), plain = Simulation::make(p, s);
    const StartReport r = start_from(*sim, file, UpAxis::Z);
    EXPECT_EQ(r.cells_set, 5u * 6 * 8 * 5);  // u, v, w, temperature, qt
    plain->start();
    for (const Quantity q : {Quantity::U, Quantity::V, Quantity::Theta, Quantity::Water}) {
        const auto read = all(*sim, q), env = all(*plain, q);
        const auto exact = values_at(p.lattice, q,
                                     q == Quantity::U       ? linear_u
                                     : q == Quantity::V     ? linear_v
                                     : q == Quantity::Theta ? linear_t
                                                            : linear_q);
        for (size_t c = 0; c < read.size(); ++c) {
            const size_t i = c % 12, j = c / 12 % 8, k = c / 96;
            if ((q == Quantity::U && i == 0) || (q == Quantity::V && j == 0)) continue;  // walls
            EXPECT_NEAR(read[c], i >= 6 && k < 5 ? exact[c] : env[c], 1e-4) << int(q) << ' ' << c;
        }
    }
}

TEST(Start, RefusesWhatItCannotReadByNameAndCell)
{
    const Parameters p = box({12, 8, 10}, Side::Wall);
    const auto refusal = [&](const std::function<void(GridFile&)>& spoil) -> std::string {
        GridFile file =
            file_of({UpAxis::Y, true, 1, {12, 8, 10}}, p.lattice, linear_u, linear_v, linear_w, linear_t, linear_q);
        spoil(file);
        auto sim = Simulation::make(p, calm);
        try {
            start_from(*sim, file, UpAxis::Y);
        } catch (const InputError& error) {
            return error.what();
        } catch (const IoError& error) {
            return error.what();
        }
        return "";
    };
    const auto scalar = [](GridFile& file, size_t n) { return openvdb::gridPtrCast<FloatGrid>(file.grids[n]); };
    EXPECT_EQ(refusal([](GridFile&) {}), "");
    // Voxel (3, 6, 5) of a file whose y is up is cell [3, 5, 6], with or without a temperature.
    EXPECT_EQ(refusal([&](GridFile& f) {
                  scalar(f, 2)->tree().setValue({3, 6, 5}, 1e30f);
                  f.grids.erase(f.grids.begin() + 1);
              }).rfind("start.vdb: qt: q_t in cell [3, 5, 6] = 1e+30: expected 0..1 kg/kg", 0),
              0u);
    EXPECT_EQ(refusal([&](GridFile& f) {
                  openvdb::gridPtrCast<Vec3SGrid>(f.grids[0])->tree().setValue({3, 6, 5}, Vec3f(0, 1e6f, 0));
                  f.grids = {f.grids[0]};
              }).rfind("start.vdb: vel: w in cell [3, 5, 6] = 1e+06: expected -500..500 m/s", 0),
              0u);
    EXPECT_EQ(refusal([&](GridFile& f) {
                  scalar(f, 1)->tree().setValue({3, 6, 5}, NAN);
              }).rfind("start.vdb: temperature: theta_l in cell [3, 5, 6] = nan: expected 100..2000 K", 0),
              0u);
    const std::string slanted = refusal([&](GridFile& f) { scalar(f, 1)->transform().preRotate(0.1); });
    EXPECT_NE(slanted.find("grid 'temperature' has voxels with slanted edges"), std::string::npos) << slanted;
    const std::string type = refusal([&](GridFile& f) {
        auto other = openvdb::DoubleGrid::create(290);
        other->setName("temperature");
        f.grids[1] = other;
    });
    EXPECT_NE(type.find("grid 'temperature' has values of type double: expected float"), std::string::npos) << type;
    const std::string unit = refusal([&](GridFile& f) { set_number(*f.metadata, schema::meters_per_unit, 1e9); });
    EXPECT_EQ(unit, "start.vdb: meters_per_unit = 1e+09: expected 1e-6..1e6");
    // What no program means is passed over, as other foreign metadata.
    EXPECT_EQ(refusal([&](GridFile& f) { set_number(*f.metadata, schema::meters_per_unit, 0); }), "");
    EXPECT_NE(refusal([&](GridFile& f) { f.grids.clear(); }).find("expected a grid temperature"), std::string::npos);
}

}  // namespace
}  // namespace vdbcloud::sim
