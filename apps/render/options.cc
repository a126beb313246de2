#include "options.h"

#include "certify.h"
#include "formed.h"

#include "periodic_option.h"

#include "vdbcloud/core/error.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

void declare_camera(app::App& app, RenderOptions& o)
{
    const char* group = "Camera";
    const auto perspective = [&o] { return o.camera.projection == Projection::Perspective; };
    o.option.camera =
        app.add_option("--camera", o.camera.position,
                       "position of the camera x,y,z, which may be inside the cloud; without it the cloud "
                       "is framed")
            ->default_str("")
            ->scene("camera", "position")
            ->group(group);
    o.option.look_at = app.add_option("--look-at", o.camera.look_at,
                                      "point x,y,z in the middle of the picture; without it the cloud's middle")
                           ->default_str("")
                           ->scene("camera")
                           ->group(group);
    o.option.direction =
        app.add_option("--direction", o.direction,
                       "direction x,y,z in which the camera looks; use it with framing, to see a cloud from any side")
            ->default_str("")
            ->scene("camera")
            ->group(group);
    app.add_choice<Projection>("--projection", o.camera.projection,
                               {{"perspective", Projection::Perspective}, {"orthographic", Projection::Orthographic}},
                               "perspective: rays from one point; orthographic: parallel rays, for measurements")
        ->scene("camera")
        ->group(group);
    app.add_option("--fov", o.camera.fov, "angle across the picture's width [degrees]")
        ->check(app::within(0.001, 179))
        ->only_with(perspective, "--projection perspective")
        ->scene("camera")
        ->group(group);
    o.option.ortho_width =
        app.add_option("--ortho-width", o.camera.width, "width of the picture [world units]; without it framed")
            ->check(app::positive)
            ->only_with([&o] { return o.camera.projection == Projection::Orthographic; }, "--projection orthographic")
            ->default_str("")
            ->scene("camera")
            ->group(group);
    app.add_option("--margin", o.framing.margin, "share of the picture that framing leaves free at each edge")
        ->check(app::within(0, 0.49))
        ->not_with([&o, perspective] { return perspective() && o.option.camera.given(); }, "--camera")
        ->not_with([&o] { return o.option.ortho_width.given(); }, "--ortho-width")
        ->scene("camera")
        ->group(group);
    app::declare_up(app, o.up, group);
    app.add_option("--resolution", o.resolution, "size of the picture [pixels], WxH or one number for a square")
        ->check(app::formed("WxH, such as 640x480, or one number of pixels",
                            [](const std::string& text) {
                                const size_t sides = pixels(text, 'x').size();
                                return sides == 1 || sides == 2;
                            }))
        ->scene("picture")
        ->group(group);
    app.add_option("--pixel-aspect", o.pixel_aspect, "width of a pixel over its height; 2 for anamorphic film")
        ->check(app::positive)
        ->scene("picture")
        ->group(group);
    app.add_option("--crop", o.crop,
                   "render only the pixels x0,y0 to x1,y1, the last ones not included; to try a detail")
        ->check(app::formed("x0,y0,x1,y1, whole numbers of pixels",
                            [](const std::string& text) { return text.empty() || pixels(text, ',').size() == 4; }))
        ->scene("picture")
        ->group(group);
}

