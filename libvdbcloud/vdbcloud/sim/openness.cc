#include "vdbcloud/sim/openness.h"

#include "vdbcloud/sim/parallel.h"

#include <cmath>
#include <limits>

namespace vdbcloud::sim {

namespace {

/// Area where a function, linear along the edges of a unit square, is above 0. `f`: of the corners in order around it.
double open_area(const std::array<double, 4>& f)
{
    constexpr double x[] = {0, 1, 1, 0}, y[] = {0, 0, 1, 1};
    double px[8], py[8];
    size_t n = 0;
    for (size_t a = 0; a < 4; ++a) {
        const size_t b = (a + 1) % 4;
        if (f[a] > 0) px[n] = x[a], py[n++] = y[a];
        if ((f[a] > 0) == (f[b] > 0)) continue;
        const double s = f[a] / (f[a] - f[b]);
        px[n] = x[a] + s * (x[b] - x[a]), py[n++] = y[a] + s * (y[b] - y[a]);
    }
    double twice = 0;
    for (size_t a = 0; a < n; ++a) {
        const size_t b = (a + 1) % n;
        twice += px[a] * py[b] - px[b] * py[a];
    }
    // Slits are closed: what blows through them is no part of the flow that cells resolve, and would be fast.
    constexpr double slit = 0.1;
    const double area = 0.5 * twice;
    return area < slit ? 0 : area > 1 - 1e-6 ? 1 : area;
}

/// Distances at the corners of cells, two planes at a time.
class Corners {
public:
    explicit Corners(const Parameters& p) : p_(p), nx_(p.lattice.n[0] + 1), ny_(p.lattice.n[1] + 1) {}

    std::vector<double> plane(int k) const
    {
        const Lattice& l = p_.lattice;
        std::vector<double> f(size_t(nx_) * size_t(ny_), std::numeric_limits<double>::infinity());
        // A slice is cut through the middle of its one cell.
        const auto at = [&](int axis, int i) { return (l.flat(axis) ? 0.5 : i) * l.h[size_t(axis)]; };
        for_chunks(ny_, 8, [&](int j0, int j1) {
            for (int j = j0; j < j1; ++j)
                for (int i = 0; i < nx_; ++i)
                    for (const auto& shape : p_.colliders) {
                        double& value = f[size_t(j) * size_t(nx_) + size_t(i)];
                        value = std::min(value, shape->distance({at(0, i), at(1, j), k * l.h[2]}));
                    }
        });
        return f;
    }
    size_t index(int i, int j) const { return size_t(j) * size_t(nx_) + size_t(i); }

private:
    const Parameters& p_;
    int nx_, ny_;
};

}  // namespace

template<typename T>
Openness<T>::Openness(const Parameters& p)
{
    const Lattice& l = p.lattice;
    const auto [nx, ny, nz] = l.n;
    for (const size_t axis : {0, 1, 2})
        if (!l.flat(int(axis))) face[axis] = Field<T>(l), flux[axis] = Field<T>(l);
    const Corners corners(p);
    std::vector<double> low = corners.plane(0), high;
    for (int k = 0; k < nz; ++k, low.swap(high)) {
        high = corners.plane(k + 1);
        const auto lo = [&](int i, int j) { return low[corners.index(i, j)]; };
        const auto hi = [&](int i, int j) { return high[corners.index(i, j)]; };
        for (int j = 0; j <= ny; ++j)
            for (int i = 0; i <= nx; ++i) {
                if (k > 0 && i < nx && j < ny)
                    face[2](i, j, k) = T(open_area({lo(i, j), lo(i + 1, j), lo(i + 1, j + 1), lo(i, j + 1)}));
                if (face[0] && j < ny)
                    face[0](i, j, k) = T(open_area({lo(i, j), lo(i, j + 1), hi(i, j + 1), hi(i, j)}));
                if (face[1] && i < nx)
                    face[1](i, j, k) = T(open_area({lo(i, j), lo(i + 1, j), hi(i + 1, j), hi(i, j)}));
            }
        // The last face of a periodic axis is the first; walls are closed.
        for (int j = 0; face[0] && j < ny; ++j) {
            if (l.side[0] == Side::Wall) face[0](0, j, k) = face[0](nx, j, k) = T(0);
            if (l.side[0] == Side::Periodic) face[0](nx, j, k) = face[0](0, j, k);
        }
        for (int i = 0; face[1] && i < nx; ++i) {
            if (l.side[1] == Side::Wall) face[1](i, 0, k) = face[1](i, ny, k) = T(0);
            if (l.side[1] == Side::Periodic) face[1](i, ny, k) = face[1](i, 0, k);
        }
    }
    solid.resize(l.cells());
    ground.assign(size_t(nx) * size_t(ny), nz);
    size_t c = 0;
    for (int k = 0; k < nz; ++k)
        for (int j = 0; j < ny; ++j)
            for (int i = 0; i < nx; ++i, ++c) {
                T sum = face[2](i, j, k) + (k + 1 < nz ? face[2](i, j, k + 1) : T(0));
                if (face[0]) sum += face[0](i, j, k) + face[0](i + 1, j, k);
                if (face[1]) sum += face[1](i, j, k) + face[1](i, j + 1, k);
                solid[c] = !(sum > T(0));
                int& lowest = ground[size_t(j) * size_t(nx) + size_t(i)];
                if (!solid[c]) lowest = std::min(lowest, k);
            }
}

template<typename T>
size_t Openness<T>::bytes() const
{
    size_t sum = 0;
    for (const size_t axis : {0, 1, 2}) sum += face[axis].bytes() + flux[axis].bytes();
    return sum;
}

template struct Openness<float>;
template struct Openness<double>;

}  // namespace vdbcloud::sim
