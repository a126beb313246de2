#include "vdbcloud/sim/statistics.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/sim/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

namespace vdbcloud::sim {

namespace {

// Columns of profiles, in the order of profile_columns().
enum Profile : size_t {
    ThetaL,
    Qt,
    Ql,
    Qr,
    U,
    V,
    ThetaV,
    CloudFraction,
    SaturatedFraction,
    ThetaL2,
    Qt2,
    U2,
    V2,
    Tke,
    W2,
    W3,
    WThetaL,
    WQt,
    WQl,
    WThetaV,
    UW,
    VW,
    SubgridThetaL,
    SubgridQt,
    SubgridUW,
    SubgridVW,
};

using Plane = std::vector<double>;

/// The cells of one level. `air`: 1, and 0 within bodies.
struct LevelPlanes {
    Plane air, theta, water, cloud, rain, u, v, w, theta_v, eddy;
};

/// Means over the places where a plane is 1: cells of air, or faces between two of them. NaN where it is 0 everywhere.
class Mean {
public:
    explicit Mean(const Plane& air) : air_(air) {}

    /// Of f(c).
    template<typename F>
    double of(const F& f) const
    {
        double sum = 0, count = 0;
        for (size_t c = 0; c < air_.size(); ++c)
            if (air_[c] > 0) sum += f(c), count += 1;
        return count > 0 ? sum / count : std::nan("");
    }
    double operator()(const Plane& a) const
    {
        return of([&](size_t c) { return a[c]; });
    }
    /// Of (a - mean a) (b - mean b).
    double covariance(const Plane& a, const Plane& b) const
    {
        const double ma = (*this)(a), mb = (*this)(b);
        return of([&](size_t c) { return (a[c] - ma) * (b[c] - mb); });
    }
    double part_above(const Plane& a, double threshold) const
    {
        return of([&](size_t c) { return a[c] > threshold ? 1.0 : 0.0; });
    }

private:
    const Plane& air_;
};

Plane mean_of(const Plane& a, const Plane& b)
{
    Plane m(a.size());
    for (size_t c = 0; c < a.size(); ++c) m[c] = 0.5 * (a[c] + b[c]);
    return m;
}

class Sampler {
public:
    explicit Sampler(const Simulation& sim) : sim_(sim), p_(sim.parameters()), l_(p_.lattice) {}

    LevelPlanes planes(int k) const
    {
        LevelPlanes at;
        for (Plane* plane : {&at.air, &at.theta, &at.water, &at.cloud, &at.rain, &at.u, &at.v, &at.w, &at.eddy})
            plane->resize(size_t(l_.n[0]) * size_t(l_.n[1]));
        sim_.get_air_plane(k, at.air.data());
        sim_.get_plane(Quantity::Theta, k, at.theta.data());
        sim_.get_plane(Quantity::Water, k, at.water.data());
        sim_.get_plane(Quantity::Rain, k, at.rain.data());
        sim_.get_plane(Quantity::U, k, at.u.data()), sim_.get_plane(Quantity::V, k, at.v.data());
        sim_.get_plane(Quantity::W, k, at.w.data());
        sim_.get_cloud_plane(k, at.cloud.data());
        sim_.get_eddy_plane(k, at.eddy.data());
        const double warm = p_.moist.latent_heat ? sim_.column().level[size_t(k)].heat : 0;
        at.theta_v.resize(at.theta.size());
        for (size_t c = 0; c < at.theta.size(); ++c)
            at.theta_v[c] = (at.theta[c] + warm * at.cloud[c]) *
                            (1 + 0.608 * (at.water[c] - at.cloud[c]) - at.cloud[c] - at.rain[c]);
        return at;
    }

    void at_centres(size_t k, const LevelPlanes& at, Profiles& to) const
    {
        const Mean mean(at.air);
        to[ThetaL][k] = mean(at.theta), to[Qt][k] = mean(at.water), to[Ql][k] = mean(at.cloud);
        to[Qr][k] = mean(at.rain), to[U][k] = mean(at.u), to[V][k] = mean(at.v), to[ThetaV][k] = mean(at.theta_v);
        to[CloudFraction][k] = mean.part_above(at.cloud, cloudy);
        to[SaturatedFraction][k] = mean.part_above(at.cloud, 0);
        to[ThetaL2][k] = mean.covariance(at.theta, at.theta), to[Qt2][k] = mean.covariance(at.water, at.water);
        to[U2][k] = mean.covariance(at.u, at.u), to[V2][k] = mean.covariance(at.v, at.v);
    }