void declare_integrator(app::App& app, RenderOptions& o, const char* group)
{
    const auto by = [&o](Integrator kind) { return [&o, kind] { return o.integrator.kind == kind; }; };
    o.option.integrator =
        app.add_choice<Integrator>(
               "--integrator", o.integrator.kind,
               {{name(Integrator::Cells), Integrator::Cells},
                {name(Integrator::Romberg), Integrator::Romberg},
                {name(Integrator::Steps), Integrator::Steps},
                {name(Integrator::Path), Integrator::Path}},
               "cells: exact optical depth in each voxel, fastest for its error; romberg: the paper's, "
               "adaptive; steps: of fixed length, for comparison; path: unbiased Monte Carlo of all "
               "orders of scattering, the reference for the others. path reads density, colour, "
               "emission, lights and sky, and no grid of illuminate or p1solve")
            ->scene("accuracy")
            ->group(group);
    app.add_option("--tolerance", o.integrator.tolerance, "error of romberg, relative to the brightest source")
        ->check(app::positive)
        ->only_with(by(Integrator::Romberg), "--integrator romberg")
        ->scene("accuracy", "romberg-tolerance")
        ->group(group);
    app.add_option("--step", o.integrator.step, "length of the integrator's steps [voxel edges]")
        ->check(app::positive)
        ->only_with(by(Integrator::Steps), "--integrator steps")
        ->scene("accuracy")
        ->group(group);
    app.add_option("--parts", o.integrator.parts, "steps of fourth order in each cell; more where a voxel is opaque")
        ->check(app::within(1, 64))
        ->only_with([&o] { return o.integrator.kind == Integrator::Cells && !traces_paths(o); }, "--integrator cells")
        ->scene("accuracy")
        ->group(group);
    app.add_flag("--shadow-rays", o.integrator.shadow_rays,
                 "find the light at each point by a ray of its own: slow, without light grids, the measure of their "
                 "error")
        ->not_with([&o] { return traces_paths(o); }, "--integrator path")
        ->scene("accuracy")
        ->group(group);
    app.add_option(
           "--gather", o.integrator.vertices,
           "end light paths of this many vertices in the picture that the other integrators show, so that "
           "p1solve's multiple scattering stands for what comes after: less noise than whole paths, and an error "
           "that falls with the number")
        ->check(app::within(2, 1000))
        ->only_with([&o] { return !o.option.integrator.given() || o.integrator.kind == Integrator::Path; },
                    "--integrator path")
        ->default_str("")
        ->scene("accuracy")
        ->group(group);
    o.option.multiple = app.add_flag("--multiple", o.multiple,
                                     "compute the light that is scattered more than once, where the input has none, as "
                                     "p1solve --iterations 3 "
                                     "does, under the sky that --sky-zenith, --sky-horizon and --sky-ground ask for. "
                                     "For several pictures of a "
                                     "cloud run p1solve once instead")
                            ->not_with([&o] { return !shows_light_grids(o); }, "--integrator path")
                            ->scene("accuracy")
                            ->group(group);
    o.option.fidelity =
        app.add_choice<Fidelity>("--fidelity", o.light.fidelity,
                                 {{"lattice", Fidelity::Lattice}, {"exact", Fidelity::Exact}},
                                 "how the light grids are computed that the input lacks; exact: a ray for each voxel")
            ->not_with([&o] { return o.integrator.shadow_rays; }, "--shadow-rays")
            ->not_with([&o] { return !shows_light_grids(o); }, "--integrator path")
            ->scene("accuracy")
            ->group(group);
}

void declare_passes(app::App& app, RenderOptions& o, const char* group)
{
    const auto of_paths = [&](const app::Option& option) {
        return option.only_with([&o] { return traces_paths(o); }, "--integrator path").group(group);
    };
    of_paths(
        app.add_option("--spp-offset", o.integrator.passes.offset,
                       "index of the first sample. Jobs with disjoint indices are parts of one run; exrmerge merges "
                       "their pictures"));
    app.add_option("--time-limit", o.integrator.passes.time_limit,
                   "end after this time [s]. Light paths: after the pass over the picture that exceeds it; --samples "
                   "is then the "
                   "most. Others: pixels that are not computed by then repeat their neighbours, in blocks of 8x8 "
                   "pixels at most")
        ->check(app::positive)
        ->default_str("")
        ->scene("accuracy")
        ->group(group);
    of_paths(
        app.add_option("--noise", o.integrator.passes.noise,
                       "end after the pass that brings the picture's noise to this: root mean square of the pixels' "
                       "standard errors over the mean of the picture, of luminance; --samples is then the most"))
        ->check(app::positive)
        ->default_str("")
        ->scene("accuracy");
}

