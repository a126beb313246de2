#pragma once
// A whole scene as data: what a hard case is, and what the generator of random worlds makes.
#include "vdbcloud/core/fwd.h"

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace vdbcloud::test {

struct WorldLight {
    bool lamp = false;
    Vec3d at{0, 1, 0};     ///< direction towards a sun; position of a lamp [world]
    Vec3d power{1, 1, 1};  ///< irradiance of a sun; intensity of a lamp
    double diameter = 0;   ///< of a sun's disc [degrees]
};

/// A record of tests/hard/cases.txt; README.md there says what the keys mean.
struct World {
    std::string name, why;
    std::vector<std::string> bodies;  ///< one input file each, see body.h
    std::array<Vec3d, 3> axes{Vec3d(1, 0, 0), Vec3d(0, 1, 0),
                              Vec3d(0, 0, 1)};  ///< world vector of a step along i, j, k
    Vec3d origin{0, 0, 0};                      ///< centre of voxel 0 [world]
    std::string medium;                         ///< options of the medium
    std::vector<WorldLight> lights;
    std::string sky;       ///< options of the sky, for p1solve
    std::string light;     ///< options of illuminate
    std::string solve;     ///< options of p1solve
    std::string view;      ///< options of render
    std::string periodic;  ///< index axes
    Vec3d look{-0.4, -0.3, -1};
    std::string up = "y";
    std::string stages = "p1solve render";
    std::vector<std::string> commands;                  ///< in place of all above: lines of programs with options
    int refused = 0;                                    ///< status with which the last program ends
    std::string sentence;                               ///< if that is not 0: a piece of what it says
    std::vector<std::pair<std::string, double>> holds;  ///< invariant, limit
    std::map<std::string, std::string> known;           ///< invariant: why it fails today

    bool runs(const std::string& stage) const;
    /// The text of the record.
    std::string text() const;
};

/// Reads records. Throws std::runtime_error with file and line.
std::vector<World> read_worlds(const std::string& path);

/// The world of a seed. The same on every machine.
World random_world(uint64_t seed);

/// The world with one thing less, for each thing that it can do without; simpler worlds first.
std::vector<World> simpler_worlds(const World&);

/// A number with all digits that a double needs.
std::string digits(double);
std::string digits(const Vec3d&);

}  // namespace vdbcloud::test
