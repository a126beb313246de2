#pragma once
// The options of cloudsim. Each overrides a value of the preset.
#include "stage_options.h"

#include "vdbcloud/sim/presets.h"
#include "vdbcloud/sim/run_record.h"

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace vdbcloud::app {

struct Options {
    std::string output, log, checkpoint, resume, init, floor_map, forcing, series, profiles, average, netcdf;
    std::string preset = "cumulus", sounding, every, grids;
    sim::Accuracy accuracy = sim::Accuracy::Default;
    UpAxis up = UpAxis::Y;
    bool unpruned = false, strict = false, huge_dt = false, change = false;
    std::optional<double> minutes;
    double effective_radius = 10e-6;
    std::optional<double> smoke_extinction;
    int first_frame = 0, checkpoint_every = 10;
    std::string cells, spacing, sides, wind, shear, frame_velocity;
    std::vector<std::string> patches, bubbles, sources, colliders;
    bool no_forcing = false;
    std::string seed;
    /// One function for each option: applies the option, if given, to the preset's parameters. In order of declaration.
    std::vector<std::function<void(sim::Parameters&)>> overrides;
    /// By name without dashes; at() throws for a name that was not declared.
    std::map<std::string, Option> option;
};

void declare(App&, Options&);

/// A run: the preset with the values of the options.
struct Run {
    sim::Preset preset;
    int frames = 0;         ///< without the frame of the start
    bool sequence = false;  ///< true: a file for each frame; false: only the last frame

    double average = 0;  ///< period of which profiles are means [s]

    double seconds() const { return 60 * preset.minutes; }
};

/// Throws UsageError for impossible values and for an option without effect.
Run resolve(App&, const Options&);

/// "10s", "2.5 min", "1h" or a number of seconds. Throws UsageError naming the option.
double seconds_of(const std::string& option, const std::string& text);

/// The path of frame `number`: `pattern` with the place for a number replaced (FramePattern), else one path for all.
/// Throws UsageError.
std::string frame_path(const std::string& pattern, int number);

/// The number in `name`, without a folder, where it is the name of a frame of `pattern`; 0 for the one file without a
/// number; else nothing.
std::optional<int> frame_number(const std::string& pattern, const std::string& name);

/// The file of --init.
struct FirstAirFile {
    std::optional<GridFile> grids;  ///< none without --init
    std::string identity = "none";  ///< digest of the bytes that were read; of a pipe only that it is one
};

/// Reads the file of --init once. A run that continues needs its identity alone and leaves a pipe unread.
FirstAirFile first_air_of(App&, const Options&, bool resumed = false);

/// What frames hold and when they are.
sim::FramePlan plan_of(const Options&, const Run&, const FirstAirFile&);

/// Splits names of grids at commas. Throws UsageError for a name that no snapshot has.
std::vector<std::string> grid_names(const std::string& text);

/// Factors of the floor's fluxes from an image (mean of its channels) or the lowest voxels of the first float grid of a
/// .vdb: one factor for each cell of the floor. An image spans the floor; its first row is at the largest y.
std::vector<double> read_floor_map(App&, const std::string& path, const sim::Lattice&, UpAxis);

}  // namespace vdbcloud::app
