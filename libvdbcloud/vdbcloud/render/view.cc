#include "vdbcloud/render/view.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/words.h"
#include "vdbcloud/render/film.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

constexpr auto kinds =
    words<ViewKind>("view", {{ViewKind::Srgb, "srgb"}, {ViewKind::Filmic, "filmic"}, {ViewKind::None, "none"}});

constexpr double knee = 0.4;
constexpr double least_alpha = 0.05;
constexpr size_t fewest_pixels = 16;
constexpr double percentile = 0.95, target = 1.0;

int beauty_of(const Film& film)
{
    const int layer = film.find("");
    if (layer < 0 || film.layers()[size_t(layer)].channels.size() < 4)
        throw InputError("film: expected a beauty layer of four channels");
    return film.offset(layer);
}

std::vector<double> luminances(const Film& film, double above_alpha)
{
    const int beauty = beauty_of(film);
    const PixelWindow w = film.window();
    std::vector<double> out;
    for (int j = w.y0; j < w.y1; ++j)
        for (int i = w.x0; i < w.x1; ++i)
            if (film.pixel(i, j)[beauty + 3] > above_alpha) {
                const Vec3d rgb = composited(film, i, j);
                out.push_back(luminance(rgb[0], rgb[1], rgb[2]));
            }
    return out;
}

}  // namespace

const char* name(ViewKind kind) { return kinds.word(kind); }

ViewKind view_kind(const std::string& text) { return kinds.value(text); }

double filmic(double x)
{
    if (!(x > 0)) return 0;
    if (x <= knee) return x;
    const double u = (x - knee) / (1 - knee);
    return 1 - (1 - knee) / (1 + u);
}

double srgb_encode(double linear)
{
    const double x = std::clamp(linear, 0.0, 1.0);
    return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
}

Vec3d displayed(const Vec3d& radiance, const ViewOptions& view)
{
    const double scale = std::exp2(view.exposure);
    Vec3d out;
    for (int c = 0; c < 3; ++c) {
        const double x = std::max(0.0, radiance[c] * scale);
        out[c] = view.kind == ViewKind::None   ? std::min(x, 1.0)
                 : view.kind == ViewKind::Srgb ? srgb_encode(x)
                                               : srgb_encode(filmic(x));
    }
    return out;
}

Vec3d composited(const Film& film, int i, int j)
{
    const float* pixel = film.pixel(i, j);
    const float* front = pixel + beauty_of(film);
    Vec3d rgb(front[0], front[1], front[2]);
    if (const int layer = film.find("background"); layer >= 0) {
        const float* behind = pixel + film.offset(layer);
        rgb += Vec3d(behind[0], behind[1], behind[2]);
    }
    return rgb;
}

double auto_exposure(const Film& film)
{
    auto values = luminances(film, least_alpha);
    if (values.size() < fewest_pixels) values = luminances(film, -1);
    if (values.empty()) return 0;
    const auto rank = values.begin() + std::ptrdiff_t(percentile * double(values.size() - 1));
    std::nth_element(values.begin(), rank, values.end());
    return *rank > 0 ? std::clamp(std::log2(target / *rank), -60.0, 60.0) : 0;
}

}  // namespace vdbcloud
