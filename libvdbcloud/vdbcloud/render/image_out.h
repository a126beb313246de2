#pragma once
// Pictures on disk: .exr with every layer and its metadata, .png for looking at.
#include "vdbcloud/render/film.h"
#include "vdbcloud/render/view.h"
#include "vdbcloud/scene/camera.h"

#include <string>
#include <utility>
#include <vector>

namespace vdbcloud {

enum class ImageFormat { Exr, Png };

/// By extension, in any case: .exr or .png. "-" and a device (/dev/...) are exr. Throws UsageError for
/// others.
ImageFormat image_format(const std::string& path);

/// Whether pictures of this kind can be written here, to ask before a picture is computed: .png needs OpenImageIO, a
/// module that is opened at run time. Throws UsageError as image_format() does; IoError, path first: the module cannot
/// be opened.
void require_image_writer(const std::string& path);

/// Metadata of a picture. No clock and no host name: equal runs make equal bytes.
struct ImageMetadata {
    std::string creator;                                     ///< "render 0.1.0"; also OpenEXR's Software
    std::string history;                                     ///< one command line a line, oldest first
    std::string date_time = "1970:01:01 00:00:00";           ///< OpenImageIO would write the clock's
    std::vector<std::pair<std::string, std::string>> texts;  ///< "vdbcloud:..."
    std::vector<std::pair<std::string, double>> numbers;     ///< "vdbcloud:..."
};

struct ImageOptions {
    bool no_clobber = false;
    bool draw_background = false;   ///< exr: background into R, G, B, and A = 1; png always shows it
    bool background_layer = false;  ///< exr: also as a layer of its own
    int png_bits = 8;               ///< 8 or 16
    ViewOptions view;               ///< png
};

/// Writes a film whose beauty layer is R, G, B, A, premultiplied, whole or not at all (core/atomic_file.h).
///
/// exr: scan lines, zip; the display window is the whole picture, the data window the film's; linear Rec.
/// 709. Layers are channels LAYER.CHANNEL ("Z" stays "Z"): half where the layer says so and halves hold
/// its values, else float: with a value above 65504 (a warning says so), or where more than an eighth of the non-zero
/// values of a channel are below 6.1e-5, so that halves would round them away. Attributes worldToCamera, worldToNDC,
/// chromaticities, Software, creator, history, DateTime. png: beauty over background, exposed and encoded by the view,
/// of the film's window only, no alpha.
///
/// Throws IoError, path first (full disk, missing folder, closed pipe), UsageError for a png to "-",
/// InputError.
void write_image(const std::string& path, const Film&, const CameraView&, const ImageMetadata&,
                 const ImageOptions& = {}, const Warn& = {});

/// Attributes of maps by column. Positions and steps are world vectors, as text.
namespace map_key {
inline constexpr const char* unit = "vdbcloud:unit";
inline constexpr const char* first_column = "vdbcloud:first_column";    ///< centre of pixel 0, 0
inline constexpr const char* column_step_x = "vdbcloud:column_step_x";  ///< of one pixel to the right
inline constexpr const char* column_step_y = "vdbcloud:column_step_y";  ///< of one row down
inline constexpr const char* column_area = "vdbcloud:column_area";      ///< number: area of a pixel
}  // namespace map_key

/// A picture without a camera: channels of width x height values, row by row.
struct Map {
    int width = 0, height = 0;
    std::vector<std::pair<std::string, std::vector<float>>> channels;  ///< LAYER.CHANNEL; the values
};

/// Writes a map as an .exr of floats, scan lines, zip, whole or not at all. "-" is standard output.
///
/// Throws IoError, path first; InputError for a channel of another size.
void write_map(const std::string& path, const Map&, const ImageMetadata&, bool no_clobber);

}  // namespace vdbcloud
