#pragma once
// Many frames through the whole chain in one process a program: memory, descriptors and files must not grow.
#include "hard/suite.h"

#include <string>
#include <vector>

namespace vdbcloud::test {

/// What a process had when half of its frames were there, and at its end.
struct Growth {
    int status = 0;
    double memory = 0;    ///< largest resident memory at the end over that of the first half, less 1
    int descriptors = 0;  ///< most open files in the second half, less the most in the first
    int left = 0;         ///< files in the temporary folder, and hidden files beside the output
    double seconds = 0;   ///< processor time
};

/// Runs the program of a path that writes `frames` files `output`, a pattern with %04d from 1 on, in `folder`.
Growth watch(const std::string& path, const Words& arguments, const std::string& folder, const std::string& output,
             int frames);

/// cloudsim, fractalgen, illuminate, p1solve and render on so many frames: three rows each.
std::vector<Row> soak(int frames, const std::string& folder);

}  // namespace vdbcloud::test
