#pragma once
// Emission that reaches the origin of a ray. Private to render/.
#include "vdbcloud/render/path_media.h"

#include <vector>

namespace vdbcloud {

/// Integrates emission times transmittance along rays.
///
/// Emission in a cell is a cubic of the distance and the optical depth of each medium a quartic. Between the borders of
/// all cells both are smooth, and Gauss's rule with 3 or 4 points on parts of optical depth 1/2 or less errs by less
/// than 1e-8 of the emission. So emission along a ray has no noise.
///
/// Holds scratch memory: one object per thread.
class EmissionMarch {
public:
    explicit EmissionMarch(const PathScene&);

    /// The radiance that the ray of `media` brings to its origin. Ends at optical depth `opaque` (cell_rule.h).
    Vec3d exact(const PathMedia& media);
    /// The same in the mean: where the brightest channel's transmittance is below `dim`, the march ends at random, with
    /// a probability that keeps the mean (Russian roulette).
    Vec3d sampled(const PathMedia& media, double dim, PathRandom& random);

    /// The emission of the ray's first `end`, not attenuated: where `end` is the first collision in a grey medium, its
    /// mean is that of exact(). Closed form in each cell, and cheaper: it visits no medium, and no cell beyond the
    /// collision.
    Vec3d unattenuated(const PathMedia& media, double end);

private:
    /// A part of the ray within one cell; s = (t - t0) / (t1 - t0) in the polynomials.
    struct Piece {
        double t0, t1;
        Cubic density;
    };
    struct Emitting {
        double t0, t1;
        Cubic channels[3];
    };
    /// The pieces of one medium, in order, and the first of them that is not behind.
    struct Attenuating {
        Vec3d sigma_t;
        std::vector<Piece> pieces;
        size_t at = 0;
    };

    Vec3d march(const PathMedia&, double least, double roulette);
    double gather_emission(const PathMedia&, double from, double end);
    void gather_media(const PathMedia&, double from, double to);
    double next_border(double from, double to);
    Vec3d depth(double from, double to) const;
    Vec3d quadrature(const Emitting&, double from, double to, const Vec3d& before, const Vec3d& step) const;

    const PathScene& scene_;
    std::vector<std::vector<Emitting>> emitting_;  // of each emitting volume
    std::vector<Attenuating> media_;               // of each volume
};

}  // namespace vdbcloud
