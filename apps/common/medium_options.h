#pragma once
// Options for the coefficients of a medium. The command line wins over the file, the file over an automatic choice.
#include "app.h"
#include "fire_options.h"

#include "vdbcloud/optics/medium.h"

#include <map>
#include <vector>

namespace vdbcloud::app {

struct MediumOptions {
    Vec3d extinction{0, 0, 0};  ///< sigma_t at density 1 [1/world unit]; 0: not given
    Vec3d albedo{1, 1, 1};
    std::string phase;  ///< a name of the table of phase functions
    struct Parameter {
        double value = 0;
        Option option;
    };
    std::map<std::string, Parameter> parameters;  ///< of all phase functions, by name
    FireOptions fire;                             ///< of a program that reads the density
    struct {
        Option extinction, albedo, phase;
    } option;
};

/// Where a coefficient comes from that the user does not give.
enum class MediumSource {
    File,  ///< the metadata of the density that the program reads, then an automatic choice
    None   ///< the program makes the density: the coefficients that are not given are left to later programs
};

/// --extinction --albedo --phase, and an option for each parameter of a phase function; with MediumSource::File also
/// those of declare_fire(). Keeps references to `o`.
void declare_medium(App&, MediumOptions& o, MediumSource = MediumSource::File);

/// All options of declare_medium() but those of fire.
std::vector<Option> options_of(const MediumOptions&);

/// The medium of `density`: what its metadata gives, replaced by what the user gave, with an automatic extinction if
/// neither gives one (which is said on standard error), and the albedo of soot if neither gives one and it `burns`. It
/// is written into the density's metadata together with its origin, so later stages inherit it. Throws UsageError for a
/// parameter that the phase function does not have, for one that it needs and nobody gives, and for an extinction of 0.
Medium chosen_medium(App&, const MediumOptions&, FloatGrid& density, bool burns);

/// Writes the coefficients that the user gave, for the metadata of a new density; without any given, none. Later stages
/// inherit them. Throws UsageError as chosen_medium() does.
void write_given_medium(const MediumOptions&, MetaMap&);

/// Throws UsageError naming both values if a grid was computed with other coefficients than `medium`: `what` it is
/// called, `made_with` its metadata. Keys that it lacks are taken as equal.
void require_same_medium(const std::string& what, const MetaMap& made_with, const Medium& medium);

/// True if the extinction in a grid's metadata is there and is the medium's.
bool same_extinction(const MetaMap& made_with, const Medium& medium);

}  // namespace vdbcloud::app
