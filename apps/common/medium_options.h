#pragma once
// Options for the coefficients of a medium, and what wins: the command line, then the file, then an automatic
// choice.
#include "app.h"

#include "vdbcloud/optics/medium.h"

namespace vdbcloud::app {

struct MediumOptions {
    Vec3d extinction{0, 0, 0};  ///< sigma_t at density 1 [1/world unit]; 0: not given
    Medium rest;                ///< albedo, g and phase function, for what the file does not say
    struct {
        Option extinction, albedo, g, phase;
    } option;
};

/// --extinction --albedo --g --phase.
void declare_medium(App&, MediumOptions&);

/// The medium of `density`: what its metadata gives, replaced by what the user gave, with an automatic
/// extinction if neither gives one (which is said on standard error). It is written into the density's
/// metadata together with its origin, so later stages inherit it. Throws UsageError for --g with a phase
/// function that has none, and for an extinction of 0.
Medium chosen_medium(App&, const MediumOptions&, FloatGrid& density);

/// Throws UsageError naming both values if a grid was computed with other coefficients than `medium`: `what`
/// it is called, `made_with` its metadata. Keys that it lacks are passed over.
void require_same_medium(const std::string& what, const MetaMap& made_with, const Medium& medium);

/// True if the extinction in a grid's metadata is there and is the medium's.
bool same_extinction(const MetaMap& made_with, const Medium& medium);

}  // namespace vdbcloud::app
