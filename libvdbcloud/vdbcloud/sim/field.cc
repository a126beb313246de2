#include "vdbcloud/sim/field.h"

#include "vdbcloud/sim/parallel.h"

#include <cstring>

namespace vdbcloud::sim {

namespace {

struct Image {
    int index;
    int sign;  // -1: mirrored with the sign changed
};

/// The index within [0, n) whose value continues the field at `i`; `normal`: the field is the velocity along the axis.
Image image(int i, int n, Side side, bool normal)
{
    const auto wrapped = [](int a, int period) { return ((a % period) + period) % period; };
    switch (side) {
    case Side::Periodic: return {wrapped(i, n), 1};
    case Side::Open: return {std::clamp(i, 0, normal ? n : n - 1), 1};
    default: break;
    }
    const int m = wrapped(i, 2 * n);
    if (normal) return m <= n ? Image{m, 1} : Image{2 * n - m, -1};
    return m < n ? Image{m, 1} : Image{2 * n - 1 - m, 1};
}

/// Rows or planes: writes `count` values of `from` times the sign.
template<typename T>
void write(T* to, const T* from, size_t count, int sign)
{
    if (sign > 0)
        std::memcpy(to, from, count * sizeof(T));
    else if (sign < 0)
        for (size_t i = 0; i < count; ++i) to[i] = -from[i];
    else
        std::memset(to, 0, count * sizeof(T));
}

}  // namespace

template<typename T>
auto Continuation<T>::copies(int n, Side side, bool normal, int depth) -> std::vector<Copy>
{
    std::vector<Copy> list;
    if (n == 1) return list;
    const bool rigid = normal && side == Side::Wall;
    if (rigid) list = {{0, 0, 0}, {n, n, 0}};
    const int last = n + (normal && side == Side::Open);  // computed values
    for (int m = 1; m <= depth; ++m) {
        const Image below = image(-m, n, side, normal);
        list.push_back({-m, below.index, below.sign});
        const int to = n - 1 + m;
        if (to < last || (rigid && to == n)) continue;
        const Image above = image(to, n, side, normal);
        list.push_back({to, above.index, above.sign});
    }
    return list;
}

template<typename T>
Continuation<T>::Continuation(const Lattice& lattice, Place place, int depth)
    : lattice_(lattice), place_(place), x_(copies(lattice.n[0], lattice.side[0], place == Place::FaceX, depth)),
      y_(copies(lattice.n[1], lattice.side[1], place == Place::FaceY, depth)),
      z_(copies(lattice.n[2], Side::Wall, place == Place::FaceZ, depth))
{
}

template<typename T>
void Continuation<T>::row(T* row) const
{
    for (const Copy& c : x_) row[c.to] = c.sign == 0 ? T(0) : T(c.sign) * row[c.from];
}

template<typename T>
void Continuation<T>::plane(Field<T>& field, int k) const
{
    const int left = lattice_.flat(0) ? 0 : halo;
    const size_t width = size_t(lattice_.n[0] + 2 * left);
    for (const Copy& c : y_) write(field.row(c.to, k) - left, field.row(c.from, k) - left, width, c.sign);
}

template<typename T>
void Continuation<T>::rows(Field<T>& field, int k) const
{
    const int count = place_ == Place::FaceY ? lattice_.faces(1) : lattice_.n[1];
    for (int j = 0; j < count; ++j) row(field.row(j, k));
    plane(field, k);
}

template<typename T>
void Continuation<T>::ends(Field<T>& field, int k) const
{
    const auto [nx, ny, nz] = lattice_.n;
    const size_t bytes = size_t(nx) * sizeof(T);
    if (place_ == Place::FaceX && lattice_.side[0] != Side::Open)
        for (int j = 0; j < ny; ++j) {
            T* row = field.row(j, k);
            if (lattice_.side[0] == Side::Wall) row[0] = T(0);
            row[nx] = row[0];
        }
    if (place_ == Place::FaceY && lattice_.side[1] != Side::Open) {
        if (lattice_.side[1] == Side::Wall) std::memset(field.row(0, k), 0, bytes);
        std::memcpy(field.row(ny, k), field.row(0, k), bytes);
    }
    if (place_ != Place::FaceZ) return;
    for (int j = 0; j < ny; ++j) {
        if (k == 0) std::memset(field.row(j, 0), 0, bytes);
        if (k == nz - 1) std::memset(field.row(j, nz), 0, bytes);
    }
}

template<typename T>
void Continuation<T>::below_and_above(Field<T>& field) const
{
    const int left = lattice_.flat(0) ? 0 : halo, beside = lattice_.flat(1) ? 0 : halo;
    const size_t width = size_t(lattice_.n[0] + 2 * left);
    // The faces of floor and lid first: planes beyond them are images of others.
    for (const Copy& c : z_)
        if (c.sign == 0)
            for (int j = -beside; j < lattice_.n[1] + beside; ++j)
                write(field.row(j, c.to) - left, field.row(j, c.from) - left, width, 0);
    for_chunks(int(z_.size()), 2, [&](int begin, int end) {
        for (int m = begin; m < end; ++m) {
            const Copy& c = z_[size_t(m)];
            if (c.sign == 0) continue;
            for (int j = -beside; j < lattice_.n[1] + beside; ++j)
                write(field.row(j, c.to) - left, field.row(j, c.from) - left, width, c.sign);
        }
    });
}

template<typename T>
void fill_halo(const Lattice& lattice, Place place, Field<T>& field)
{
    const Continuation<T> beyond(lattice, place);
    for_chunks(lattice.n[2], plane_grain(lattice.n[2]), [&](int k0, int k1) {
        for (int k = k0; k < k1; ++k) beyond.rows(field, k);
    });
    beyond.below_and_above(field);
}

#define VDBCLOUD_FIELD(T)                                                                                              \
    template class Continuation<T>;                                                                                    \
    template void fill_halo(const Lattice&, Place, Field<T>&);
VDBCLOUD_FIELD(float)
VDBCLOUD_FIELD(double)
#undef VDBCLOUD_FIELD

}  // namespace vdbcloud::sim
