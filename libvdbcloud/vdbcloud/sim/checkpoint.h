#pragma once
// The whole state of a run in one file, so that it can go on later with the same bits.
#include "vdbcloud/sim/simulation.h"

#include <string>

namespace vdbcloud::sim {

/// Every parameter in words, one "name = value" a line, numbers exactly: what a checkpoint must agree with, and what
/// frames tell of how they were made.
std::vector<std::pair<std::string, std::string>> describe(const Parameters&, const Sounding&);
/// The same as one text.
std::string text_of(const Parameters&, const Sounding&);

/// Writes to a temporary and renames it, so that a killed run leaves the previous checkpoint whole. `frame` is the
/// number of the last frame that is on disk. Throws IoError.
void write_checkpoint(const std::string& path, const Simulation&, const Sounding&, int frame);

/// Restores a simulation made with the same parameters and returns the frame. Throws IoError if the file cannot be
/// read, is damaged (it carries a checksum) or no checkpoint; UsageError naming the first parameter that differs.
int read_checkpoint(const std::string& path, Simulation&, const Sounding&);

}  // namespace vdbcloud::sim
