#include "vdbcloud/scene/colour.h"

#include "vdbcloud/core/vdb.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

double lobe(double wavelength, double middle, double below, double above)
{
    const double t = (wavelength - middle) / (wavelength < middle ? below : above);
    return std::exp(-t * t / 2);
}

}  // namespace

Vec3d colour_matching(double l)
{
    return {1.056 * lobe(l, 599.8, 37.9, 31.0) + 0.362 * lobe(l, 442.0, 16.0, 26.7) -
                0.065 * lobe(l, 501.1, 20.4, 26.2),
            0.821 * lobe(l, 568.8, 46.9, 40.5) + 0.286 * lobe(l, 530.9, 16.3, 31.1),
            1.217 * lobe(l, 437.0, 11.8, 36.0) + 0.681 * lobe(l, 459.0, 26.0, 13.8)};
}

double luminance(const Vec3d& c) { return 0.2126729 * c[0] + 0.7151522 * c[1] + 0.0721750 * c[2]; }

Vec3d rec709_of_xyz(const Vec3d& v)
{
    const Vec3d c(3.2404542 * v[0] - 1.5371385 * v[1] - 0.4985314 * v[2],
                  -0.9692660 * v[0] + 1.8760108 * v[1] + 0.0415560 * v[2],
                  0.0556434 * v[0] - 0.2040259 * v[1] + 1.0572252 * v[2]);
    if (c[0] >= 0 && c[1] >= 0 && c[2] >= 0) return c;
    const Vec3d within(std::max(0.0, c[0]), std::max(0.0, c[1]), std::max(0.0, c[2]));
    const double left = luminance(within);
    return left > 0 ? within * std::max(0.0, v[1]) / left : Vec3d(0.0);
}

Vec3d xyz_of_chromaticity(double x, double y, double Y) { return {x / y * Y, Y, (1 - x - y) / y * Y}; }

}  // namespace vdbcloud
