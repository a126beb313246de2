#include "certify.h"

#include "version.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/sources.h"
#include "vdbcloud/render/merge.h"
#include "vdbcloud/render/render_plan.h"
#include "vdbcloud/render/scene_digest.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

/// Memory of the library that writes pictures other than .exr, which is loaded when it is needed [bytes].
constexpr double writer_of_pictures = 95e6;

/// "irradiance" for a sun, "intensity" for a lamp.
std::string strength_name(const Light& light) { return light.kind().parameters[0].name; }

nlohmann::json triple(const Vec3d& v) { return {v[0], v[1], v[2]}; }

}  // namespace

ImageMetadata image_metadata(const app::App& app, const RenderOptions& o, const LoadedScene& loaded, double exposure)
{
    ImageMetadata out;
    out.history = app.history(loaded.history);
    out.creator = app.get_name() + " " + app::project_version();
    out.texts = {{"vdbcloud:integrator", name(o.integrator.kind)},
                 {"vdbcloud:up_axis", up_axis_words.word(loaded.up)},
                 {"vdbcloud:alpha", "1 - mean over r, g, b of the transmittance"},
                 {"vdbcloud:Z", "depth along the view axis where the transmittance falls to 0.5; 1e30: it does not"}};
    if (loaded.scene.periodic != std::array<bool, 3>{})
        out.texts.push_back({"vdbcloud:periodic", periodic_text(loaded.scene.periodic)});
    if (loaded.scene.ground)
        out.texts.push_back({"vdbcloud:ground_albedo", app::shortest(loaded.scene.ground->albedo)});
    for (const Light& light : loaded.scene.lights)
        out.texts.push_back({"vdbcloud:light_" + light.name, app::described(light) + ", " + strength_name(light) + " " +
                                                                 app::shortest(light.strength())});
    for (size_t v = 0; v < loaded.scene.volumes.size(); ++v) {
        const Volume& volume = loaded.scene.volumes[v];
        const Medium& m = volume.medium;
        if (volume.collided.scaling.delta_f > 0 && !traces_paths(o))
            out.texts.push_back({"vdbcloud:scaled_medium_" + std::to_string(v),
                                 "light, alpha and background in the delta-scaled medium (1 - f w0) sigma_t, f " +
                                     app::shortest(volume.collided.scaling.delta_f) + ", g' " +
                                     app::shortest(volume.collided.scaling.mean_cosine())});
        out.texts.push_back({"vdbcloud:medium_" + std::to_string(v),
                             "sigma_t per density " + app::shortest(m.sigma_t_per_density) + ", albedo " +
                                 app::shortest(m.albedo) + ", " + m.phase.text()});
    }
    if (const std::string all = app::left_out(loaded.effects); !all.empty())
        out.texts.push_back({"vdbcloud:left_out", all});
    if (const std::string accuracy = accuracy_of_light(loaded); !accuracy.empty())
        out.texts.push_back({"vdbcloud:accuracy", accuracy});
    out.numbers = {{"vdbcloud:exposure", exposure}, {picture::samples, double(o.sampling.samples)}};
    if (o.integrator.vertices > 0) out.numbers.push_back({"vdbcloud:gather", double(o.integrator.vertices)});
    return out;
}

void stamp_samples(ImageMetadata& to, const Scene& scene, const CameraView& view, const RenderOptions& o,
                   uint64_t samples)
{
    const uint64_t first = o.integrator.passes.offset;
    to.texts.push_back({picture::seed, std::to_string(o.sampling.seed)});
    to.texts.push_back({picture::sample_ranges, range_text({first, first + samples})});
    to.texts.push_back({picture::scene, scene_digest(scene, view, o.sampling, o.integrator)});
    for (auto& [key, number] : to.numbers)
        if (key == picture::samples) number = double(samples);
}

void report_passes(app::App& app, const PassReport& passes)
{
    app.report()["picture"]["samples"] = passes.samples;
    app.report()["accuracy"]["noise"] = passes.noise;
    app.say(std::to_string(passes.samples) + " samples a pixel, noise " + app::brief(passes.noise));
}