    /// At the faces between two levels.
    void at_faces(size_t k, const LevelPlanes& below, const LevelPlanes& above, Profiles& to) const
    {
        Plane open(above.air);
        for (size_t c = 0; c < open.size(); ++c) open[c] *= below.air[c];
        const Mean mean(open);
        const Plane& w = above.w;
        const double rise = mean(w);
        to[W2][k] = mean.covariance(w, w);
        to[W3][k] = mean.of([&](size_t c) { return std::pow(w[c] - rise, 3); });
        const auto flux = [&](Plane LevelPlanes::*q) { return mean.covariance(w, mean_of(below.*q, above.*q)); };
        to[WThetaL][k] = flux(&LevelPlanes::theta), to[WQt][k] = flux(&LevelPlanes::water);
        to[WQl][k] = flux(&LevelPlanes::cloud), to[WThetaV][k] = flux(&LevelPlanes::theta_v);
        to[UW][k] = mean.covariance(beside(w, 0), mean_of(below.u, above.u));
        to[VW][k] = mean.covariance(beside(w, 1), mean_of(below.v, above.v));
        const Plane eddy = mean_of(below.eddy, above.eddy);
        const auto down_gradient = [&](const Plane& a, const Plane& b) {  // 1 / Pr = 3
            return mean.of([&](size_t c) { return -(3 * eddy[c] + p_.diffusivity) * (b[c] - a[c]) / l_.h[2]; });
        };
        to[SubgridThetaL][k] = down_gradient(below.theta, above.theta);
        to[SubgridQt][k] = down_gradient(below.water, above.water);
        to[SubgridUW][k] = mean(stress(0, eddy, below.u, above.u, w));
        to[SubgridVW][k] = mean(stress(1, eddy, below.v, above.v, w));
    }

private:
    /// The cell before c along an axis: the last one of a periodic axis, itself at other sides.
    size_t before(size_t c, size_t axis) const
    {
        const size_t nx = size_t(l_.n[0]), n = size_t(l_.n[axis]), stride = axis == 0 ? 1 : nx;
        const size_t i = axis == 0 ? c % nx : c / nx;
        if (i > 0) return c - stride;
        return l_.side[axis] == Side::Periodic ? c + (n - 1) * stride : c;
    }

    /// Means on the lower faces along an axis.
    Plane beside(const Plane& a, size_t axis) const
    {
        Plane m(a.size());
        for (size_t c = 0; c < a.size(); ++c) m[c] = 0.5 * (a[c] + a[before(c, axis)]);
        return m;
    }

    /// -nu (du/dz + dw/dx).
    Plane stress(size_t axis, const Plane& eddy, const Plane& below, const Plane& above, const Plane& w) const
    {
        Plane flux = beside(eddy, axis);
        for (size_t c = 0; c < flux.size(); ++c)
            flux[c] = -(flux[c] + p_.viscosity) *
                      ((above[c] - below[c]) / l_.h[2] + (w[c] - w[before(c, axis)]) / l_.h[axis]);
        return flux;
    }

    const Simulation& sim_;
    const Parameters& p_;
    const Lattice& l_;
};

/// Columns of air with more cloud than thresholds somewhere.
struct Covered {
    std::vector<char> cloud, saturated;

