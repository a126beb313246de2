// What goes in and out of a model, and its accounts.
#include "vdbcloud/core/error.h"
#include "vdbcloud/sim/model.h"

#include <cmath>
#include <istream>
#include <ostream>
#include <sstream>

namespace vdbcloud::sim {

namespace {

template<typename V> void put(std::ostream& out, const V& value)
{
    out.write(reinterpret_cast<const char*>(&value), sizeof(V));
}
template<typename V> void take(std::istream& in, V& value) { in.read(reinterpret_cast<char*>(&value), sizeof(V)); }

struct Extent {
    double sum = 0, low = never, high = -never;
    bool bad = false;
};

}  // namespace

template<typename T> bool Model<T>::has(Quantity q) const { return bool(of(q)); }

template<typename T> size_t Model<T>::bytes() const
{
    size_t sum = drain_.bytes() + eddy_.bytes() + heating_.bytes() + (pressure_ ? pressure_->bytes() : 0);
    for (const Variable<T>* v : {&wind_[0], &wind_[1], &wind_[2], &theta_, &water_, &rain_, &dye_})
        for (const Field<T>& f : v->a) sum += f.bytes();
    return sum;
}

template<typename T> void Model<T>::get_plane(Quantity q, int k, double* out) const
{
    const Field<T>& f = of(q).a[0];
    const double shift = q == Quantity::Theta ? parameters_.constants.theta0 : 0;
    for (int j = 0; j < lattice_.n[1]; ++j)
        for (int i = 0; i < lattice_.n[0]; ++i) *out++ = f ? double(f(i, j, k)) + shift : shift;
}

template<typename T> void Model<T>::get_cloud_plane(int k, double* out) const
{
    const int nx = lattice_.n[0];
    std::vector<T> row(size_t(nx), T(0));
    for (int j = 0; j < lattice_.n[1]; ++j) {
        if (water_)
            thermo_.cloud_row(column_.level[size_t(k)], theta_.a[0].row(j, k), water_.a[0].row(j, k), row.data(), nx);
        for (int i = 0; i < nx; ++i) *out++ = double(row[size_t(i)]);
    }
}

template<typename T> void Model<T>::set(Quantity q, const std::vector<double>& values)
{
    Variable<T>& v = of(q);
    if (!v) throw InputError("initial state: this run has no field for a quantity that is given");
    if (values.size() != lattice_.cells())
        throw InputError("initial state: " + std::to_string(values.size()) + " values, expected one a cell");
    const double shift = q == Quantity::Theta ? parameters_.constants.theta0 : 0;
    size_t c = 0;
    for (int k = 0; k < lattice_.n[2]; ++k)
        for (int j = 0; j < lattice_.n[1]; ++j)
            for (int i = 0; i < lattice_.n[0]; ++i) {
                const double value = values[c++];
                if (!std::isfinite(value)) {
                    std::ostringstream text;
                    text << "initial state: value " << value << " at cell [" << i << ", " << j << ", " << k
                         << "]: expected a finite number";
                    throw InputError(text.str());
                }
                v.a[0](i, j, k) = T(value - shift);
            }
    started_ = false;
}

template<typename T> Budget Model<T>::budget() const
{
    const auto [nx, ny, nz] = lattice_.n;
    Budget b;
    b.time = time_, b.steps = steps_, b.retries = retries_, b.dt = dt_, b.rain_fallen = rain_fallen_;
    double mass = 0;
    for (int k = 0; k < nz; ++k) mass += rho_.centre[size_t(k)] * nx * ny;
    const auto extent = [&, nx = nx, ny = ny](const Variable<T>& v) {
        return reduce_planes(nz, Extent{}, [&](int k) {
            Extent e;
            for (int j = 0; j < ny; ++j) {
                const T* row = v.a[0].row(j, k);
                double sum = 0;
                for (int i = 0; i < nx; ++i) {
                    sum += double(row[i]);
                    e.low = std::min(e.low, double(row[i])), e.high = std::max(e.high, double(row[i]));
                }
                e.sum += sum * rho_.centre[size_t(k)];
            }
            e.bad = !std::isfinite(e.sum);
            return e;
        }, [](const Extent& a, const Extent& c) {
            return Extent{a.sum + c.sum, std::min(a.low, c.low), std::max(a.high, c.high), a.bad || c.bad};
        });
    };
    double grown = 0;
    bool sourced = false;
    const double theta0 = parameters_.constants.theta0;
    const auto account = [&](const Variable<T>& v, double shift, double& mean, double& drift, double& low, double& high,
                             bool relative_to_range) {
        const Extent e = extent(v);
        if (e.bad) name_bad_cell();
        mean = e.sum / mass + shift, low = e.low + shift, high = e.high + shift;
        if (!started_) return;
        const double range = v.high - v.low;
        // Relative to what is there or came in; a range that is small beside the values cannot be resolved better than these.
        const double size = std::max(std::abs(e.low), std::abs(e.high)), gained = std::abs(v.sources / mass);
        const double unit = relative_to_range ? std::max({range, high - low, gained, 0.05 * size, 1e-3})
                                              : std::max({v.start, gained, 1e-12});
        drift = (e.sum / mass - v.start - v.sources / mass) / unit;  // without the shift, which would only round
        sourced = sourced || !v.row_source.empty();
        grown = std::max(grown, std::max(high - v.high, v.low - low) / std::max(range, relative_to_range ? 1e-3 : 1e-9));
    };
    if (theta_) account(theta_, theta0, b.theta_mean, b.theta_drift, b.theta_min, b.theta_max, true);
    if (water_) account(water_, 0, b.water_mean, b.water_drift, b.water_min, b.water_max, false);
    b.new_extrema = sourced || parameters_.rain ? -1 : std::max(0.0, grown);

    // Air and cloud.
    std::vector<double> speed(static_cast<size_t>(nz), 0.0), rise = speed, energy = speed, most = speed, sum = speed;
    for_blocks(nz, plane_grain(nz), [&, nx = nx, ny = ny](int k0, int k1) {
        std::vector<T> cloud(size_t(nx), T(0));
        for (int k = k0; k < k1; ++k)
            for (int j = 0; j < ny; ++j) {
                for (int c = 0; c < 3; ++c) {
                    if (!wind_[size_t(c)]) continue;
                    const T* row = wind_[size_t(c)].a[0].row(j, k);
                    double fast = 0, squares = 0;
                    for (int i = 0; i < nx; ++i) {
                        fast = std::max(fast, std::abs(double(row[i])));
                        squares += double(row[i]) * double(row[i]);
                    }
                    speed[size_t(k)] = std::max(speed[size_t(k)], fast);
                    if (c == 2)
                        for (int i = 0; i < nx; ++i) rise[size_t(k)] = std::max(rise[size_t(k)], double(row[i]));
                    energy[size_t(k)] += 0.5 * squares;
                }
                if (!water_) continue;
                thermo_.cloud_row(column_.level[size_t(k)], theta_.a[0].row(j, k), water_.a[0].row(j, k), cloud.data(), nx);
                for (int i = 0; i < nx; ++i) {
                    most[size_t(k)] = std::max(most[size_t(k)], double(cloud[size_t(i)]));
                    sum[size_t(k)] += double(cloud[size_t(i)]);
                }
            }
    });
    for (int k = 0; k < nz; ++k) {
        b.speed_max = std::max(b.speed_max, speed[size_t(k)]), b.w_max = std::max(b.w_max, rise[size_t(k)]);
        b.kinetic += energy[size_t(k)] * rho_.centre[size_t(k)] / mass;
        b.cloud_max = std::max(b.cloud_max, most[size_t(k)]), b.cloud_mean += sum[size_t(k)] * rho_.centre[size_t(k)] / mass;
        if (most[size_t(k)] <= 1e-5) continue;
        b.cloud_top = column_.level[size_t(k)].z;
        if (b.cloud_base < 0) b.cloud_base = b.cloud_top;
    }
    b.courant = dt_ * rate_;
    if (pressure_) {
        double h = never;
        for (const int d : {0, 1, 2})
            if (!lattice_.flat(d)) h = std::min(h, lattice_.h[size_t(d)]);
        double windiest = 0;  // what relaxation may push against walls, for the pressure to take away again
        for (int k = 0; k < nz; ++k)
            windiest = std::max({windiest, std::abs(column_.u[size_t(k)]), std::abs(column_.v[size_t(k)])});
        b.divergence = pressure_->max_divergence(wind_[0].a[0], wind_[1].a[0], wind_[2].a[0]) * h /
                       std::max({b.speed_max, windiest, 0.1});  // air at rest has round-off only
    }

    // Tolerances: of single precision they grow with the steps taken, of double they are round-off.
    const bool single = sizeof(T) == 4;
    const double thousands = std::max(1.0, double(steps_) / 1000);
    const double drift = single ? std::max(2e-5, 2e-6 * thousands) : 1e-12 * std::max(1.0, thousands);
    // The pressure is as large as the longest side, its difference as small as a spacing: that many ulps are lost.
    double longest = 0, shortest = never;
    for (const size_t d : {0, 1, 2}) {
        longest = std::max(longest, lattice_.n[d] * lattice_.h[d]);
        if (!lattice_.flat(int(d))) shortest = std::min(shortest, lattice_.h[d]);
    }
    const double still = std::max(single ? 1e-5 : 1e-12, (single ? 1.2e-7 : 2.3e-16) * longest / shortest);
    std::ostringstream fault;
    if (started_ && parameters_.time_scheme != TimeScheme::HugeStep) {
        if (std::abs(b.water_drift) > drift) fault << "drift of total water " << b.water_drift << ", tolerance " << drift;
        else if (std::abs(b.theta_drift) > drift) fault << "drift of theta_l " << b.theta_drift << ", tolerance " << drift;
        else if (b.divergence > still) fault << "divergence " << b.divergence;
        else if (b.water_min < 0) fault << "total water " << b.water_min << " kg/kg, below 0";
    }
    b.fault = fault.str();
    return b;
}

template<typename T> void Model<T>::save(std::ostream& out) const
{
    put(out, time_), put(out, dt_), put(out, rate_), put(out, steps_), put(out, retries_), put(out, rain_fallen_);
    for (const Variable<T>* v : {&wind_[0], &wind_[1], &wind_[2], &theta_, &water_, &rain_, &dye_}) {
        put(out, v->sources), put(out, v->start), put(out, v->low), put(out, v->high);
        if (!*v) continue;
        const int width = v->place == Place::FaceX ? lattice_.faces(0) : lattice_.n[0];
        const int rows = v->place == Place::FaceY ? lattice_.faces(1) : lattice_.n[1];
        for (int k = 0; k < lattice_.n[2]; ++k)
            for (int j = 0; j < rows; ++j)
                out.write(reinterpret_cast<const char*>(v->a[0].row(j, k)), std::streamsize(sizeof(T)) * width);
    }
}

template<typename T> void Model<T>::restore(std::istream& in)
{
    take(in, time_), take(in, dt_), take(in, rate_), take(in, steps_), take(in, retries_), take(in, rain_fallen_);
    for (Variable<T>* v : {&wind_[0], &wind_[1], &wind_[2], &theta_, &water_, &rain_, &dye_}) {
        take(in, v->sources), take(in, v->start), take(in, v->low), take(in, v->high);
        if (!*v) continue;
        const int width = v->place == Place::FaceX ? lattice_.faces(0) : lattice_.n[0];
        const int rows = v->place == Place::FaceY ? lattice_.faces(1) : lattice_.n[1];
        for (int k = 0; k < lattice_.n[2]; ++k)
            for (int j = 0; j < rows; ++j)
                in.read(reinterpret_cast<char*>(v->a[0].row(j, k)), std::streamsize(sizeof(T)) * width);
    }
    if (!in) throw InputError("checkpoint: it ends too early");
    finish_state(0);
    take_courant(0);
    started_ = true;
}

#define VDBCLOUD_STATE(T)                                                                                             \
    template bool Model<T>::has(Quantity) const;                                                                      \
    template size_t Model<T>::bytes() const;                                                                          \
    template void Model<T>::get_plane(Quantity, int, double*) const;                                                   \
    template void Model<T>::get_cloud_plane(int, double*) const;                                                       \
    template void Model<T>::set(Quantity, const std::vector<double>&);                                                \
    template Budget Model<T>::budget() const;                                                                         \
    template void Model<T>::save(std::ostream&) const;                                                                \
    template void Model<T>::restore(std::istream&);
VDBCLOUD_STATE(float)
VDBCLOUD_STATE(double)
#undef VDBCLOUD_STATE

}  // namespace vdbcloud::sim
