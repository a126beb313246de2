#pragma once
// The rungs of the chain illuminate, p1solve, render: which options `--rung N` sets, read from data/rungs.txt.
#include <string>
#include <vector>

namespace vdbcloud::app {

/// An option of a program and its value on each rung.
struct RungRow {
    std::string program, option;      ///< "render", "--samples"
    std::vector<std::string> values;  ///< "-": the option's own default; "none": the program has no part in the rung
};

struct RungTable {
    std::vector<std::string> names;  ///< of rung 0, 1, ...
    std::vector<RungRow> rows;
};

/// The text of data/rungs.txt, which CMake compiles in.
const char* rung_text();

/// Reads such a text. Throws std::logic_error, as data of the build.
RungTable read_rungs(const std::string& text);

/// The table of this build.
const RungTable& rungs();

/// The table as --help shows it.
std::string shown(const RungTable&);

/// Rungs in which the program has a part, as "1 to 5".
std::string rungs_of(const RungTable&, const std::string& program);

}  // namespace vdbcloud::app
