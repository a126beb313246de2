// Access to the state of a model, prescribed sources, and checkpoints.
#include "vdbcloud/core/error.h"
#include "vdbcloud/sim/combustion.h"
#include "vdbcloud/sim/model.h"

#include <algorithm>
#include <istream>
#include <ostream>

namespace vdbcloud::sim {

namespace {

template<typename V>
void put(std::ostream& out, const V& value)
{
    out.write(reinterpret_cast<const char*>(&value), sizeof(V));
}
template<typename V>
void take(std::istream& in, V& value)
{
    in.read(reinterpret_cast<char*>(&value), sizeof(V));
}

}  // namespace

template<typename T>
bool Model<T>::has(Quantity q) const
{
    return bool(air_.of(q));
}

template<typename T>
size_t Model<T>::bytes() const
{
    return air_.bytes() + drain_.bytes() + (pressure_ ? pressure_->bytes() : 0) +
           (obstacles_ ? obstacles_->bytes() : 0);
}

template<typename T>
void Model<T>::get_plane(Quantity q, int k, double* out) const
{
    const Field<T>& f = air_.of(q).a[0];
    const double shift = air_.reference(q);
    for (int j = 0; j < air_.lattice.n[1]; ++j)
        for (int i = 0; i < air_.lattice.n[0]; ++i) *out++ = f ? double(f(i, j, k)) + shift : shift;
}

template<typename T>
void Model<T>::get_air_plane(int k, double* out) const
{
    const size_t cells = size_t(air_.lattice.n[0]) * size_t(air_.lattice.n[1]), first = size_t(k) * cells;
    for (size_t c = 0; c < cells; ++c) out[c] = air_.bodies && air_.bodies.solid[first + c] ? 0 : 1;
}

template<typename T>
void Model<T>::get_cloud_plane(int k, double* out) const
{
    const int nx = air_.lattice.n[0];
    std::vector<T> row(size_t(nx), T(0));
    for (int j = 0; j < air_.lattice.n[1]; ++j) {
        if (air_.water)
            thermo_.cloud_row(column_.level[size_t(k)], air_.theta.a[0].row(j, k), air_.water.a[0].row(j, k),
                              row.data(), nx);
        for (int i = 0; i < nx; ++i) *out++ = double(row[size_t(i)]);
    }
}

template<typename T>
void Model<T>::get_flame_plane(int k, double* out) const
{
    const size_t nx = size_t(air_.lattice.n[0]);
    for (int j = 0; j < air_.lattice.n[1]; ++j, out += nx)
        air_.fuel ? flame_row(air_, j, k, out) : void(std::fill_n(out, nx, 0.0));
}

template<typename T>
void Model<T>::derive()
{
    for (const auto& prepare : air_.before_stage) prepare(0);
}

template<typename T>
void Model<T>::get_eddy_plane(int k, double* out) const
{
    for (int j = 0; j < air_.lattice.n[1]; ++j)
        for (int i = 0; i < air_.lattice.n[0]; ++i)
            *out++ = air_.eddy_viscosity ? double((*air_.eddy_viscosity)(i, j, k)) : 0;
}

template<typename T>
double Model<T>::floor_flux(Quantity q) const
{
    const Variable<T>& v = air_.of(q);
    const int width = air_.lattice.n[0];
    std::vector<T> rate(static_cast<size_t>(air_.width(v)));
    double sum = 0;
    for (int j = 0; j < air_.lattice.n[1]; ++j) {
        std::fill(rate.begin(), rate.end(), T(0));
        for (const auto& term : v.floor) term(0, j, 0, rate.data());
        for (int i = 0; i < width; ++i) sum += double(rate[size_t(i)]);
    }
    return sum / (double(width) * air_.lattice.n[1]) * air_.lattice.h[2] * air_.rho.centre[0];
}

template<typename T>
void Model<T>::add_source(Quantity q, Source rate)
{
    Variable<T>& v = air_.of(q);
    if (!v) throw InputError("source: this run has no field for its quantity");
    const auto place = [&](Place face) { return v.place == face ? 0.0 : 0.5; };
    const double sx = place(Place::FaceX), sy = place(Place::FaceY), sz = place(Place::FaceZ);
    v.terms.push_back([this, sx, sy, sz, width = air_.width(v), rate = std::move(rate)](int, int j, int k, T* out) {
        const auto [dx, dy, dz] = air_.lattice.h;
        for (int i = 0; i < width; ++i) out[i] += T(rate((i + sx) * dx, (j + sy) * dy, (k + sz) * dz, air_.stage_time));
    });
    if (v.place == Place::Centre) v.row_source.assign(size_t(air_.lattice.n[1]) * size_t(air_.lattice.n[2]), 0.0);
}

template<typename T>
void Model<T>::save(std::ostream& out) const
{
    put(out, air_.time), put(out, air_.dt), put(out, rate_), put(out, steps_), put(out, retries_),
        put(out, air_.rain_fallen), put(out, water_corrected_);
    for (const Variable<T>* v :
         {&air_.wind[0], &air_.wind[1], &air_.wind[2], &air_.theta, &air_.water, &air_.rain, &air_.dye, &air_.fuel}) {
        put(out, v->sources), put(out, v->turnover), put(out, v->start);
        if (!*v) continue;
        const int width = air_.width(*v), rows = air_.rows(*v);
        for (int k = 0; k < air_.lattice.n[2]; ++k)
            for (int j = 0; j < rows; ++j)
                out.write(reinterpret_cast<const char*>(v->a[0].row(j, k)), std::streamsize(sizeof(T)) * width);
    }
}

template<typename T>
void Model<T>::restore(std::istream& in)
{
    take(in, air_.time), take(in, air_.dt), take(in, rate_), take(in, steps_), take(in, retries_),
        take(in, air_.rain_fallen), take(in, water_corrected_);
    for (Variable<T>* v :
         {&air_.wind[0], &air_.wind[1], &air_.wind[2], &air_.theta, &air_.water, &air_.rain, &air_.dye, &air_.fuel}) {
        take(in, v->sources), take(in, v->turnover), take(in, v->start);
        if (!*v) continue;
        const int width = air_.width(*v), rows = air_.rows(*v);
        for (int k = 0; k < air_.lattice.n[2]; ++k)
            for (int j = 0; j < rows; ++j)
                in.read(reinterpret_cast<char*>(v->a[0].row(j, k)), std::streamsize(sizeof(T)) * width);
    }
    if (!in) throw InputError("checkpoint: the file ends too early");
    finish_state(0);
    find_flux(0);
    take_courant(0);
    started_ = true;
}

#define VDBCLOUD_STATE(T)                                                                                              \
    template bool Model<T>::has(Quantity) const;                                                                       \
    template size_t Model<T>::bytes() const;                                                                           \
    template void Model<T>::get_plane(Quantity, int, double*) const;                                                   \
    template void Model<T>::get_air_plane(int, double*) const;                                                         \
    template void Model<T>::get_cloud_plane(int, double*) const;                                                       \
    template void Model<T>::get_flame_plane(int, double*) const;                                                       \
    template void Model<T>::derive();                                                                                  \
    template void Model<T>::get_eddy_plane(int, double*) const;                                                        \
    template double Model<T>::floor_flux(Quantity) const;                                                              \
    template void Model<T>::add_source(Quantity, Source);                                                              \
    template void Model<T>::save(std::ostream&) const;                                                                 \
    template void Model<T>::restore(std::istream&);
VDBCLOUD_STATE(float)
VDBCLOUD_STATE(double)
#undef VDBCLOUD_STATE

}  // namespace vdbcloud::sim
