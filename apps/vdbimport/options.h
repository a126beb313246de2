#pragma once
// Options of vdbimport.
#include "format.h"
#include "medium_options.h"
#include "stage_options.h"

#include "vdbcloud/exchange/array_file.h"
#include "vdbcloud/exchange/cloud_field.h"

#include <optional>
#include <string>
#include <vector>

namespace vdbcloud {

enum class Values { OpticalDepth, Extinction };

struct Options {
    std::string input, output, thickness;
    Format format = Format::Automatic;
    Vec3d cell{0, 0, 0};  ///< 0: not given
    double base = 0, thickness_unit = 1;
    int across = 1;
    bool boxes = false;
    Values values = Values::OpticalDepth;
    std::optional<UpAxis> up;
    double meters_per_unit = 0;                 ///< 0: not given
    std::vector<std::string> variables, units;  ///< ROLE=NAME, NAME=UNIT
    double effective_radius = 0, air_density = 0;
    std::string times;
    Vec3d shape{0, 0, 0};  ///< of a raw array, along x, y, z
    std::string axes = "zyx", type = "f4";
    bool big_endian = false;
    double radius = 0;  ///< of particles; 0: not given
    app::MediumOptions medium;
    struct {
        app::Option cell, output, radius, effective_radius, air_density, times;
    } option;

    Format kind() const { return format == Format::Automatic ? format_of(input) : format; }
    bool particles() const { return is(Format::Ply) || is(Format::Csv) || is(Format::Points); }
    bool is(Format f) const { return kind() == f; }
};

void declare(app::App&, Options&);

/// The left and right sides of "ROLE=NAME". Throws UsageError, which names the option, for other text and for a left
/// side that comes twice.
std::map<std::string, std::string> pairs_of(const std::string& option, const std::vector<std::string>&);

}  // namespace vdbcloud
