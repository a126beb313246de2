// slab_values CASE TAU ALBEDO G MU0 [ANGLE...]: reflected and transmitted flux and radiance of a slab by adding and
// doubling, as rows "CASE,QUANTITY,PLACE,VALUE,0,SOURCE" of pipelines/benchmarks. Fluxes are over the sun's flux on the
// slab, the direct beam included in T; I is pi times radiance over that flux. ANGLE: between the ways of the sun's
// light and of the light that is seen [degrees], for a sun at the zenith (MU0 1).
#include "support/slab_exact.h"
#include "vdbcloud/core/constants.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>

int main(int argc, char** argv)
{
    using vdbcloud::pi;
    const double mu0 = argc > 5 ? std::atof(argv[5]) : 0;
    if (!(mu0 > 0 && mu0 <= 1) || (argc > 6 && mu0 != 1)) {
        std::fprintf(stderr, "usage: slab_values CASE TAU ALBEDO G MU0 [ANGLE...], angles for MU0 1 alone\n");
        return 2;
    }
    vdbcloud::test::SlabExact::Options o;
    o.tau = std::atof(argv[2]);
    o.w0 = std::atof(argv[3]);
    o.g = std::atof(argv[4]);
    o.mu0 = mu0;
    o.n = 48;  // moments to degree 95: 2e-7 of the peak at g = 0.85
    for (int k = 6; k < argc; ++k) o.view.push_back(std::abs(std::cos(std::atof(argv[k]) * pi / 180)));
    const vdbcloud::test::SlabExact slab(o);
    const auto row = [&](const char* quantity, const char* place, double value) {
        std::printf("%s,%s,%s,%.6g,0,adding and doubling\n", argv[1], quantity, place, value);
    };
    const double reflected = slab.reflected() / mu0, transmitted = slab.transmitted() / mu0 + std::exp(-o.tau / mu0);
    row("R", "mean", reflected);
    row("T", "mean", transmitted);
    if (o.w0 < 1) row("A", "mean", 1 - reflected - transmitted);
    for (int k = 6; k < argc; ++k) {
        const bool down = std::atof(argv[k]) < 90;
        row("I", argv[k], pi / mu0 * (down ? slab.emergent_bottom(k - 6) : slab.emergent_top(k - 6)));
    }
}