void declare_sampling(app::App& app, RenderOptions& o)
{
    const char* group = "Accuracy";
    declare_integrator(app, o, group);
    o.option.samples =
        app.add_option(
               "--samples,--spp", o.sampling.samples,
               "samples of a pixel; 1 is taken at the pixel's centre, 16 smooth the edges. Without it 1; 16 for "
               "--integrator path, whose samples all lie at random")
            ->check(app::within(1, most_samples))
            ->no_rung_with([&o] { return ends_by_target(o); })
            ->default_str("")
            ->scene("accuracy")
            ->group(group);
    const auto of_several = [&](const app::Option& option) {
        return option.only_with([&o] { return o.sampling.samples > 1 || traces_paths(o); }, "--samples above 1")
            .scene("accuracy")
            .group(group);
    };
    of_several(app.add_choice<FilterKind>("--filter", o.sampling.filter,
                                          {{name(FilterKind::Box), FilterKind::Box},
                                           {name(FilterKind::Gaussian), FilterKind::Gaussian},
                                           {name(FilterKind::BlackmanHarris), FilterKind::BlackmanHarris}},
                                          "reconstruction filter of the samples"));
    of_several(app.add_option("--filter-width", o.sampling.filter_width,
                              "full width of the filter [pixels]; 0: the filter's own, 1 for box, else 3"))
        ->check(app::within(0, 64));
    app.add_option("--seed", o.sampling.seed,
                   "number of the pattern of samples, and of the paths of --certify; another for each frame")
        ->only_with([&o] { return o.sampling.samples > 1 || traces_paths(o) || !o.certify.empty(); },
                    "--samples above 1 or --certify")
        ->scene("accuracy")
        ->group(group);
    declare_passes(app, o, group);
    declare_certificate(app, o, group);
}

void declare_picture(app::App& app, RenderOptions& o)
{
    const char* group = "Picture";
    const auto exr = [&o] { return image_format(o.output) == ImageFormat::Exr; };
    const auto of_png = [&](const app::Option& option) {
        return option.only_with([&o, exr] { return !o.png.empty() || !exr(); }, "--png").group(group);
    };
    app.add_option(
           "--aov", o.aovs,
           "layers of the .exr beside R,G,B,A: Z, transmittance, direct, direct_<light>, multiscatter, emission, "
           "ground, solid, variance, background, all, none; with --integrator path standard_error and, which all "
           "leaves out, "
           "seconds "
           "of "
           "each pixel; commas between, or again")
        ->only_with(exr, "an .exr for --output")
        ->scene("picture")
        ->group(group);
    app.add_option(
           "--background", o.background,
           "none, sky, or r,g,b, drawn into .exr and .png. Without it the .exr has alpha, and the .png shows the "
           "sky: the one that lit the medium, else a clear blue day. With --integrator path the sky that lit the input "
           "lights the medium, or the one that --background sky, --sky or --sky-zenith, --sky-horizon, --sky-ground "
           "ask for")
        ->check(app::formed("none, sky, or r,g,b",
                            [](const std::string& text) {
                                return text.empty() || text == "none" || text == "sky" || app::is_colour(text);
                            }))
        ->scene("picture")
        ->group(group);
    app::declare_sky(app, o.sky, o.lights, group, "that which lit the medium, else a clear day");
    for (const app::Option& shape :
         {o.sky.option.sky, o.sky.option.zenith, o.sky.option.horizon, o.sky.option.ground, o.sky.option.haze})
        shape.only_with([&o] { return o.background.empty() || o.background == "sky" || !shows_light_grids(o); },
                        "--background sky");
    o.sky.option.ground.not_with([&o] { return o.option.ground.given(); }, "--ground-albedo");
    o.sky.option.haze.only_with(
        [&o, exr] {
            const bool drawn = !o.background.empty() || app::sky_asked(o.sky);
            return drawn || !o.png.empty() || !exr() || wants_background_layer(o);
        },
        "--background sky");
    o.option.exposure =
        of_png(app.add_option("--exposure", o.view.exposure,
                              "brightness of the .png [EV, +1 doubles]; without it found from the picture. Give it for "
                              "films, so that frames match"))
            ->default_str("")
            ->scene("picture");
    of_png(app.add_choice<ViewKind>("--view", o.view.kind,
                                    {{name(ViewKind::Filmic), ViewKind::Filmic},
                                     {name(ViewKind::Srgb), ViewKind::Srgb},
                                     {name(ViewKind::None), ViewKind::None}},
                                    "how the .png shows radiance; filmic: highlights rolled off, srgb: clipped, none: "
                                    "linear"))
        ->scene("picture");
    of_png(
        app.add_flag(
            "--progressive", o.progressive,
            "replace the .png while the picture is computed: one pixel of every 8x8, then of 4x4, 2x2 and all; light "
            "paths pass by pass. The picture at the end is the same. With --time-limit for a look in seconds"))
        ->configurable(false);
    of_png(app.add_choice<int>("--png-bits", o.png_bits, {{"8", 8}, {"16", 16}}, "bits a channel of the .png"))
        ->scene("picture");
}

}  // namespace

