// The three-dimensional real transform against the sum that defines it, and against itself.
#include "vdbcloud/fft/real_transform.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/random.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cstring>
#include <limits>
#include <vector>

namespace vdbcloud::fft {
namespace {

const Vec3i sizes[] = {{1, 1, 1}, {2, 2, 2}, {4, 6, 8}, {3, 5, 7}, {11, 1, 13}, {1, 9, 2}, {5, 4, 33}, {6, 3, 64}};

template<typename Real>
void randomize(RealField<Real>& f, uint64_t seed)
{
    const auto& n = f.size();
    for (int i = 0; i < n[0]; ++i)
        for (int j = 0; j < n[1]; ++j)
            for (int k = 0; k < n[2]; ++k) f(i, j, k) = Real(normal(hash_bits(seed, i, j, k)));
}

/// exp(sign 2 pi I (a i / nx + b j / ny + c k / nz)), the phase reduced in integers.
std::complex<double> wave(const Vec3i& n, const Vec3i& a, const Vec3i& x, int sign)
{
    double turns = 0;
    for (int d = 0; d < 3; ++d) turns += double(int64_t(a[d]) * x[d] % n[d]) / n[d];
    return std::polar(1.0, sign * 2 * M_PI * turns);
}

template<typename Real>
class RealTransformOf : public testing::Test {
protected:
    // Rounding grows as the logarithm of the number of points; fields are of order 1, sums of order
    // sqrt(points).
    static double tolerance(const Vec3i& n)
    {
        return 30 * std::numeric_limits<Real>::epsilon() * std::sqrt(n.product());
    }
};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(RealTransformOf, Precisions);

TYPED_TEST(RealTransformOf, ForwardIsTheSumThatDefinesIt)
{
    for (const auto& n : sizes) {
        RealField<TypeParam> f(n), spectrum(n);
        randomize(f, 1);
        randomize(spectrum, 1);
        RealTransform<TypeParam>(n).forward(spectrum);
        for (int a = 0; a < n[0]; ++a)
            for (int b = 0; b < n[1]; ++b)
                for (int c = 0; c <= n[2] / 2; ++c) {
                    std::complex<double> sum = 0;
                    for (int i = 0; i < n[0]; ++i)
                        for (int j = 0; j < n[1]; ++j)
                            for (int k = 0; k < n[2]; ++k)
                                sum += double(f(i, j, k)) * wave(n, {a, b, c}, {i, j, k}, -1);
                    const std::complex<double> got(spectrum.modes(a, b)[c]);
                    ASSERT_NEAR(std::abs(got - sum), 0, this->tolerance(n)) << n << " " << Vec3i(a, b, c);
                }
    }
}

TYPED_TEST(RealTransformOf, BackwardOfOneModeIsItsWave)
{
    const Vec3i n(6, 5, 9), mode(2, 4, 3);
    RealField<TypeParam> f(n);
    const auto make = [&](int b, int c0, int width, std::complex<TypeParam>* out, int stride) {
        for (int a = 0; a < n[0]; ++a)
            for (int w = 0; w < width; ++w)
                out[a * stride + w] = Vec3i(a, b, c0 + w) == mode ? std::complex<TypeParam>(1, 2) : 0;
        return b == mode[1];
    };
    RealTransform<TypeParam>(n).backward(make, f);
    for (int i = 0; i < n[0]; ++i)
        for (int j = 0; j < n[1]; ++j)
            for (int k = 0; k < n[2]; ++k)  // the mode and its conjugate partner
                ASSERT_NEAR(f(i, j, k), 2 * (std::complex<double>(1, 2) * wave(n, mode, {i, j, k}, 1)).real(),
                            this->tolerance(n));
}

TYPED_TEST(RealTransformOf, BackwardOfForwardIsTheFieldTimesItsPoints)
{
    for (const auto& n : {Vec3i(31, 17, 29), Vec3i(32, 20, 66), Vec3i(1, 40, 3), Vec3i(7, 64, 1)}) {
        RealField<TypeParam> f(n), g(n);
        randomize(f, 2);
        randomize(g, 2);
        const RealTransform<TypeParam> transform(n);
        transform.forward(g);
        transform.backward(g);
        for (int i = 0; i < n[0]; ++i)
            for (int j = 0; j < n[1]; ++j)
                for (int k = 0; k < n[2]; ++k)
                    ASSERT_NEAR(g(i, j, k) / n.product(), f(i, j, k), 30 * std::numeric_limits<TypeParam>::epsilon());
    }
}

TYPED_TEST(RealTransformOf, BackwardOfAFunctionHasTheBitsOfBackwardOfAField)
{
    const Vec3i n(12, 10, 45);
    RealField<TypeParam> spectrum(n), f(n);
    randomize(spectrum, 3);
    const RealTransform<TypeParam> transform(n);
    transform.forward(spectrum);
    transform.backward(
        [&](int b, int c0, int width, std::complex<TypeParam>* out, int stride) {
            for (int a = 0; a < n[0]; ++a) std::copy_n(spectrum.modes(a, b) + c0, width, out + a * stride);
            return true;
        },
        f);
    transform.backward(spectrum);
    for (int i = 0; i < n[0]; ++i)
        for (int j = 0; j < n[1]; ++j)
            ASSERT_EQ(std::memcmp(f.row(i, j), spectrum.row(i, j), n[2] * sizeof(TypeParam)), 0);
}

TYPED_TEST(RealTransformOf, HasEqualBitsForAnyThreadCount)
{
    const Vec3i n(37, 24, 50);
    std::vector<TypeParam> first;
    for (int threads : {1, 2, 3, 8}) {
        tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        RealField<TypeParam> f(n);
        randomize(f, 4);
        RealTransform<TypeParam>(n).forward(f);
        std::vector<TypeParam> now;
        for (int i = 0; i < n[0]; ++i)
            for (int j = 0; j < n[1]; ++j) now.insert(now.end(), f.row(i, j), f.row(i, j) + 2 * f.modes_per_row());
        if (first.empty()) first = now;
        ASSERT_EQ(std::memcmp(first.data(), now.data(), now.size() * sizeof(TypeParam)), 0) << threads << " threads";
    }
}

TEST(RealTransform, RefusesSizesOutsideItsRange)
{
    EXPECT_THROW(RealField<float>({0, 4, 4}), InputError);
    EXPECT_THROW(RealTransform<double>({4, -1, 4}), InputError);
    EXPECT_THROW(RealField<float>({4, 4, 4097}), InputError);
    RealField<float> f({4, 4, 4});
    EXPECT_THROW(RealTransform<float>({4, 4, 5}).forward(f), InputError);
}

TEST(RealField, CountsItsBytes)
{
    EXPECT_EQ(RealField<float>::bytes({512, 512, 512}), 512u * 512u * 528u * 4u);
    EXPECT_EQ(RealField<float>({3, 3, 3}).row_length() % 16, 0u);
}

}  // namespace
}  // namespace vdbcloud::fft