void report_picture(app::App& app, const RenderOptions& o, const LoadedScene& loaded, const CameraView& view)
{
    const Camera& camera = view.camera();
    nlohmann::json& report = app.report();
    report["camera"] = {{"projection", camera.projection == Projection::Perspective ? "perspective" : "orthographic"},
                        {"position", triple(camera.position)},
                        {"look_at", triple(camera.look_at)},
                        {"up", triple(view.up())},
                        {"fov", camera.fov},
                        {"ortho_width", camera.width}};
    report["picture"] = {{"width", view.size().width}, {"height", view.size().height}, {"samples", o.sampling.samples}};
    for (const Light& light : loaded.scene.lights)
        report["lights"].push_back({{"name", light.name},
                                    {"light", app::described(light)},
                                    {strength_name(light), triple(light.strength())},
                                    {"automatic", loaded.automatic_light}});
    for (const Volume& volume : loaded.scene.volumes)
        report["media"].push_back({{"sigma_t_per_density", triple(volume.medium.sigma_t_per_density)},
                                   {"albedo", triple(volume.medium.albedo)},
                                   {"g", volume.medium.phase.mean_cosine()},
                                   {"phase", volume.medium.phase.name()},
                                   {"active_voxels", volume.density->activeVoxelCount()}});
}

Workload writing_work(const RenderOptions& o)
{
    Workload work;
    for (const std::string& path : {o.output, o.png})
        if (!path.empty() && image_format(path) == ImageFormat::Png && work.of("picture_library") == 0)
            work.add("picture_library", 1);
    return work;
}

void report_cost(app::App& app, const RenderCost& cost, const Workload& work, double exposure)
{
    app.add_work(work);
    app.report()["counts"] = {{"rays", cost.rays}, {"cells", cost.cells}};
    app.report()["accuracy"] = {{"unconverged_rays", cost.unconverged}};
    app.report()["exposure"] = exposure;
    if (cost.unconverged > 0)
        app.warnings()(std::to_string(cost.unconverged) + " of " + std::to_string(cost.rays) +
                       " rays met the finest level before their tolerance");
}

app::Plan least_plan(const RenderOptions& o, const LoadedScene& loaded, const Film& film)
{
    app::Plan plan;
    plan.way_out = "a coarser density, or fewer pixels";
    plan.bytes = render_bytes(film, loaded.scene, o.integrator) + certificate_bytes(o, loaded, film);
    if (o.progressive)
        plan.bytes += double(film.channels()) * film.window().width() * film.window().height() * sizeof(float);
    // The allocator keeps what the maps for rays took.
    if (!o.png.empty() || image_format(o.output) != ImageFormat::Exr) plan.bytes += writer_of_pictures;
    return plan;
}

void report_estimate(app::App& app, const RenderOptions& o, const LoadedScene& loaded, const Film& film,
                     const CameraView& view)
{
    app::Plan plan = least_plan(o, loaded, film);
    plan.bytes += loaded.planned.grid_bytes;
    plan.bytes = std::max(plan.bytes, loaded.planned.bytes);
    RenderCost cost = expected_cost(film, loaded.scene, view, o.sampling, o.integrator);
    plan.work = render_work(film, loaded.scene, o.integrator, cost);
    if (const double most = o.integrator.passes.time_limit * app.threads(), all = plan.work.seconds();
        most > 0 && all > most) {
        cost.rays = uint64_t(double(cost.rays) * most / all);
        cost.cells = uint64_t(double(cost.cells) * most / all);
        plan.work = render_work(film, loaded.scene, o.integrator, cost);
    }
    plan.work += certificate_work(app, o, loaded, film, view);
    plan.work += loaded.planned.work;
    plan.work += writing_work(o);
    const PixelWindow w = film.window();
    std::string task = "render " + std::to_string(w.width()) + "x" + std::to_string(w.height()) + " pixels";
    if (o.integrator.passes.time_limit > 0)
        task += " for " + app::brief(o.integrator.passes.time_limit) + " s or up to all samples";
    app::tell(app, plan, task);
}

}  // namespace vdbcloud
