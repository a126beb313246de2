#pragma once
// Gaussian noise with a power-law spectrum, by spectral synthesis.
#include "vdbcloud/core/fwd.h"
#include "vdbcloud/fft/real_transform.h"

#include <cstdint>

namespace vdbcloud {

/// The power spectrum of a random field over a periodic box.
///
/// Wave numbers are in cycles per longest side of the box: kappa_d = m_d stretch_d (longest / side_d) for the
/// integer mode m. The mean power of ONE mode is
///
///     S(kappa) = (outer^2 + |kappa|^2)^(-beta/2)   for low_cut <= |kappa| <= high_cut, else 0
///
/// and 0 at m = 0 (von Karman's form; a plain power law for outer = 0). Per mode, not per shell: the power of a shell
/// falls as kappa^(2 - beta), and Kolmogorov's -5/3 law for a passive scalar is beta = 11/3.
struct Spectrum {
    uint64_t seed = 1;
    double beta = 11.0 / 3;  ///< exponent of the mean power of a mode, 0..12
    double outer = 0;        ///< the spectrum is flat below this wave number [cycles per longest side]
    double low_cut = 0;      ///< waves longer than this are left out [cycles per longest side]
    double high_cut = 1e9;   ///< waves shorter than this are left out [cycles per longest side]
    Vec3d stretch{1, 1, 1};  ///< how many times longer features are along each axis
};

/// S(kappa) as above, for a squared wave number.
double mode_power(const Spectrum&, double kappa_squared);

/// A field with that spectrum over a box of `sides` [world] cut into size[0] x size[1] x size[2] voxels, at
/// their centres: spectral synthesis (Voss, Random fractal forgeries, 1985).
///
/// Each mode is a complex Gaussian of variance S: sqrt(-S log u) exp(2 pi I v), with u and v hashed from the
/// seed and the mode's signed wave numbers, so a mode has the same value at every size: a larger size adds
/// detail to the same shape. Modes outside the ellipsoid sum_d (2 m_d / size_d)^2 < 1 are left out, as the
/// corners of the box of modes hold only some directions, and would mark the axes.
///
/// Scale: the expected variance of the waves with every |m_d| <= 32 is 1, so that of more is a little more
/// (beta > 3). Mean 0. Any size in 1..4096 an axis; large primes are slower. An axis of one voxel has no
/// waves: that makes noise in two dimensions, where the power of a ring falls as kappa^(1 - beta).
///
/// Threads: all of TBB's; values do not depend on them. Memory: one field (fft::RealField<float>::bytes).
/// Throws InputError for a parameter outside its range or a spectrum without power.
fft::RealField<float> synthesize(const Vec3i& size, const Vec3d& sides, const Spectrum&);

}  // namespace vdbcloud
