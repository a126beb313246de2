#include "vdbcloud/fractal/noise.h"

#include "vdbcloud/core/clones.h"
#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/random.h"
#include "vdbcloud/core/refuse.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

namespace vdbcloud {

namespace {

constexpr int lanes = 16;  // modes at a time; as many as one block of columns of the transform

/// One axis of the box of modes.
struct Axis {
    int size = 1;
    float kappa = 1;     // wave number of m = 1
    float limit = 1;     // (2 / size)^2
    uint32_t shift = 0;  // phase of m = 1 at half a voxel [2^-32 turns]

    int signed_mode(int index) const { return 2 * index < size ? index : index - size; }
};

struct Synthesis {
    Axis axis[3];
    uint64_t seed = 0;
    float beta = 0, outer2 = 0, low2 = 0, high2 = 0, scale = 1;
};

// Logarithm, power and sine good to about 1e-5, of arithmetic alone: loops of them become vector code, and
// give the same bits in each of its clones.
inline float log2_of(float x)
{
    int32_t bits;
    std::memcpy(&bits, &x, 4);
    const int32_t e = (bits - 0x3f3504f3) >> 23;  // so that the mantissa is in sqrt(1/2)..sqrt(2)
    bits -= e * 0x800000;
    float m;
    std::memcpy(&m, &bits, 4);
    const float s = (m - 1) / (m + 1), s2 = s * s;
    return float(e) + 2.885390082f * s * (1 + s2 * (0.333333333f + s2 * 0.2f));
}

inline float exp2_of(float x)
{
    x = x < -126 ? -126 : x;
    x = x > 100 ? 100 : x;
    const float whole = (x + 12582912.0f) - 12582912.0f, f = (x - whole) * 0.6931471806f;
    const float p = 1 + f * (1 + f * (0.5f + f * (1 / 6.f + f * (1 / 24.f + f * (1 / 120.f)))));
    const int32_t bits = (int32_t(whole) + 127) * 0x800000;
    float two;
    std::memcpy(&two, &bits, 4);
    return p * two;
}

/// A mixing of 32 bits (the finaliser of MurmurHash3, Appleby 2011).
inline uint32_t mix(uint32_t x)
{
    x = (x ^ (x >> 16)) * 0x85ebca6bu;
    x = (x ^ (x >> 13)) * 0xc2b2ae35u;
    return x ^ (x >> 16);
}

/// `lanes` modes from c0 on of the row (mx, my): interleaved real and imaginary parts. Inlined, so that each
/// clone of its caller has its own.
__attribute__((always_inline)) inline void modes_of_row(const Synthesis& s, int mx, int my, int c0, float* out)
{
    const auto &X = s.axis[0], &Y = s.axis[1], &Z = s.axis[2];
    const uint64_t key = hash_bits(hash_bits(s.seed + uint32_t(my)) ^ uint32_t(mx));
    const uint32_t key_u = uint32_t(key), key_v = uint32_t(key >> 32);
    const uint32_t turn = uint32_t(mx) * X.shift + uint32_t(my) * Y.shift;
    const float fx = float(mx), fy = float(my);
    const float kappa_xy = fx * fx * X.kappa * X.kappa + fy * fy * Y.kappa * Y.kappa;
    const float inside_xy = fx * fx * X.limit + fy * fy * Y.limit;
    const float kappa_z = Z.kappa * Z.kappa, exponent = -0.5f * s.beta;
    for (int w = 0; w < lanes; ++w) {
        const uint32_t c = uint32_t(c0 + w);
        const uint32_t u = mix(key_u + c * 0x9e3779b9u), v = mix(key_v + c * 0x7feb352du) + turn + c * Z.shift;
        const float fz = float(int32_t(c)), kappa2 = kappa_xy + fz * fz * kappa_z;
        const float uniform = (float(int32_t(u >> 8)) + 1) * 0x1p-24f;
        const float power = exp2_of(exponent * log2_of(s.outer2 + kappa2)) * s.scale;
        const int kept = (kappa2 > 0) & (kappa2 >= s.low2) & (kappa2 <= s.high2) & (inside_xy + fz * fz * Z.limit < 1);
        const float r = std::sqrt(log2_of(uniform) * -0.6931471806f * power) * float(kept);
        const float h = float(int32_t(v)) * float(0x1p-32 * pi),
                    h2 = h * h;  // half the phase: |h| <= pi / 2
        const float sine = h * (1 - h2 * (1 / 6.f - h2 * (1 / 120.f - h2 * (1 / 5040.f - h2 * (1 / 362880.f)))));
        const float cosine =
            1 - h2 * (0.5f - h2 * (1 / 24.f - h2 * (1 / 720.f - h2 * (1 / 40320.f - h2 * (1 / 3628800.f)))));
        out[2 * w] = r * (cosine * cosine - sine * sine);
        out[2 * w + 1] = r * (2 * sine * cosine);
    }
}

/// The modes of columns b, c0..c0 + width - 1 (fft::RealTransform::Modes).
VDBCLOUD_CLONES
bool make_modes(const Synthesis& s, int b, int c0, int width, std::complex<float>* out, int stride)
{
    const int my = s.axis[1].signed_mode(b);
    const float inside = float(my) * float(my) * s.axis[1].limit + float(c0) * float(c0) * s.axis[2].limit;
    if (inside >= 1) return false;
    for (int a = 0; a < s.axis[0].size; ++a) {
        const int mx = s.axis[0].signed_mode(a);
        auto* row = out + size_t(a) * stride;
        if (inside + float(mx) * float(mx) * s.axis[0].limit >= 1) {
            std::fill_n(row, width, std::complex<float>());
            continue;
        }
        if (width == lanes && c0 > 0) {
            modes_of_row(s, mx, my, c0, reinterpret_cast<float*>(row));
            continue;
        }
        float modes[2 * lanes];
        modes_of_row(s, mx, my, c0, modes);
        if (c0 == 0 && (my < 0 || (my == 0 && mx < 0))) {  // F(-m) = conj F(m) within the plane c = 0
            float partner[2 * lanes];
            modes_of_row(s, -mx, -my, 0, partner);
            modes[0] = partner[0];
            modes[1] = -partner[1];
        }
        std::memcpy(static_cast<void*>(row), modes, size_t(width) * sizeof *row);
    }
    return true;
}

/// Expected variance of the waves with every |m_d| <= `most` (0 along an axis of one voxel), before scaling.
double variance(const Spectrum& spectrum, const Vec3i& size, const Vec3d& kappa, int most)
{
    double sum = 0;
    for (int x = 0; x <= (size[0] > 1 ? most : 0); ++x)
        for (int y = 0; y <= (size[1] > 1 ? most : 0); ++y)
            for (int z = 0; z <= (size[2] > 1 ? most : 0); ++z) {
                if (x + y + z == 0) continue;
                const Vec3d k(x * kappa[0], y * kappa[1], z * kappa[2]);
                const int mirrored = (x ? 2 : 1) * (y ? 2 : 1) * (z ? 2 : 1);
                sum += mirrored * mode_power(spectrum, k.dot(k));
            }
    return sum;
}

void check(const Spectrum& s, const Vec3d& sides)
{
    if (!(s.beta >= 0 && s.beta <= 12)) refuse("beta", s.beta, "0..12");
    if (!(s.outer >= 0 && s.outer < 1e6)) refuse("outer", s.outer, "0..1e6");
    if (!(s.low_cut >= 0 && s.low_cut <= 256)) refuse("low_cut", s.low_cut, "0..256");
    if (!(s.high_cut >= s.low_cut)) refuse("high_cut", s.high_cut, "at least low_cut");
    for (int d = 0; d < 3; ++d) {
        if (!(s.stretch[d] >= 0.01 && s.stretch[d] <= 100)) refuse("stretch", s.stretch[d], "0.01..100");
        if (!(sides[d] > 0 && std::isfinite(sides[d]))) refuse("side of the box", sides[d], "a finite length > 0");
    }
}

}  // namespace

double mode_power(const Spectrum& s, double kappa_squared)
{
    if (kappa_squared < s.low_cut * s.low_cut || kappa_squared > s.high_cut * s.high_cut) return 0;
    return std::pow(s.outer * s.outer + kappa_squared, -s.beta / 2);
}

fft::RealField<float> synthesize(const Vec3i& size, const Vec3d& sides, const Spectrum& spectrum)
{
    check(spectrum, sides);
    const double longest = std::max({sides[0], sides[1], sides[2]});
    Vec3d kappa;
    Synthesis s;
    for (int d = 0; d < 3; ++d) {
        kappa[d] = spectrum.stretch[d] * longest / sides[d];
        s.axis[d] = {size[d], float(kappa[d]), float(4.0 / size[d] / size[d]), uint32_t(0x1p31 / size[d])};
    }
    s.seed = hash_bits(spectrum.seed);
    s.beta = float(spectrum.beta);
    s.outer2 = float(spectrum.outer * spectrum.outer);
    s.low2 = float(spectrum.low_cut * spectrum.low_cut);
    s.high2 = float(std::min(spectrum.high_cut * spectrum.high_cut, 1e30));
    const double power = variance(spectrum, size, kappa, std::max(32, int(std::ceil(2 * spectrum.low_cut))));
    if (!(power > 0)) throw InputError("the spectrum has no waves between low_cut and high_cut");
    s.scale = float(1 / power);

    fft::RealField<float> field(size);
    fft::RealTransform<float>(size).backward([&](int b, int c0, int width, std::complex<float>* out,
                                                 int stride) { return make_modes(s, b, c0, width, out, stride); },
                                             field);
    return field;
}

}  // namespace vdbcloud
