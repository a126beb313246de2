#pragma once
// What a result was computed from: fingerprints of the grids that a stage read, as metadata of the grids it writes.
#include "vdbcloud/core/fwd.h"

#include <array>
#include <optional>
#include <string>

namespace vdbcloud {

/// The grids behind a result of multiple scattering, by grid_digest(). schema::no_grid stands for a grid that was not
/// there.
struct Sources {
    std::string density, colour, emission;
};

/// The fingerprints of these grids. `colour` (Cd) and `emission` may be null; one that changes nothing (Cd of 1,
/// emission of 0) counts as none.
Sources sources_of(const FloatGrid& density, const Vec3SGrid* colour, const Vec3SGrid* emission);

/// Stores all three fingerprints: schema::density_digest, colour_digest, emission_digest.
void write_sources(MetaMap&, const Sources&);

/// The name of the first grid that is not the one which `result` was computed from: density, Cd or emission. Empty if
/// there is none. A fingerprint that the metadata lack is not compared: files of other programs have none.
std::string changed_source(const MetaMap& result, const Sources& now);

/// Stores along which index axes the medium of a result repeats (schema::periodic), and reads it.
void write_periodic(MetaMap&, const std::array<bool, 3>&);
std::array<bool, 3> read_periodic(const MetaMap&);
/// Stores the albedo of the ground beneath the medium of a result (schema::ground_albedo), and reads it; none: there is
/// no ground.
void write_ground(MetaMap&, const std::optional<double>& albedo);
std::optional<double> read_ground(const MetaMap&);
/// The axes as metadata and command lines have them: "xz"; "none".
std::string periodic_text(const std::array<bool, 3>&);

}  // namespace vdbcloud
