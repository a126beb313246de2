#pragma once
// The shape of a fair-weather cumulus: towers of bulges on a flat base.
#include "vdbcloud/fractal/envelope.h"

#include <cstdint>

namespace vdbcloud {

struct CumulusOptions {
    uint64_t seed = 1;
    int towers = 6;       ///< rising columns, 1..64; the first is the tallest
    double height = 0.6;  ///< of the tallest over the broader side of the box, if the box is as high; > 0
    int generations = 3;  ///< of bulges upon bulges, 1..4
    int up = 1;           ///< axis that points up: 0, 1 or 2
};

/// Spheres whose union is a cumulus that fills the box: every tower a column of spheres that narrows to a
/// dome, a few broad ones that join the feet, and on the outside of each sphere smaller ones, and on those
/// again, as the turrets of a cauliflower (after the observation of Neyret, Qualitative simulation of
/// convective cloud formation and evolution, 1997, that the surface of a cumulus is bulges upon bulges). All
/// is cut flat at the box's lower face: base().
///
/// Depth of one sphere of radius r at distance d: (r^2 - d^2) / (2 r), which is r - d to first order at its
/// surface and below it elsewhere; of the union: the largest, so bulges meet in creases.
///
/// The same seed gives the same cloud in every box of the same proportions. Throws InputError.
EnvelopePtr cumulus_envelope(const Box&, const CumulusOptions&);

}  // namespace vdbcloud
