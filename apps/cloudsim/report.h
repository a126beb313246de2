#pragma once
// The report of a run: its plan, and for each frame a line of text and a JSON object.
#include "options.h"
#include "plan.h"

#include "vdbcloud/sim/simulation.h"

#include <fstream>
#include <functional>
#include <string>

namespace vdbcloud::app {

/// Prints and reports the plan of a run: effects, parameters, memory, time. Throws InputError.
void plan(App&, const Options&, const Run&);

/// Memory of a run, without events.
Plan least_plan(const Options&, const Run&);

nlohmann::json as_json(const sim::Budget&, int frame);
std::string as_line(const sim::Budget&, int frame);

/// A file of lines that a run appends to.
class LineFile {
public:
    /// `path`: "" writes nothing, "-" to standard output. Of the lines that an earlier run wrote, those stay for which
    /// keep(line) holds; null keeps none. `what` names the file in errors. Throws IoError.
    LineFile(const std::string& path, const std::string& what, const std::function<bool(const std::string&)>& keep);
    void write(const std::string& line);

private:
    std::string path_, what_;
    std::ofstream file_;
};

/// The file of JSON lines. A run that continues after frame `last` keeps the lines up to it and writes later ones anew.
class Log {
public:
    /// `path`: "" writes nothing, "-" to standard output. Throws IoError.
    Log(const std::string& path, int last);
    void write(const nlohmann::json& line);

private:
    LineFile file_;
};

}  // namespace vdbcloud::app
