// Transforms of planes: they diagonalise the second difference with its boundary, for every pair of ends.
#include "vdbcloud/fft/batched_transform.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/random.h"
#include "vdbcloud/fft/planner.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <new>
#include <vector>

namespace vdbcloud::fft {
namespace {

template<typename Real>
struct Plane {
    explicit Plane(const BatchedTransform<Real>& of)
        : row(of.row_length()),
          data(static_cast<Real*>(::operator new(of.plane_length() * sizeof(Real), std::align_val_t(alignment))))
    {
        std::fill_n(data, of.plane_length(), Real(0));
    }
    Plane(const Plane&) = delete;
    ~Plane() { ::operator delete(data, std::align_val_t(alignment)); }
    Real& operator()(int i, int j) { return data[size_t(j) * row + size_t(i)]; }
    size_t row;
    Real* data;
};

double random_value(int i, int j) { return uniform(hash_bits(5, uint64_t(i), uint64_t(j))) - 0.5; }

/// The neighbour of cell `at` in a row of n cells: its index, and the sign with which it counts.
std::pair<int, double> cell(AxisEnd end, int at, int n)
{
    if (at >= 0 && at < n) return {at, 1.0};
    if (end == AxisEnd::Periodic) return {(at + n) % n, 1.0};
    return {at < 0 ? 0 : n - 1, end == AxisEnd::Even ? 1.0 : -1.0};
}

template<typename Real>
void check_second_difference(int nx, int ny, AxisEnd x, AxisEnd y)
{
    const BatchedTransform<Real> transform(nx, ny, x, y);
    Plane<Real> plane(transform);
    for (int j = 0; j < ny; ++j)
        for (int i = 0; i < nx; ++i) plane(i, j) = Real(random_value(i, j));
    transform.forward(plane.data);
    for (int j = 0; j < transform.modes_y(); ++j)
        for (int i = 0; i < transform.modes_x(); ++i) {
            const double sx = std::sin(transform.half_phase_x(i)), sy = std::sin(transform.half_phase_y(j));
            plane(i, j) *= Real(transform.scale() * (-4 * sx * sx - 3 * 4 * sy * sy));  // D_x + 3 D_y
        }
    transform.backward(plane.data);
    for (int j = 0; j < ny; ++j)
        for (int i = 0; i < nx; ++i) {
            double expected = -(2 + 3 * 2) * random_value(i, j);
            for (int side : {-1, 1}) {
                const auto [a, sa] = cell(x, i + side, nx);
                const auto [b, sb] = cell(y, j + side, ny);
                expected += sa * random_value(a, j) + 3 * sb * random_value(i, b);
            }
            // Values and eigenvalues up to 16; rounding grows as the logarithm of the size.
            ASSERT_NEAR(plane(i, j), expected, 200 * std::numeric_limits<Real>::epsilon())
                << nx << " x " << ny << ", ends " << int(x) << ' ' << int(y) << " at " << i << ' ' << j;
        }
}

TEST(BatchedTransform, DiagonalisesTheSecondDifferenceForEveryPairOfEnds)
{
    const AxisEnd ends[] = {AxisEnd::Periodic, AxisEnd::Even, AxisEnd::Odd};
    for (const auto& [nx, ny] : {std::pair(8, 6), {7, 9}, {1, 5}, {12, 1}, {33, 2}})
        for (AxisEnd x : ends)
            for (AxisEnd y : ends) {
                check_second_difference<double>(nx, ny, x, y);
                check_second_difference<float>(nx, ny, x, y);
            }
}

TEST(BatchedTransform, RefusesSizesOutsideItsRange)
{
    EXPECT_THROW(BatchedTransform<float>(0, 4, AxisEnd::Even, AxisEnd::Even), InputError);
    EXPECT_THROW(BatchedTransform<float>(4, 16385, AxisEnd::Even, AxisEnd::Even), InputError);
}

}  // namespace
}  // namespace vdbcloud::fft
