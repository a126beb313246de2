#include "progressive.h"

namespace vdbcloud {

namespace {

std::string blocks_of(int edge) { return "blocks of " + std::to_string(edge) + "x" + std::to_string(edge) + " pixels"; }

}  // namespace

ShowPicture shower(app::App& app, RenderOptions& o, const LoadedScene& loaded, const CameraView& view)
{
    if (!o.progressive) return {};
    return [&](const Film& film, const ShownPicture& picture) {
        ImageOptions image;
        image.no_clobber = app.no_clobber() && !o.shown;
        image.png_bits = o.png_bits;
        image.view = o.view;
        if (!o.option.exposure.given()) image.view.exposure = auto_exposure(film);
        ImageMetadata metadata = image_metadata(app, o, loaded, image.view.exposure);
        metadata.texts.push_back({"vdbcloud:unfinished", traces_paths(o)
                                                             ? std::to_string(picture.samples) + " samples a pixel"
                                                             : blocks_of(picture.coarseness)});
        write_image(shown_png(o), film, view, metadata, image);
        o.shown = true;
    };
}

void report_coarseness(app::App& app, const RenderOptions& o, const CoarseReport& found, const Film& film)
{
    if (found.coarseness == 0 || !(o.integrator.passes.time_limit > 0)) return;
    const PixelWindow w = film.window();
    const uint64_t all = uint64_t(w.width()) * uint64_t(w.height());
    app.report()["picture"]["coarseness"] = found.coarseness;
    app.report()["picture"]["computed_pixels"] = found.pixels;
    if (found.pixels < all)
        app.say("the time limit ended the picture at " + blocks_of(found.coarseness) + ": " +
                std::to_string(found.pixels) + " of " + std::to_string(all) +
                " pixels are computed, the others repeat their neighbours");
}

}  // namespace vdbcloud
