#pragma once
// A world through the programs, and what comes out.
#include "hard/body.h"
#include "hard/world.h"
#include "support/picture_file.h"

#include <nlohmann/json.hpp>

#include <map>
#include <string>
#include <vector>

namespace vdbcloud::test {

/// What a world gives.
// NOLINTNEXTLINE(bugprone-exception-escape): moving the report allocates nothing
struct Seen {
    std::string failure;      ///< the program that did not end with status 0, and its words; empty: all did
    int status = 0;           ///< of the program that ran last
    bool last = false;        ///< it was the last one of the world
    bool over_limit = false;  ///< of time or memory
    std::map<std::string, GridBasePtr> grids;
    PictureFile picture;
    nlohmann::json channels;        ///< of p1solve's report
    double seconds = 0, bytes = 0;  ///< of the most expensive program
};

/// A folder with the programs' files for one run at a time.
class Chain {
public:
    Chain(Programs& programs, const std::string& folder) : programs_(programs), folder_(folder) {}

    /// The world under a change.
    Seen run(const World&, const Change& = {});
    /// The lines of `world.commands`; grids and the last picture of their outputs.
    Seen run_commands(const World&);
    /// Options of the camera for the inputs that run() wrote last.
    Words camera(const World&, const Change&) const;
    /// One program on the inputs that run() wrote last.
    Seen run_render(const World&, const Words& options);

    double seconds() const { return programs_.seconds(); }
    void set_threads(int threads) { threads_ = threads; }
    const std::string& folder() const { return folder_; }

    /// Options of the lights under a change, for each program.
    static Words lights(const World&, const Change&);

    /// The programs with their options that worlds gave them: "program --option".
    const std::map<std::string, int>& reached() const { return reached_; }

private:
    bool step(Seen&, const std::string& name, const Words& arguments);
    Words write_inputs(const World&, const Change&);

    Programs& programs_;
    std::string folder_;
    int threads_ = 1;
    Words inputs_;
    std::vector<Vec3d> box_;  ///< corners of the bodies [world]
    std::map<std::string, int> reached_;
};

}  // namespace vdbcloud::test
