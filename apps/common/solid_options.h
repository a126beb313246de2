#pragma once
// --solid: opaque bodies beside the media, shared by the stages that they shadow.
#include "app.h"

#include "vdbcloud/scene/solid.h"

#include <string>
#include <vector>

namespace vdbcloud::app {

struct SolidOptions {
    std::vector<std::string> asked;  ///< as given
    Option option;
};

/// --solid, as often as wanted: a shape or the path of a .vdb, then the material, with semicolons between.
void declare_solids(App&, SolidOptions&, const std::string& group);

class OptionWords;

/// The plane, sphere or box that the words begin with, or nothing for another shape. `known`: gets the words that it
/// has. Not checked.
std::optional<Solid> plain_solid(OptionWords&, const Vec3d& up, std::vector<std::string>& known);

/// The solids asked for, else those of the input files, in order. Reads the files that are named. `up`: of planes that
/// say nothing else. Throws UsageError for words that are no solid, InputError as check() of scene/solid.h.
std::vector<Solid> chosen_solids(App&, const SolidOptions&, const std::vector<const GridFile*>& files, const Vec3d& up);

}  // namespace vdbcloud::app