    explicit Covered(size_t columns) : cloud(columns, 0), saturated(columns, 0) {}
    void add(const LevelPlanes& at)
    {
        for (size_t c = 0; c < cloud.size(); ++c)
            if (at.air[c] > 0) cloud[c] |= at.cloud[c] > cloudy, saturated[c] |= at.cloud[c] > 0;
    }
    void add(const Covered& other)
    {
        for (size_t c = 0; c < cloud.size(); ++c) cloud[c] |= other.cloud[c], saturated[c] |= other.saturated[c];
    }
};

double part_of(const std::vector<char>& marks)
{
    return double(std::count(marks.begin(), marks.end(), 1)) / double(marks.size());
}

/// Fluxes of the surface, which sub-grid columns have at the floor.
void add_floor(const Simulation& sim, Profiles& to)
{
    to[SubgridThetaL][0] = sim.has(Quantity::Theta) ? sim.floor_flux(Quantity::Theta) : 0;
    to[SubgridQt][0] = sim.has(Quantity::Water) ? sim.floor_flux(Quantity::Water) : 0;
    to[SubgridUW][0] = sim.has(Quantity::U) ? sim.floor_flux(Quantity::U) : 0;
    to[SubgridVW][0] = sim.has(Quantity::V) ? sim.floor_flux(Quantity::V) : 0;
}

/// `air`: the part of each level's cells that hold air.
std::vector<double> series_of(const Simulation& sim, const Budget& b, const Profiles& at,
                              const std::vector<double>& air, const Covered& covered)
{
    const Parameters& p = sim.parameters();
    const auto path = [&](Profile column) {  // per area of floor
        double sum = 0;
        for (size_t k = 0; k < at[column].size(); ++k)
            if (air[k] > 0)
                sum += p.constants.rho0 * sim.column().rho_centre[k] * p.lattice.h[2] * air[k] * at[column][k];
        return sum;
    };
    const auto most = [&](Profile column) {
        double largest = 0;
        for (const double value : at[column]) largest = std::fmax(largest, value);
        return largest;
    };
    return {sim.time(),
            part_of(covered.cloud),
            part_of(covered.saturated),
            path(Ql),
            path(Qr),
            b.cloud_base,
            b.cloud_top,
            most(CloudFraction),
            b.w_max,
            most(W2),
            path(Tke),
            b.rain_fallen,
            at[SubgridThetaL][0],
            at[SubgridQt][0],
            std::sqrt(std::hypot(at[SubgridUW][0], at[SubgridVW][0]))};
}

template<typename V>
void put(std::string& to, const V& value)
{
    to.append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace

std::string StatisticsColumn::heading() const
{
    return *unit ? std::string(name) + "[" + unit + "]" : std::string(name);
}

const std::vector<StatisticsColumn>& profile_columns()
{
    static const std::vector<StatisticsColumn> list{
        {"theta_l", "K", "liquid water potential temperature"},
        {"q_t", "kg/kg", "total water without rain"},
        {"q_l", "kg/kg", "cloud water"},
        {"q_r", "kg/kg", "rain"},
        {"u", "m/s", "wind along x"},
        {"v", "m/s", "wind along y"},
        {"theta_v", "K", "virtual potential temperature"},
        {"cloud_fraction", "", "part of the cells with more than 1e-5 kg/kg of cloud water"},
        {"saturated_fraction", "", "part of the cells with any cloud water"},
        {"theta_l2", "K^2", "variance of theta_l"},
        {"q_t2", "kg^2/kg^2", "variance of q_t"},
        {"u2", "m^2/s^2", "variance of u"},
        {"v2", "m^2/s^2", "variance of v"},
        {"tke", "m^2/s^2", "resolved kinetic energy of turbulence"},
        {"w2", "m^2/s^2", "variance of w", true},
        {"w3", "m^3/s^3", "third moment of w", true},
        {"w_theta_l", "K m/s", "resolved flux of theta_l", true},
        {"w_q_t", "kg/kg m/s", "resolved flux of q_t", true},
        {"w_q_l", "kg/kg m/s", "resolved flux of q_l", true},
        {"w_theta_v", "K m/s", "resolved flux of theta_v", true},
        {"u_w", "m^2/s^2", "resolved flux of u", true},
        {"v_w", "m^2/s^2", "resolved flux of v", true},
        {"subgrid_w_theta_l", "K m/s", "sub-grid flux of theta_l; at the floor, of the surface", true},
        {"subgrid_w_q_t", "kg/kg m/s", "sub-grid flux of q_t", true},
        {"subgrid_u_w", "m^2/s^2", "sub-grid flux of u", true},
        {"subgrid_v_w", "m^2/s^2", "sub-grid flux of v", true}};
    return list;
}

const std::vector<StatisticsColumn>& series_columns()
{
    static const std::vector<StatisticsColumn> list{
        {"time", "s", "of the sample"},
        {"cloud_cover", "", "part of the columns that have cloud"},
        {"saturated_cover", "", "part of the columns that have any cloud water"},
        {"lwp", "kg/m^2", "cloud water above a square metre"},
        {"rwp", "kg/m^2", "rain above a square metre"},
        {"cloud_base", "m", "lowest centre of a cell with cloud; -1 without"},
        {"cloud_top", "m", "highest"},
        {"cloud_fraction_max", "", "largest cloud fraction of a level"},
        {"w_max", "m/s", "fastest updraught"},
        {"w2_max", "m^2/s^2", "largest variance of w of a level"},
        {"tke_path", "kg/s^2", "resolved kinetic energy of turbulence above a square metre"},
        {"rain_fallen", "kg/m^2", "on the floor since the start"},
        {"surface_theta_flux", "K m/s", "heat flux of the surface"},
        {"surface_q_flux", "kg/kg m/s", "water flux of the surface"},
        {"friction_velocity", "m/s", "root of the mean surface stress over the density"}};
    return list;
}

Sample take_sample(Simulation& sim, const Budget& budget)
{
    sim.derive();
    const int nz = sim.parameters().lattice.n[2], grain = plane_grain(nz);
    const size_t columns = size_t(sim.parameters().lattice.n[0]) * size_t(sim.parameters().lattice.n[1]);
    const Sampler sampler(sim);
    Profiles at(profile_columns().size(), std::vector<double>(size_t(nz), 0.0));
    std::vector<double> air(size_t(nz), 0.0);
    std::vector<Covered> part(size_t((nz + grain - 1) / grain), Covered(columns));
    for_chunks(nz, grain, [&](int begin, int end) {
        LevelPlanes below = begin > 0 ? sampler.planes(begin - 1) : LevelPlanes(), here;
        for (int k = begin; k < end; ++k) {
            here = sampler.planes(k);
            sampler.at_centres(size_t(k), here, at);
            air[size_t(k)] = std::accumulate(here.air.begin(), here.air.end(), 0.0) / double(columns);
            if (k > 0) sampler.at_faces(size_t(k), below, here, at);
            part[size_t(begin / grain)].add(here);
            std::swap(below, here);
        }
    });
    for (const Covered& other : part) part[0].add(other);
    const auto w2 = [&](size_t k) { return k < size_t(nz) && !std::isnan(at[W2][k]) ? at[W2][k] : 0; };  // 0: closed
    for (size_t k = 0; k < size_t(nz); ++k) at[Tke][k] = 0.5 * (at[U2][k] + at[V2][k] + 0.5 * (w2(k) + w2(k + 1)));
    add_floor(sim, at);
    std::vector<double> series = series_of(sim, budget, at, air, part[0]);
    return {std::move(at), std::move(series)};
}

bool ProfileMeans::add(double time, const Profiles& profiles)
{
    const double period = std::ceil(time / period_ - 1e-9);
    if (current_.samples == 0 || time > current_.start + period_ * (1 + 1e-9))
        current_ = {(period - 1) * period_, time, 0,
                    Profiles(profiles.size(), std::vector<double>(profiles[0].size()))};
    current_.end = time;
    ++current_.samples;
    for (size_t c = 0; c < profiles.size(); ++c)
        for (size_t k = 0; k < profiles[c].size(); ++k)
            current_.mean[c][k] += (profiles[c][k] - current_.mean[c][k]) / current_.samples;
    return time >= period * period_ * (1 - 1e-9);
}

std::string ProfileMeans::bytes() const
{
    std::string text;
    put(text, period_), put(text, current_.start), put(text, current_.end), put(text, current_.samples);
    for (const auto& column : current_.mean)
        for (const double value : column) put(text, value);
    return text;
}

void ProfileMeans::restore(const std::string& bytes, size_t levels)
{
    size_t at = 0;
    const auto take = [&](auto& value) {
        if (at + sizeof value > bytes.size()) throw InputError("statistics of another box");
        std::memcpy(&value, bytes.data() + at, sizeof value);
        at += sizeof value;
    };
    double period = 0;
    take(period);
    if (period != period_)
        throw InputError("profiles are averaged over " + std::to_string(period) + " s, expected " +
                         std::to_string(period_));
    take(current_.start), take(current_.end), take(current_.samples);
    current_.mean.assign(current_.samples > 0 ? profile_columns().size() : 0, std::vector<double>(levels));
    for (auto& column : current_.mean)
        for (double& value : column) take(value);
}

}  // namespace vdbcloud::sim
