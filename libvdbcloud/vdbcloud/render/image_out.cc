#include "vdbcloud/render/image_out.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/half_range.h"
#include "vdbcloud/render/exr_file.h"
#include "vdbcloud/render/picture_module.h"

#include <OpenEXR/ImfChromaticitiesAttribute.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfStandardAttributes.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbcloud {

namespace {

/// Where each channel of the file comes from.
struct Channels {
    std::vector<std::string> names;
    std::vector<bool> halves;
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
        if (!layer.stored || (layer.name == "background" && !options.background_layer)) continue;
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
        channels.halves.insert(channels.halves.end(), end - first, half);
    }
}

Imath::M44f attribute(const Matrix44& matrix)
{
    Imath::M44f out;
    std::copy(matrix.begin(), matrix.end(), out.getValue());
    return out;
}

Imf::Header exr_header(const Film& film, const CameraView& view, const ImageMetadata& metadata)
{
    const PixelWindow w = film.window();
    const Camera& camera = view.camera();
    const bool perspective = camera.projection == Projection::Perspective;
    const double screen = perspective ? 2 * std::tan(camera.fov * pi / 360) : camera.width;
    Imf::Header header(film.size().width, film.size().height, Imath::Box2i({w.x0, w.y0}, {w.x1 - 1, w.y1 - 1}),
                       float(film.size().pixel_aspect), Imath::V2f(0, 0), float(screen));
    header.compression() = Imf::ZIP_COMPRESSION;
    set_attributes(header, metadata);
    Imf::addCapDate(header, metadata.date_time);
    const Imf::Chromaticities rec709({0.64f, 0.33f}, {0.30f, 0.60f}, {0.15f, 0.06f}, {0.3127f, 0.3290f});
    Imf::addChromaticities(header, rec709);
    Imf::addWorldToCamera(header, attribute(view.world_to_camera()));
    Imf::addWorldToNDC(header, attribute(view.world_to_ndc()));
    return header;
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
    std::vector<ExrChannel> stored;
    const size_t count = channels.names.size();
    for (size_t c = 0; c < count; ++c)
        stored.push_back({channels.names[c], channels.halves[c], pixels.data() + c, count});
    return encoded_exr(path, exr_header(film, view, metadata), stored);
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
    const bool linear = options.view.kind == ViewKind::None;
    PngPicture png{w.width(), w.height(), options.png_bits, nullptr, film.size().pixel_aspect, linear, metadata};
    const auto encoded = [&](const auto& values) {
        png.values = values.data();
        Bytes bytes;
        const std::string trouble = picture_module(path).encode_png(png, bytes);
        if (!trouble.empty()) throw IoError(printable(path) + ": cannot encode png: " + printable(trouble));
        return bytes;
    };
    if (options.png_bits == 16) return encoded(quantised<uint16_t>(film, options.view));
    return encoded(quantised<uint8_t>(film, options.view));
}

void check_beauty(const Film& film)
{
    const int layer = film.find("");
    if (layer < 0 || film.layers()[size_t(layer)].channels != std::vector<std::string>{"R", "G", "B", "A"})
        throw InputError("film: expected a beauty layer of channels R, G, B, A");
}

}  // namespace

void require_image_writer(const std::string& path)
{
    if (image_format(path) == ImageFormat::Png) picture_module(path);
}

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
