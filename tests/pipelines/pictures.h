#pragma once
// Pictures of one heterogeneous cloud from three sides, their differences, and path-traced references.
#include "vdbcloud/core/affine.h"

#include <array>
#include <string>

namespace vdbcloud::test {

constexpr int pixels = 24;  ///< along each side of a picture

struct View {
    Vec3d direction;
    WorldRay ray(double u, double v) const
    {
        const Vec3d at = direction[1] == 0 ? Vec3d(u, v, 0.5) : Vec3d(u, 0.5, v);
        return {at - direction, direction};
    }
};

/// From above, the side, below.
inline const View views[3] = {{Vec3d(0, -1, 0)}, {Vec3d(0, 0, -1)}, {Vec3d(0, 1, 0)}};

struct Mean {
    double value = 0, deviation = 0;  // and its standard error
};

/// Pictures of 3 x 3 blocks of 8 x 8 pixels, for each view.
constexpr int edge = 8, blocks = pixels / edge * (pixels / edge);
using Picture = std::array<Mean, blocks>;
using Pictures = std::array<Picture, 3>;  ///< of `views`

/// A path-traced reference, with `samples` per pixel. Made by
/// --gtest_also_run_disabled_tests --gtest_filter='*PrintsReference*' in 6 minutes of processor time.
struct Reference {
    double w0, g;
    int samples;
    Pictures view;
};
extern const std::array<Reference, 3> references;

/// A cloud's rows of data/references at one optical depth, in one medium.
Pictures by_light_paths(const std::string& cloud, double tau, double w0, double g);

Mean mean(const Picture& picture);

/// Root mean square difference over blocks, relative to the reference's mean. `deviation` is the part that the
/// reference's own error explains (95 %).
Mean rms(const Picture& picture, const Picture& truth);
/// Over the blocks of three pictures, each relative to its own mean.
Mean rms(const Pictures& pictures, const Pictures& truth);

}  // namespace vdbcloud::test
