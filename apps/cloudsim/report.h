#pragma once
// What a run says: its plan, a line a frame for people, and the same in JSON.
#include "options.h"

#include "vdbcloud/sim/simulation.h"

#include <fstream>
#include <string>

namespace vdbcloud::app {

/// Says and reports what a run would do: effects, values in force, memory, time. Throws InputError.
void plan(App&, const Run&);

nlohmann::json as_json(const sim::Budget&, int frame);
std::string as_line(const sim::Budget&, int frame);

/// The file of JSON lines. A run that continues after frame `last` keeps the lines up to it and writes later ones anew.
class Log {
public:
    /// `path`: "" writes nothing, "-" to standard output. Throws IoError.
    Log(const std::string& path, int last);
    void write(const nlohmann::json& line);

private:
    std::string path_;
    std::ofstream file_;
};

}  // namespace vdbcloud::app
