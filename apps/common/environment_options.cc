#include "environment_options.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/render/image_in.h"
#include "vdbcloud/scene/sky.h"

namespace vdbcloud::app {

namespace {

std::shared_ptr<const Panorama> read_panorama(const std::string& path)
{
    Pixels image = read_pixels(path);
    const size_t texels = size_t(image.width) * size_t(image.height), channels = size_t(image.channels);
    std::vector<float> rgb(texels * 3);
    for (size_t n = 0; n < texels; ++n)
        for (size_t c = 0; c < 3; ++c) rgb[3 * n + c] = image.values[n * channels + (channels < 3 ? 0 : c)];
    try {
        return std::make_shared<Panorama>(image.width, image.height, std::move(rgb));
    } catch (const InputError& e) {
        throw InputError(printable(path) + ": " + e.what());
    }
}

}  // namespace

const std::shared_ptr<const Panorama>& EnvironmentOptions::panorama() const
{
    if (!read_) read_ = read_panorama(path);
    return read_;
}

std::vector<Light> EnvironmentOptions::suns(const Vec3d& up) const
{
    return asked() ? environment_suns(*panorama(), turn, gain, up) : std::vector<Light>{};
}

void declare_environment(App& app, EnvironmentOptions& o)
{
    const char* group = "Environment";
    const Option picture =
        app.add_option("--environment", o.path,
                       "a picture of all directions (.exr, .hdr; latitude by longitude, twice as wide as high, linear "
                       "Rec. 709): a sky for p1solve and render, and its bright spots as suns for all")
            ->type_name("FILE")
            ->reads_files()
            ->scene("sky", "environment")
            ->group(group);
    app.add_option("--environment-turn", o.turn,
                   "degrees that the environment is turned by, counterclockwise as seen from above; at 0 the middle of "
                   "the picture lies along z where y is up, along x where z is")
        ->check(within(-360, 360))
        ->needs(picture)
        ->scene("sky", "environment-turn")
        ->group(group);
    app.add_option("--environment-gain", o.gain, "what the environment's radiance is multiplied with")
        ->check(nonnegative)
        ->needs(picture)
        ->scene("sky", "environment-gain")
        ->group(group);
}

}  // namespace vdbcloud::app
