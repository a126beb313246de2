#pragma once
// What p1solve is asked for.
#include "light_options.h"
#include "medium_options.h"
#include "sky_options.h"
#include "stage_options.h"

#include "vdbcloud/scatter/series_grids.h"

#include <string>

namespace vdbcloud {

struct P1solveOptions : app::StageOptions {
    std::string periodic;
    app::MediumOptions medium;
    app::LightOptions lights;
    std::string sky;  ///< "day", a colour, or empty: no sky unless its shape is asked for
    app::SkyOptions sky_shape;
    ScatterOptions scatter;
    app::Option rays_per_voxel, delta;
    bool allow_unconverged = false, series_raw = false;
    SeriesOptions series;

    P1solveOptions() { series.order = 0; }
};

void declare(app::App&, P1solveOptions&);

/// The sky asked for, over `up`; black if none is. How bright a day is follows from the suns. Throws UsageError.
Sky chosen_sky(const P1solveOptions&, const std::vector<Light>& lights, const Vec3d& up);

/// Throws UsageError for --delta with a phase function whose delta fraction is 0 at the degree of the solve, as
/// isotropic and Rayleigh scattering have: on and off are then the same.
void check_delta(const P1solveOptions&, const PhaseFunction&);

/// What options say together, once all are read: the letters of --periodic, and what --iterations cannot go with.
/// Tells of directions that were rounded up. Throws UsageError.
void finish(app::App&, P1solveOptions&);

}  // namespace vdbcloud
