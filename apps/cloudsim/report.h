#pragma once
// The report of a run: its plan, and for each frame a line of text and a JSON object.
#include "options.h"
#include "plan.h"

#include "vdbcloud/sim/simulation.h"

#include <fstream>
#include <string>

namespace vdbcloud::app {

/// Prints and reports the plan of a run: effects, parameters, memory, time. Throws InputError.
void plan(App&, const Options&, const Run&);

/// Memory of a run, without events.
Plan least_plan(const Options&, const Run&);

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
