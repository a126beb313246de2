#pragma once
// The options of illuminate.
#include "effect_options.h"
#include "light_options.h"
#include "medium_options.h"
#include "solid_options.h"
#include "stage_options.h"

#include "vdbcloud/light/transmittance_grid.h"

#include <vector>

namespace vdbcloud {

struct IlluminateOptions : app::StageOptions {
    app::MediumOptions medium;
    app::LightOptions lights;
    app::SolidOptions solids;
    app::EffectOptions effects;
    TransmittanceOptions accuracy;
    app::Option disc_samples;
    std::vector<app::Option> of_suns;  ///< no effect on lamps, nor in a periodic medium, whose rays are all exact
};

void declare(app::App&, IlluminateOptions&);

/// Throws UsageError for an accuracy option that has no effect on any of the lights that are computed.
void check_effects(const IlluminateOptions&, const std::vector<Light>& computed);

}  // namespace vdbcloud
