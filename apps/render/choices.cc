// What follows from the options before a scene is read: kinds of light, size, layers, background.
#include "options.h"

#include "vdbcloud/core/error.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

std::vector<std::string> all_words(const RenderOptions& o)
{
    std::vector<std::string> words;
    for (const auto& given : o.aovs)
        for (const auto& word : app::split(given, ','))
            if (!word.empty()) words.push_back(word);
    return words;
}

bool one_of(const std::string& word, std::initializer_list<const char*> words)
{
    return std::any_of(words.begin(), words.end(), [&](const char* w) { return word == w; });
}

/// A scene file says which sky there is, not that the .exr shows it.
bool of_scene(const app::SkyOptions& sky)
{
    return sky.option.sky.by_scene() || sky.option.zenith.by_scene() || sky.option.horizon.by_scene() ||
           sky.option.ground.by_scene();
}

}  // namespace

/// The numbers of pixels in `text`, between characters `at`; none if one of them is no number of pixels.
std::vector<int> pixels(const std::string& text, char at)
{
    std::vector<int> all;
    for (const std::string& word : app::split(text, at)) {
        const auto value = app::number(word);
        if (!value || *value != std::floor(*value) || std::abs(*value) > 65536) return {};
        all.push_back(int(*value));
    }
    return all;
}

bool traces_paths(const RenderOptions& o) { return o.integrator.kind == Integrator::Path || o.integrator.vertices > 0; }

bool shows_light_grids(const RenderOptions& o) { return !traces_paths(o) || o.integrator.vertices > 0; }

bool ends_by_target(const RenderOptions& o)
{
    return traces_paths(o) && (o.integrator.passes.time_limit > 0 || o.integrator.passes.noise > 0);
}

void choose_samples(RenderOptions& o)
{
    if (!traces_paths(o) || o.option.samples.given() || o.option.samples.by_rung()) return;
    o.sampling.samples = ends_by_target(o) ? most_samples : 16;
}

Sky chosen_sky(const RenderOptions& o, const std::vector<Light>& lights, UpAxis up, const std::optional<Sky>& lit_by)
{
    if (!lit_by && o.background != "sky" && !app::sky_asked(o.sky)) return {};
    return app::sky_of(o.sky, o.lights, lights, vector_of(up), lit_by);
}

const std::string& shown_png(const RenderOptions& o) { return o.png.empty() ? o.output : o.png; }

ImageSize image_size(const RenderOptions& o)
{
    ImageSize size;
    const std::vector<int> sides = pixels(o.resolution, 'x');
    size.width = sides.front();
    size.height = sides.back();
    size.pixel_aspect = o.pixel_aspect;
    if (!o.crop.empty()) {
        const std::vector<int> edges = pixels(o.crop, ',');
        size.crop = {edges[0], edges[1], edges[2], edges[3]};
        const PixelWindow& c = size.crop;
        if (c.x0 < 0 || c.y0 < 0 || c.x0 >= c.x1 || c.y0 >= c.y1 || c.x1 > size.width || c.y1 > size.height)
            throw UsageError("--crop " + printable(o.crop) + ": expected x0 < x1, y0 < y1, within 0,0," +
                             std::to_string(size.width) + "," + std::to_string(size.height));
    }
    return size;
}

std::vector<std::string> wanted_layers(const RenderOptions& o)
{
    std::vector<std::string> layers = all_words(o);
    layers.erase(std::remove_if(layers.begin(), layers.end(),
                                [](const auto& w) {
                                    return one_of(w, {"none", "background"});
                                }),
                 layers.end());
    return layers;
}

bool wants_background_layer(const RenderOptions& o)
{
    const auto words = all_words(o);
    return std::any_of(words.begin(), words.end(), [](const auto& w) { return one_of(w, {"all", "background"}); });
}

ChosenBackground chosen_background(const RenderOptions& o, const std::vector<Light>& lights, UpAxis up,
                                   const std::optional<Sky>& lit_by)
{
    ChosenBackground out;
    if (o.background == "none") return out;
    if (o.background.empty() || o.background == "sky") {
        out.light = app::sky_of(o.sky, o.lights, lights, vector_of(up), lit_by);
        out.sky = out.light.drawn();
        out.in_exr = !o.background.empty() || (app::sky_asked(o.sky) && !of_scene(o.sky));
        return out;
    }
    const Vec3d colour = app::colour_asked("--background", o.background, "none, sky, or r,g,b");
    out.sky = out.light = GradientSky{colour, colour, colour, GradientSky().haze, vector_of(up)};
    out.in_exr = true;
    return out;
}

}  // namespace vdbcloud
