// render: a picture of clouds from any side, or from within.
//
//   render lit.vdb -o cloud.exr --png cloud.png
//   render cloud.vdb -o cloud.exr                 framed, lit and exposed by itself
//
// Second pass of Kajiya & Von Herzen 1984: along each camera ray, the light that reaches each point
// (transmittance grids of illuminate, phi and flux of p1solve where they are there) times the phase function,
// thinned on its way to the eye. With --integrator path: all orders of scattering, by unbiased light paths.
#include "camera.h"
#include "certify.h"
#include "effects.h"
#include "multiple.h"
#include "progressive.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/shortest.h"
#include "vdbcloud/optics/solid_rays.h"
#include "vdbcloud/render/render_plan.h"

using namespace vdbcloud;

namespace {

void write_pictures(app::App& app, const RenderOptions& o, const LoadedScene& loaded, const Film& film,
                    const CameraView& view, bool background_in_exr, const RenderCost& cost,
                    const std::optional<Certificate>& certificate)
{
    const auto phase = app.phase("write");
    ImageOptions image;
    image.draw_background = background_in_exr;
    image.background_layer = wants_background_layer(o);
    image.png_bits = o.png_bits;
    image.view = o.view;
    ImageMetadata metadata = image_metadata(app, o, loaded, o.view.exposure);
    if (traces_paths(o)) stamp_samples(metadata, loaded.scene, view, o, cost.passes.samples);
    if (cost.coarse.coarseness > 1) metadata.numbers.push_back({"vdbcloud:coarseness", double(cost.coarse.coarseness)});
    if (certificate) stamp_certificate(metadata, *certificate, o.correct);
    for (const std::string& path : {o.output, o.png}) {
        if (path.empty()) continue;
        image.no_clobber = app.no_clobber() && !(o.shown && path == shown_png(o));
        write_image(path, film, view, metadata, image, app.warnings());
        app.report()["outputs"].push_back({{"path", path}});
    }
    if (certificate) write_error_png(app, o, film, *certificate, view, metadata);
}

/// Throws for a camera within a solid: the picture would be black.
void require_open_camera(const Scene& scene, const CameraView& view)
{
    const Vec3d eye = view.ray(view.size().width / 2.0, view.size().height / 2.0).origin;
    for (const Solid& solid : scene.solids)
        if (SolidRays({solid}).inside(eye))
            throw InputError("the camera at " + shortest(eye) + " is within the " + described(solid) +
                             ": expected it outside; give another --camera");
}

void render(app::App& app, RenderOptions& o)
{
    if (traces_paths(o)) o.integrator.kind = Integrator::Path;
    choose_samples(o);
    const ImageSize size = image_size(o);
    LoadedScene loaded = load_scene(app, o);
    const auto background = chosen_background(o, loaded.lights, loaded.up, loaded.sky);
    loaded.scene.background = background.sky;
    if (loaded.effects.on(Effect::Sky)) loaded.scene.sky = lighting_sky(o, loaded, background.light);
    o.integrator.passes.over_background = background.in_exr;
    if (shows_light_grids(o) && app::sky_asked(o.sky) && loaded.sky && !(background.light == *loaded.sky))
        app.warnings()(
            "the picture shows the sky asked for, and another sky lit the medium: for one sky run p1solve with it");
    app::tell_darkness(app, loaded.lights, glows(loaded.scene));
    const CameraView view(chosen_camera(app, o, loaded, size), size);
    require_open_camera(loaded.scene, view);
    report_picture(app, o, loaded, view);
    if (const std::string accuracy = accuracy_of_light(loaded); !accuracy.empty())
        app.say("accuracy of the light: " + accuracy);

    tell_left_out(app, o, loaded);
    auto layers = render_layers(loaded.scene, wanted_layers(o), o.integrator.kind);
    if (o.option.certify.given())
        for (const LayerSpec& layer : certificate_layers(loaded.scene, o.correct)) layers.push_back(layer);
    Film film(size, layers);
    if (app.dry_run()) return report_estimate(app, o, loaded, film, view);
    for (const std::string& path : {o.output, o.png})
        if (!path.empty()) require_image_writer(path);
    app::require_memory(least_plan(o, loaded, film));
    o.integrator.passes.show = shower(app, o, loaded, view);
    RenderCost cost;
    {
        const auto phase = app.phase("render");
        cost = render_image(film, loaded.scene, view, o.sampling, o.integrator, app.progress("render"));
    }

    std::optional<Certificate> certificate;
    if (o.option.certify.given()) certificate = certify_picture(app, o, loaded, film, view);
    if (!o.option.exposure.given()) o.view.exposure = auto_exposure(film);
    report_cost(app, cost, render_work(film, loaded.scene, o.integrator, cost), o.view.exposure);
    app.add_work(writing_work(o));
    loaded.costs += cost.costs;
    app::tell_costs(app, o.effects, loaded.effects, loaded.costs);
    if (traces_paths(o)) report_passes(app, cost.passes);
    report_coarseness(app, o, cost.coarse, film);
    write_pictures(app, o, loaded, film, view, background.in_exr, cost, certificate);
    if (certificate) require_reached(o, *certificate);
}

}  // namespace

int main(int argc, char** argv)
{
    app::App app("render", "A picture of clouds, fog, smoke or fire in .vdb files.");
    app.reads_grids();
    app.never_clobbers();
    app.takes_frames(/*several_inputs=*/true);
    RenderOptions options;
    declare(app, options);
    return app.run(argc, argv, [&] {
        app.each_frame([&](const auto& place) {
            RenderOptions frame = options;
            for (std::string& input : frame.inputs) place(input);
            place(frame.output);
            place(frame.png);
            place(frame.error_png);
            render(app, frame);
        });
    });
}
