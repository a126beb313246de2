#pragma once
// From radiance to a screen: exposure, a tone curve, the transfer function of sRGB.
#include "vdbcloud/core/fwd.h"

#include <string>

namespace vdbcloud {

class Film;

enum class ViewKind {
    Srgb,    ///< clipped at 1, then sRGB's transfer function
    Filmic,  ///< highlights rolled off by filmic(), then sRGB's transfer function
    None,    ///< clipped at 1, linear
};

const char* name(ViewKind);
ViewKind view_kind(const std::string& name);  ///< Throws InputError with the names that there are.

struct ViewOptions {
    ViewKind kind = ViewKind::Filmic;
    double exposure = 0;  ///< [EV]: radiance is multiplied by 2^exposure first
};

/// Tone curve, per channel:
///
///     f(x) = x                                      x <= k,   k = 0.4
///     f(x) = k + (1 - k) u / (1 + u),  u = (x - k)/(1 - k)   above
///
/// Why: below k a picture is what the sRGB view shows, so that the two can be compared; above it nothing
/// clips, so that the relief of a bright cloud stays visible; slope and value are continuous at k, and it
/// grows strictly towards 1. Acting on channels one by one, it bleaches strong colours as they brighten, as
/// film does. Negative x stays 0.
double filmic(double x);

/// sRGB's transfer function (IEC 61966-2-1), linear [0, 1] to encoded [0, 1]; clipped outside.
double srgb_encode(double linear);

/// What a screen is sent for a radiance, each channel in [0, 1].
Vec3d displayed(const Vec3d& radiance, const ViewOptions&);

/// Foreground over background of a film's pixel: channels of its beauty layer plus those of its "background"
/// layer.
Vec3d composited(const Film&, int i, int j);

/// The exposure [EV] that shows the medium well: it takes the 95th percentile of the luminance of pixels
/// whose alpha is above 0.05 (of all pixels, if there are fewer than 16 such) to 1, which the filmic curve
/// shows as a bright white that keeps its relief. Computed by ranks, so it does not depend on threads; 0
/// where that luminance is 0. Within [-60, 60].
double auto_exposure(const Film&);

}  // namespace vdbcloud
