#pragma once
// Whether the colour channels coincide, so that one computation serves all three.
#include "vdbcloud/optics/medium.h"

#include <optional>
#include <vector>

namespace vdbcloud {

/// True if r, g and b are equal.
bool same_channels(const Vec3d&);
/// The same of every active value of a grid, which may be null.
bool same_channels(const Vec3SGrid*);

/// Factor x >= 0 such that b = x a, if such a factor exists; none where a is all 0.
std::optional<double> multiple(const std::vector<double>& a, const std::vector<double>& b);

/// Whether all channels attenuate alike. The extinction (1 - delta_f albedo) sigma_t of a scaled medium depends on the
/// albedo, which `tinted` says a grid Cd changes.
bool grey_extinction(const Medium&, bool tinted, double delta_f);

}  // namespace vdbcloud
