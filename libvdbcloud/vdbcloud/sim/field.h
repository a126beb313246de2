#pragma once
// The box of the simulation and padded arrays of its cells.
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace vdbcloud::sim {

/// Boundary condition of the four sides. Floor and lid are rigid and free of stress.
enum class Side {
    Periodic,  ///< the opposite side
    Wall,      ///< rigid, free of stress, no flux
    Open,      ///< pressure of the environment; what flows in is the environment's air
};

/// A box of cells, x fastest, z up, with uniform spacing an axis. Staggered (Arakawa C): scalars at centres, u, v, w on
/// the lower x, y, z faces of the cell of the same index.
struct Lattice {
    std::array<int, 3> n{1, 1, 1};                             ///< cells
    std::array<double, 3> h{1, 1, 1};                          ///< spacing [m]
    std::array<Side, 2> side{Side::Periodic, Side::Periodic};  ///< of the x and y axes

    /// An axis of one cell has no direction: no velocity along it and no fluxes.
    bool flat(int axis) const { return n[size_t(axis)] == 1; }
    size_t cells() const { return size_t(n[0]) * size_t(n[1]) * size_t(n[2]); }
    /// Faces normal to `axis` whose velocity is computed: one more than cells only where both ends are open.
    int faces(int axis) const
    {
        return n[size_t(axis)] + (axis < 2 && side[size_t(axis)] == Side::Open && !flat(axis));
    }
};

/// Cells beyond each end of an axis: the widest stencil reads 3, and one more past the last face of an open side.
inline constexpr int halo = 4;

/// A scalar on a lattice with `halo` more values on every side (none along a flat axis), zero at first. Rows along x
/// are contiguous and begin at 32 bytes. An empty field, as a default one is, has no memory.
template<typename T>
class Field {
public:
    Field() = default;
    explicit Field(const Lattice& lattice)
    {
        const auto pad = [&](int axis) { return lattice.flat(axis) ? 0 : halo; };
        const ptrdiff_t left = lattice.flat(0) ? 0 : 8;
        sy_ = (left + lattice.n[0] + pad(0) + 7) / 8 * 8;
        sz_ = sy_ * (lattice.n[1] + 2 * pad(1));
        size_ = size_t(sz_) * size_t(lattice.n[2] + 2 * pad(2));
        data_.reset(static_cast<T*>(::operator new(size_ * sizeof(T), std::align_val_t(64))));
        for (size_t i = 0; i < size_; ++i) data_.get()[i] = T(0);
        origin_ = data_.get() + left + sy_ * pad(1) + sz_ * pad(2);
    }
    Field(Field&& other) noexcept { swap(other); }
    Field& operator=(Field&& other) noexcept
    {
        swap(other);
        return *this;
    }

    explicit operator bool() const { return data_ != nullptr; }
    /// The row of cells (., j, k), at i = 0.
    T* row(int j, int k) { return origin_ + sy_ * j + sz_ * k; }
    const T* row(int j, int k) const { return origin_ + sy_ * j + sz_ * k; }
    T& operator()(int i, int j, int k) { return row(j, k)[i]; }
    T operator()(int i, int j, int k) const { return row(j, k)[i]; }
    ptrdiff_t stride(int axis) const { return axis == 0 ? 1 : axis == 1 ? sy_ : sz_; }
    size_t bytes() const { return size_ * sizeof(T); }

    void swap(Field& other) noexcept
    {
        std::swap(data_, other.data_), std::swap(origin_, other.origin_), std::swap(size_, other.size_);
        std::swap(sy_, other.sy_), std::swap(sz_, other.sz_);
    }

private:
    struct Free {
        void operator()(T* p) const { ::operator delete(p, std::align_val_t(64)); }
    };
    std::unique_ptr<T, Free> data_;
    T* origin_ = nullptr;
    size_t size_ = 0;
    ptrdiff_t sy_ = 0, sz_ = 0;
};

/// Where the values of a field lie in their cells, and so how the field continues beyond the box.
enum class Place { Centre, FaceX, FaceY, FaceZ };

/// How a field continues beyond the box: periodic copies; at walls, floor and lid mirror images, with the sign changed
/// for the velocity through them, which is itself set to 0; at open sides the nearest value. Kernels that have just
/// written a row or a plane continue it while it is in cache.
template<typename T>
class Continuation {
public:
    /// Fills the `depth` values beyond each end; up to `halo`.
    Continuation(const Lattice&, Place, int depth = halo);

    /// Beyond both ends of a row.
    void row(T*) const;
    /// Beyond both ends of plane k along y, once its rows are complete.
    void plane(Field<T>&, int k) const;
    /// The same, and before it beyond the ends of each row of the plane.
    void rows(Field<T>&, int k) const;
    /// Of a velocity, the faces of plane k at the ends of its axis that are not computed: at the upper end of a
    /// periodic axis the first face, at walls, floor and lid 0.
    void ends(Field<T>&, int k) const;
    /// Below the floor and above the lid, once all planes are complete. Parallel.
    void below_and_above(Field<T>&) const;

private:
    struct Copy {
        int to, from, sign;  // sign -1: mirrored with the sign changed; 0: set to 0
    };
    /// Along an axis of n cells; the velocity through its ends if `normal`.
    static std::vector<Copy> copies(int n, Side, bool normal, int depth);

    Lattice lattice_;
    Place place_;
    std::vector<Copy> x_, y_, z_;  // of values in a row, of rows and of planes
};

/// Fills the whole halo. Parallel over planes.
template<typename T>
void fill_halo(const Lattice&, Place, Field<T>&);

extern template class Continuation<float>;
extern template class Continuation<double>;
extern template void fill_halo(const Lattice&, Place, Field<float>&);
extern template void fill_halo(const Lattice&, Place, Field<double>&);

}  // namespace vdbcloud::sim