void declare(app::App& app, RenderOptions& o)
{
    app::declare_inputs(app, o.inputs,
                        ".vdb files, or - for standard input; their media add up, and each shades the others. Multiple "
                        "scattering of several files: p1solve all of them into one file first");
    app.add_option("-o,--output", o.output, "picture to write: .exr, .png, or - for an .exr on standard output")
        ->required()
        ->type_name("FILE")
        ->writes_file(app::FileKind::Picture);
    app.add_option("--png", o.png, "second picture to write, a .png to look at")
        ->type_name("FILE")
        ->writes_file(app::FileKind::Png)
        ->configurable(false);
    app::declare_density(app, o.density)->group("Medium");
    app::declare_periodic(app, o.periodic, "Medium");
    app::declare_medium(app, o.medium);
    app::declare_lights(app, o.lights);
    app::declare_solids(app, o.solids, "Solids");
    o.option.solid_rays =
        app.add_option("--solid-rays", o.integrator.solid_rays,
                       "rays from each point of a solid, by which light from the sky, the medium and other solids is "
                       "found; sun and lamps are exact. Noise falls as the square root")
            ->check(app::within(1, 65536))
            ->not_with([&o] { return traces_paths(o); }, "--integrator path")
            ->scene("accuracy")
            ->group("Solids");
    o.option.ground =
        app.add_option("--ground-albedo", o.ground_albedo,
                       "albedo of a Lambertian ground beneath the media, 0 to 1: an endless, opaque plane one voxel "
                       "below the centres of the lowest voxels. Without it the ground that p1solve --ground-albedo put "
                       "into the file, else none. Other integrators than path draw the ground of the file alone")
            ->check(app::within(0, 1))
            ->only_with([&o] { return traces_paths(o); }, "--integrator path")
            ->not_with([&o] { return o.integrator.vertices > 0; }, "--gather, which has the ground of the file")
            ->default_str("")
            ->scene("solids")
            ->group("Medium");
    declare_camera(app, o);
    declare_sampling(app, o);
    declare_picture(app, o);
    app::declare_effects(app, o.effects);
    app::declare_accuracy_error(app, o.effects).only_with([&o] { return o.multiple; }, "--multiple");
    app.takes_rungs();
    app.examples({{"a cloud framed, lit and exposed automatically",
                   "fractalgen --size 96 -o cloud.vdb && render cloud.vdb --resolution 256x192 -o cloud.png"},
                  {"sun from the right, all orders of scattering until the noise is 20 %, as .exr and as .png",
                   "render cloud.vdb --sun 1,0.4,0 --integrator path --noise 0.2 --resolution 64 -o c.exr --png c.png"},
                  {"a pipe of all stages, with multiple scattering and 4 samples a pixel",
                   "fractalgen --size 48 -o - | illuminate - --sun 0.3,1,0.2 -o - | p1solve - --albedo 0.999 -o - | "
                   "render - --samples 4 --resolution 128 -o lit.png"}});
}

}  // namespace vdbcloud
