#pragma once
// Options that several programs share: the files of a stage, the name of the density, the up axis.
#include "app.h"

#include "vdbcloud/grid/up_axis.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdbcloud::app {

/// A program that reads a density and writes its file again with more grids.
struct StageOptions {
    std::vector<std::string> inputs;  ///< at least one
    std::string output;
    std::string density;       ///< name of the density grid; empty: the usual names
    std::optional<UpAxis> up;  ///< none: the file's
    std::string periodic;      ///< axes along which the medium repeats; empty: the file's
};

/// The positional input: one or several files. Keeps a reference to `paths`.
void declare_inputs(App&, std::vector<std::string>& paths, const std::string& help);

/// input, --output, --density, --up, --periodic and the shared options of reading and writing. `input`, `output`: their
/// help. Keeps references to `o`.
void declare_stage(App&, StageOptions& o, const std::string& input, const std::string& output);

/// Puts the number of a frame into the paths of a stage.
void place_stage(StageOptions&, const App::PlaceFrame&);

/// --density alone, bound to `name`.
Option declare_density(App&, std::string& name);

/// --up of a program that reads files, bound to `up`; without it the file's.
Option declare_up(App&, std::optional<UpAxis>& up, const std::string& group);

/// The axis asked for, else that of the file's metadata, else y; and then, if it `matters` to what is computed, a line
/// says that y was taken. What was asked for or said is kept in the metadata, for later stages.
UpAxis settled_up(App&, const std::optional<UpAxis>& asked, GridFile&, bool matters);

/// The choices of --up: y and z. E is UpAxis or std::optional<UpAxis>.
template<typename E = UpAxis>
std::vector<std::pair<std::string, E>> up_axis_choices()
{
    std::vector<std::pair<std::string, E>> all;
    for (const auto& [axis, word] : up_axis_words.entries) all.emplace_back(std::string(1, char(*word | 0x20)), axis);
    return all;
}

}  // namespace vdbcloud::app
