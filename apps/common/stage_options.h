#pragma once
// Options that several programs share: the files of a stage, the name of the density, the up axis.
#include "app.h"

#include "vdbcloud/grid/up_axis.h"

namespace vdbcloud::app {

/// A program that reads a density and writes its file again with more grids.
struct StageOptions {
    std::string input, output;
    std::string density;  ///< name of the density grid; empty: the usual names
};

/// input, --output, --density and the shared options of reading and writing. `input`, `output`: their help. Keeps
/// references to `o`.
void declare_stage(App&, StageOptions& o, const std::string& input, const std::string& output);

/// --density alone, bound to `name`.
Option declare_density(App&, std::string& name);

/// The choices of --up: y and z. E is UpAxis or std::optional<UpAxis>.
template<typename E = UpAxis>
std::vector<std::pair<std::string, E>> up_axis_choices()
{
    std::vector<std::pair<std::string, E>> all;
    for (const auto& [axis, word] : up_axis_words.entries) all.emplace_back(std::string(1, char(*word | 0x20)), axis);
    return all;
}

}  // namespace vdbcloud::app
