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

template<typename T>
void fill_rows_x(const Lattice& lattice, bool normal, T* row)
{
    const int n = lattice.n[0];
    const Side side = lattice.side[0];
    if (normal && side == Side::Wall) row[0] = row[n] = T(0);
    const int last = n + (normal && side == Side::Open);
    for (int m = 1; m <= halo; ++m) {
        const Image a = image(-m, n, side, normal);
        row[-m] = T(a.sign) * row[a.index];
        if (n - 1 + m < last || (normal && side == Side::Wall && m == 1)) continue;
        const Image b = image(n - 1 + m, n, side, normal);
        row[n - 1 + m] = T(b.sign) * row[b.index];
    }
}

/// Rows or planes: copies `count` values from `from`, changing the sign if asked.
template<typename T>
void copy(T* to, const T* from, size_t count, int sign)
{
    if (sign > 0)
        std::memcpy(to, from, count * sizeof(T));
    else
        for (size_t i = 0; i < count; ++i) to[i] = -from[i];
}

}  // namespace

template<typename T>
void fill_halo(const Lattice& lattice, Place place, Field<T>& field)
{
    const auto [nx, ny, nz] = lattice.n;
    const int left = lattice.flat(0) ? 0 : halo;
    const size_t width = size_t(nx + 2 * left), row_bytes = size_t(field.stride(1)) * sizeof(T);
    const int rows = lattice.faces(1) * (place == Place::FaceY) + ny * (place != Place::FaceY);

    for_chunks(nz, plane_grain(nz), [&, ny = ny](int k0, int k1) {
        for (int k = k0; k < k1; ++k) {
            if (!lattice.flat(0))
                for (int j = 0; j < rows; ++j) fill_rows_x(lattice, place == Place::FaceX, field.row(j, k));
            if (lattice.flat(1)) continue;
            const bool normal = place == Place::FaceY;
            const Side side = lattice.side[1];
            if (normal && side == Side::Wall) {
                std::memset(field.row(0, k) - left, 0, width * sizeof(T));
                std::memset(field.row(ny, k) - left, 0, width * sizeof(T));
            }
            for (int m = 1; m <= halo; ++m) {
                const Image a = image(-m, ny, side, normal);
                copy(field.row(-m, k) - left, field.row(a.index, k) - left, width, a.sign);
                if (ny - 1 + m < rows || (normal && side == Side::Wall && m == 1)) continue;
                const Image b = image(ny - 1 + m, ny, side, normal);
                copy(field.row(ny - 1 + m, k) - left, field.row(b.index, k) - left, width, b.sign);
            }
        }
    });
    if (lattice.flat(2)) return;
    const bool normal = place == Place::FaceZ;
    const int below = lattice.flat(1) ? 0 : halo;
    const size_t plane = size_t(ny + 2 * below) * row_bytes / sizeof(T);
    const ptrdiff_t start = field.stride(1) * -below - left;
    if (normal)
        for (const int k : {0, int(nz)})
            for (int j = -below; j < ny + below; ++j) std::memset(field.row(j, k) - left, 0, width * sizeof(T));
    for (int m = 1; m <= halo; ++m)
        for (const int k : {-m, int(nz) - 1 + m}) {
            if (normal && k == nz) continue;
            const Image a = image(k, nz, Side::Wall, normal);
            copy(field.row(0, k) + start, field.row(0, a.index) + start, plane - (lattice.flat(0) ? 0 : 8 - halo),
                 a.sign);
        }
}

template void fill_halo(const Lattice&, Place, Field<float>&);
template void fill_halo(const Lattice&, Place, Field<double>&);

}  // namespace vdbcloud::sim
