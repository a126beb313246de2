#pragma once
// The options of render, and values that are read from their text.
#include "effect_options.h"
#include "light_options.h"
#include "medium_options.h"
#include "sky_options.h"
#include "solid_options.h"
#include "stage_options.h"

#include "vdbcloud/light/transmittance_grid.h"
#include "vdbcloud/render/image_out.h"
#include "vdbcloud/render/integrator.h"
#include "vdbcloud/scene/camera.h"
#include "vdbcloud/scene/sky.h"

#include <optional>
#include <string>
#include <vector>

namespace vdbcloud {

struct RenderOptions {
    std::vector<std::string> inputs;
    std::string output, png, error_png;

    std::string density;   ///< name of the density grid; empty: by alias
    std::string periodic;  ///< axes along which the media repeat; empty: the file's
    app::MediumOptions medium;
    app::LightOptions lights;
    app::SolidOptions solids;
    app::EffectOptions effects;
    TransmittanceOptions light;  ///< for transmittance grids that the input lacks

    Camera camera;
    Vec3d direction{0, 0, 0};
    FramingOptions framing;
    std::optional<UpAxis> up;  ///< none: the file's, else y
    std::string resolution = "512x512", crop;
    double pixel_aspect = 1;

    SamplingOptions sampling;
    IntegratorOptions integrator;
    std::string certify;  ///< seconds, half-width, or both; empty: no certificate
    bool correct = false;
    bool multiple = false;  ///< compute multiple scattering that the input lacks
    std::vector<std::string> aovs{"Z"};

    std::string background;  ///< "none", "sky", or a colour; empty: none in exr, sky in png
    app::SkyOptions sky;
    double ground_albedo = 0;  ///< where it is given

    ViewOptions view;
    int png_bits = 8;
    bool progressive = false, shown = false;  ///< shows the .png while it is computed; has shown it

    struct {
        app::Option camera, look_at, direction, ortho_width, integrator, fidelity, exposure, samples, ground, certify,
            solid_rays, multiple;
    } option;
};

void declare(app::App&, RenderOptions&);

/// By light paths: --integrator path, or --gather.
bool traces_paths(const RenderOptions&);
/// Whether the picture shows grids of light: all but whole light paths do.
bool shows_light_grids(const RenderOptions&);
/// Light paths are traced until a target is met, not up to a number.
bool ends_by_target(const RenderOptions&);
/// The number of samples where the user gives none: of a path tracer 16, and without bound where a target ends the run.
void choose_samples(RenderOptions&);

/// The .png that --progressive shows: of --png, else of --output.
const std::string& shown_png(const RenderOptions&);

/// The numbers of pixels in `text`, between characters `at`; none if one of them is no number of pixels.
std::vector<int> pixels(const std::string& text, char at);

/// "640x480", or "512" for a square; and "x0,y0,x1,y1" of the crop. Throws UsageError.
ImageSize image_size(const RenderOptions&);

/// The layers of --aov, split at commas, without "none" and "background".
std::vector<std::string> wanted_layers(const RenderOptions&);
bool wants_background_layer(const RenderOptions&);

/// The background of the picture, and whether the .exr shows it.
struct ChosenBackground {
    Sky sky;    ///< with the suns of an environment
    Sky light;  ///< the same as it lights
    bool in_exr = false;
};

/// The background of --background; without the option the sky that lit the medium, `lit_by`; without that a clear day,
/// whose brightness the suns set. Throws UsageError for an unknown background.
ChosenBackground chosen_background(const RenderOptions&, const std::vector<Light>& lights, UpAxis up,
                                   const std::optional<Sky>& lit_by);

/// The sky that lights the media of a path tracer: the input's, `lit_by`, or the one asked for, else none (black).
Sky chosen_sky(const RenderOptions&, const std::vector<Light>& lights, UpAxis up, const std::optional<Sky>& lit_by);

}  // namespace vdbcloud
