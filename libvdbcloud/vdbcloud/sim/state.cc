// What comes out of a model, and checkpoints.
#include "vdbcloud/core/error.h"
#include "vdbcloud/sim/model.h"

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
    return bool(of(q));
}

template<typename T>
size_t Model<T>::bytes() const
{
    size_t sum = drain_.bytes() + eddy_.bytes() + heating_.bytes() + (pressure_ ? pressure_->bytes() : 0);
    for (const Variable<T>* v : {&wind_[0], &wind_[1], &wind_[2], &theta_, &water_, &rain_, &dye_})
        for (const Field<T>& f : v->a) sum += f.bytes();
    return sum;
}

template<typename T>
void Model<T>::get_plane(Quantity q, int k, double* out) const
{
    const Field<T>& f = of(q).a[0];
    const double shift = reference(q);
    for (int j = 0; j < lattice_.n[1]; ++j)
        for (int i = 0; i < lattice_.n[0]; ++i) *out++ = f ? double(f(i, j, k)) + shift : shift;
}

template<typename T>
void Model<T>::get_cloud_plane(int k, double* out) const
{
    const int nx = lattice_.n[0];
    std::vector<T> row(size_t(nx), T(0));
    for (int j = 0; j < lattice_.n[1]; ++j) {
        if (water_)
            thermo_.cloud_row(column_.level[size_t(k)], theta_.a[0].row(j, k), water_.a[0].row(j, k), row.data(), nx);
        for (int i = 0; i < nx; ++i) *out++ = double(row[size_t(i)]);
    }
}

template<typename T>
void Model<T>::save(std::ostream& out) const
{
    put(out, time_), put(out, dt_), put(out, rate_), put(out, steps_), put(out, retries_), put(out, rain_fallen_),
        put(out, water_corrected_);
    for (const Variable<T>* v : {&wind_[0], &wind_[1], &wind_[2], &theta_, &water_, &rain_, &dye_}) {
        put(out, v->sources), put(out, v->start);
        if (!*v) continue;
        const int width = v->place == Place::FaceX ? lattice_.faces(0) : lattice_.n[0];
        const int rows = v->place == Place::FaceY ? lattice_.faces(1) : lattice_.n[1];
        for (int k = 0; k < lattice_.n[2]; ++k)
            for (int j = 0; j < rows; ++j)
                out.write(reinterpret_cast<const char*>(v->a[0].row(j, k)), std::streamsize(sizeof(T)) * width);
    }
}

template<typename T>
void Model<T>::restore(std::istream& in)
{
    take(in, time_), take(in, dt_), take(in, rate_), take(in, steps_), take(in, retries_), take(in, rain_fallen_),
        take(in, water_corrected_);
    for (Variable<T>* v : {&wind_[0], &wind_[1], &wind_[2], &theta_, &water_, &rain_, &dye_}) {
        take(in, v->sources), take(in, v->start);
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

#define VDBCLOUD_STATE(T)                                                                                              \
    template bool Model<T>::has(Quantity) const;                                                                       \
    template size_t Model<T>::bytes() const;                                                                           \
    template void Model<T>::get_plane(Quantity, int, double*) const;                                                   \
    template void Model<T>::get_cloud_plane(int, double*) const;                                                       \
    template void Model<T>::save(std::ostream&) const;                                                                 \
    template void Model<T>::restore(std::istream&);
VDBCLOUD_STATE(float)
VDBCLOUD_STATE(double)
#undef VDBCLOUD_STATE

}  // namespace vdbcloud::sim
