#pragma once
// The options of p1solve.
#include "effect_options.h"
#include "inputs.h"
#include "light_options.h"
#include "medium_options.h"
#include "periodic_option.h"
#include "sky_options.h"
#include "solid_options.h"
#include "stage_options.h"

#include "vdbcloud/scatter/series_grids.h"

#include <string>
#include <vector>

namespace vdbcloud {

struct P1solveOptions : app::StageOptions {
    app::MediumOptions medium;
    app::LightOptions lights;
    app::SolidOptions solids;
    app::EffectOptions effects;
    app::SkyOptions sky;
    ScatterOptions scatter;
    app::Option rays_per_voxel, delta, disc_samples, keep_moments, heating, ground;
    double ground_albedo = 0;  ///< where `ground` is given
    std::string flux_map;      ///< .exr to write; empty: none
    std::string start_from;    ///< a file with the light of the frame before; empty: none
    double start_seconds = 0;  ///< since then, where `start_seconds_option` is given
    app::Option start_seconds_option;
    bool allow_unconverged = false, series_raw = false, voxel_error = false;
    SeriesOptions series;

    P1solveOptions() { series.order = 0; }
};

void declare(app::App&, P1solveOptions&);

/// Throws UsageError for --delta with a phase function whose delta fraction is 0 at the degree of the solve, as
/// isotropic and Rayleigh scattering have: on and off are then the same. And for --keep-moments with one that weighs no
/// moment of degree 2 or more.
void check_phase(const P1solveOptions&, const app::MediumInput&);

/// Throws UsageError for --heating where nothing absorbs.
void check_heating(const P1solveOptions&, const app::MediumInput&, bool tinted);

/// Throws UsageError for what takes one medium, where several overlap.
void check_overlap(const P1solveOptions&, const app::MediumInput&);

/// Sets ScatterOptions::ground_albedo. Throws UsageError for a ground under a medium that does not repeat along two
/// axes.
void choose_ground(P1solveOptions&, const app::Axes& periodic);

/// Checks the name of --flux-map, and --limiter, --series and --iterations against the other options. Says how many
/// directions are taken if their number was rounded up. Throws UsageError.
void finish(app::App&, P1solveOptions&);

}  // namespace vdbcloud
