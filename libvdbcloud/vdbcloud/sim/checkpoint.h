#pragma once
// The whole state of a run in one file, from which the run continues with equal bits.
#include "vdbcloud/sim/simulation.h"

#include <string>

namespace vdbcloud::sim {

/// Every parameter as name and exact value. A checkpoint can be read by a run with equal ones; the metadata of frames
/// hold them.
std::vector<std::pair<std::string, std::string>> describe(const Parameters&, const Sounding&);
/// The same as text, "name = value" a line.
std::string text_of(const Parameters&, const Sounding&);

/// Writes to a temporary and renames it, so that a killed run does not damage the previous checkpoint. `frame` is the
/// number of the last frame that is on disk. Throws IoError.
void write_checkpoint(const std::string& path, const Simulation&, const Sounding&, int frame);

/// Restores a simulation made with the same parameters and returns the frame. Throws IoError if the file cannot be
/// read, is damaged (it carries a checksum) or no checkpoint; UsageError naming the first parameter that differs.
int read_checkpoint(const std::string& path, Simulation&, const Sounding&);

}  // namespace vdbcloud::sim
