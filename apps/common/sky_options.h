#pragma once
// Options for a sky that changes with height: as a light in p1solve, as a background in render.
#include "app.h"

#include "vdbcloud/scene/sky.h"

namespace vdbcloud::app {

struct SkyOptions {
    Vec3d zenith{0, 0, 0}, horizon{0, 0, 0}, ground{0, 0, 0};
    double haze = Sky().haze;
    struct {
        Option zenith, horizon, ground, haze;
    } option;
};

/// --sky-zenith --sky-horizon --sky-ground --sky-haze.
void declare_sky_shape(App&, SkyOptions&, const std::string& group);

/// True if one of the three radiances was given.
bool sky_asked(const SkyOptions&);

/// `sky` with the values of the options that were given.
Sky with_asked(const SkyOptions&, Sky sky);

/// "1" or "r,g,b" as a colour. Throws UsageError: OPTION TEXT: expected EXPECTED.
Vec3d colour_asked(const std::string& option, const std::string& text, const std::string& expected);

}  // namespace vdbcloud::app
