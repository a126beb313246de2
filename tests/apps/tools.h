#pragma once
// The programs of this build, and how tests call each.
#include "support/run.h"

#include <array>
#include <ostream>
#include <string>
#include <vector>

namespace vdbcloud::test {

using Words = std::vector<std::string>;

struct Tool {
    std::string name;
    Words quick;            ///< options that make a run short
    std::string extension;  ///< of what it writes; empty: it writes no file
    bool reads = true;      ///< has an input
    bool twice = false;     ///< takes two inputs
    bool several = false;   ///< takes any number of inputs
    bool prints = false;    ///< its result is text on standard output

    /// A command line; `output` may be empty.
    Words command(const std::string& input, const std::string& output) const;
};

inline std::ostream& operator<<(std::ostream& out, const Tool& tool) { return out << tool.name; }

/// Those that are built.
std::vector<Tool> tools();
std::vector<Tool> reading_tools();
std::vector<Tool> writing_tools();

/// Runs `tool` and expects status `status` with one line on standard error that begins with its name.
RunResult expect_refused(const Tool& tool, const Words& command, int status);

/// A small lit cloud at `path`, made by fractalgen and illuminate.
void make_lit_cloud(const std::string& path, const Words& fractalgen_options = {});

/// A density of 1 in five voxels a side at `path`, one of which is not a number.
void write_density_with_nan(const std::string& path, const std::array<int, 3>& voxel);

}  // namespace vdbcloud::test
