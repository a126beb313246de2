#include "vdbcloud/render/image_out.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/half_range.h"
#include "vdbcloud/render/picture_file.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbcloud {

namespace {

/// Where each channel of the file comes from.
struct Channels {
    std::vector<std::string> names;
    std::vector<OIIO::TypeDesc> types;
    std::vector<int> sources;    // channel of the film
    std::vector<size_t> layers;  // layer of the film
};

std::string channel_name(const LayerSpec& layer, const std::string& channel)
{
    return layer.name.empty() || layer.name == channel ? channel : layer.name + "." + channel;
}

Channels channels_of(const Film& film, const ImageOptions& options)
{
    Channels out;
    for (size_t l = 0; l < film.layers().size(); ++l) {
        const LayerSpec& layer = film.layers()[l];
        if (layer.name == "background" && !options.background_layer) continue;
        for (size_t c = 0; c < layer.channels.size(); ++c) {
            out.names.push_back(channel_name(layer, layer.channels[c]));
            out.sources.push_back(film.offset(int(l)) + int(c));
            out.layers.push_back(l);
        }
    }
    return out;
}

/// Half where a layer says so and the values that are written fit into halves, else float: all channels of a layer
/// alike.
void choose_types(Channels& channels, const Film& film, const std::vector<float>& pixels, const Warn& listener)
{
    const size_t count = channels.sources.size();
    std::vector<HalfRange> ranges(count);
    for (size_t k = 0; k < pixels.size(); ++k) ranges[k % count].add(pixels[k]);
    for (size_t first = 0, end = 0; first < count; first = end) {
        bool above = false, faint = false;
        for (; end < count && channels.layers[end] == channels.layers[first]; ++end) {
            above = above || ranges[end].above();
            faint = faint || ranges[end].faint();
        }
        const LayerSpec& layer = film.layers()[channels.layers[first]];
        if (layer.half && above)
            warn(listener, "layer '" + (layer.name.empty() ? "beauty" : layer.name) +
                               "' has values above 65504 and is stored as float, not half");
        const bool half = layer.half && !above && !faint;
        channels.types.insert(channels.types.end(), end - first, half ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::FLOAT);
    }
}

void set_matrix(OIIO::ImageSpec& spec, const char* key, const Matrix44& matrix)
{
    float values[16];
    std::copy(matrix.begin(), matrix.end(), values);
    spec.attribute(key, OIIO::TypeDesc::TypeMatrix44, values);
}

void set_texts(OIIO::ImageSpec& spec, const ImageMetadata& metadata)
{
    spec.attribute("Software", metadata.creator);
    spec.attribute("creator", metadata.creator);
    spec.attribute("history", metadata.history);
    spec.attribute("DateTime", metadata.date_time);
    for (const auto& [key, text] : metadata.texts) spec.attribute(key, text);
    for (const auto& [key, number] : metadata.numbers) spec.attribute(key, float(number));
}

OIIO::ImageSpec exr_spec(const Film& film, const CameraView& view, const ImageMetadata& metadata,
                         const Channels& channels)
{
    const PixelWindow w = film.window();
    OIIO::ImageSpec spec(w.width(), w.height(), int(channels.names.size()), OIIO::TypeDesc::HALF);
    spec.x = w.x0;
    spec.y = w.y0;
    spec.full_width = film.size().width;
    spec.full_height = film.size().height;
    spec.channelnames = channels.names;
    spec.channelformats = channels.types;
    for (size_t c = 0; c < channels.names.size(); ++c) {
        if (channels.names[c] == "A") spec.alpha_channel = int(c);
        if (channels.names[c] == "Z") spec.z_channel = int(c);
    }
    set_texts(spec, metadata);
    spec.attribute("compression", "zip");
    spec.attribute("oiio:ColorSpace", "Linear");
    const float rec709[8] = {0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f};
    spec.attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), rec709);
    spec.attribute("PixelAspectRatio", float(film.size().pixel_aspect));
    const Camera& camera = view.camera();
    const bool perspective = camera.projection == Projection::Perspective;
    spec.attribute("screenWindowWidth", float(perspective ? 2 * std::tan(camera.fov * pi / 360) : camera.width));
    const float centre[2] = {0, 0};
    spec.attribute("screenWindowCenter", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, OIIO::TypeDesc::VEC2), centre);
    set_matrix(spec, "worldtocamera", view.world_to_camera());
    set_matrix(spec, "worldToNDC", view.world_to_ndc());
    return spec;
}

std::vector<float> exr_pixels(const Film& film, const Channels& channels, bool draw_background)
{
    const int beauty = film.offset(film.find(""));
    const PixelWindow w = film.window();
    std::vector<float> out;
    out.reserve(size_t(w.width()) * size_t(w.height()) * channels.sources.size());
    for (int j = w.y0; j < w.y1; ++j)
        for (int i = w.x0; i < w.x1; ++i) {
            const float* pixel = film.pixel(i, j);
            const Vec3d drawn = draw_background ? composited(film, i, j) : Vec3d(0, 0, 0);
            for (const int source : channels.sources) {
                const int c = source - beauty;
                const bool replaced = draw_background && c >= 0 && c < 4;
                out.push_back(!replaced ? pixel[source] : c < 3 ? float(drawn[c]) : 1.0f);
            }
        }
    return out;
}

Bytes encoded_exr(const std::string& path, const Film& film, const CameraView& view, const ImageMetadata& metadata,
                  const ImageOptions& options, const Warn& listener)
{
    Channels channels = channels_of(film, options);
    const auto pixels = exr_pixels(film, channels, options.draw_background);
    choose_types(channels, film, pixels, listener);
    return encoded(path, "exr", exr_spec(film, view, metadata, channels), OIIO::TypeDesc::FLOAT, pixels.data());
}

template<typename Integer>
std::vector<Integer> quantised(const Film& film, const ViewOptions& view)
{
    const double most = double(std::numeric_limits<Integer>::max());
    const PixelWindow w = film.window();
    std::vector<Integer> out;
    for (int j = w.y0; j < w.y1; ++j)
        for (int i = w.x0; i < w.x1; ++i) {
            const Vec3d shown = displayed(composited(film, i, j), view);
            for (int c = 0; c < 3; ++c) out.push_back(Integer(std::lround(shown[c] * most)));
        }
    return out;
}

Bytes encoded_png(const std::string& path, const Film& film, const ImageMetadata& metadata, const ImageOptions& options)
{
    const PixelWindow w = film.window();
    const bool wide = options.png_bits == 16;
    OIIO::ImageSpec spec(w.width(), w.height(), 3, wide ? OIIO::TypeDesc::UINT16 : OIIO::TypeDesc::UINT8);
    set_texts(spec, metadata);
    spec.attribute("oiio:ColorSpace", options.view.kind == ViewKind::None ? "Linear" : "sRGB");
    if (film.size().pixel_aspect != 1) spec.attribute("PixelAspectRatio", float(film.size().pixel_aspect));
    if (wide) return encoded(path, "png", spec, OIIO::TypeDesc::UINT16, quantised<uint16_t>(film, options.view).data());
    return encoded(path, "png", spec, OIIO::TypeDesc::UINT8, quantised<uint8_t>(film, options.view).data());
}

void check_beauty(const Film& film)
{
    const int layer = film.find("");
    if (layer < 0 || film.layers()[size_t(layer)].channels != std::vector<std::string>{"R", "G", "B", "A"})
        throw InputError("film: expected a beauty layer of channels R, G, B, A");
}

}  // namespace

void write_image(const std::string& path, const Film& film, const CameraView& view, const ImageMetadata& metadata,
                 const ImageOptions& options, const Warn& listener)
{
    check_beauty(film);
    if (options.png_bits != 8 && options.png_bits != 16)
        throw InputError("png bits " + std::to_string(options.png_bits) + ": expected 8 or 16");
    const bool exr = image_format(path) == ImageFormat::Exr;
    const auto make = [&] {
        return exr ? encoded_exr(path, film, view, metadata, options, listener)
                   : encoded_png(path, film, metadata, options);
    };
    write_picture_file(path, options.no_clobber, make);
}

}  // namespace vdbcloud
