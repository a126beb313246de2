#pragma once
// The inside of App.
#include "app.h"
#include "config.h"
#include "named_files.h"
#include "progress.h"
#include "scene_file.h"

#include "vdbcloud/file/io.h"

#include <tbb/global_control.h>

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace vdbcloud::app {

double wall_seconds();  ///< of a clock that only goes forward
double cpu_seconds();   ///< of all threads of this process

/// A file that an option names.
struct NamedFile {
    Option option;
    std::optional<FileKind> kind;    // none: the program reads it
    bool may_replace_input = false;  // the output may be a file that the program reads
    bool own_number = false;         // a number in the name is not that of --frames
};

/// Whether an option has an effect beside the values of the others.
struct Rule {
    CLI::Option* option;
    std::function<bool()> holds;
    std::function<void()> check;  // throws if the option was given and has none
};

/// What an option needs of a frame, and whether a frame had it.
struct FrameNeed {
    std::string remark, refusal;  // on the first frame that has not
    bool met = false;
};

struct App::Shared {
    // What the tool does.
    bool reads = false, writes = false, may_clobber = false, sequences = false, several_inputs = false;
    std::vector<NamedFile> files;
    std::vector<Option> inputs;  // of a tool that can run without one, else empty
    std::vector<Rule> rules;
    Option rung_option;                // of a program that takes rungs
    std::vector<Rule> rung_rules;      // of options that a rung sets at times
    std::vector<SceneKey> scene_keys;  // options that are keys of scene files

    // Options.
    int threads = 0, verbosity = 0;
    bool quiet = false, dry_run = false, werror = false, force = false, print_config = false, print_scene = false;
    bool one_medium = false, half = false, no_clobber = false, trust_input = false;
    double max_input = 16;  // [GiB]
    int rung = 0;
    std::string frames, json, scene, keep = "all", completion;
    int progress_choice = 0;  // auto, always, never, machine
    Compression compression = Compression::Blosc;

    // State.
    std::shared_ptr<Toml> toml;
    nlohmann::json report;
    nlohmann::json parameters;
    Workload work;  // events of the run so far
    std::vector<std::string> warnings;
    std::mutex mutex;  // of warnings
    Meter meter;
    std::unique_ptr<tbb::global_control> limit;
    double wall_start = wall_seconds();
    std::map<const CLI::Option*, std::string> scene_places;  // "FILE: line N: " of options that the scene file gave
    std::vector<Option> rung_set;                            // options whose value is the rung's
    std::vector<int> numbers;                                // of --frames
    std::optional<int> frame;                                // the one that is worked on
    std::map<std::string, FrameNeed> frame_needs;            // by option and need
    std::set<std::string> used;                              // grids --keep never drops
    std::set<std::string> inherited_grids;                   // names in what was read
    std::set<std::string> traced_inputs;                     // paths of inputs that bring a history
};

/// Options and their values as an object, numbers as numbers.
nlohmann::json parameters_of(const CLI::App&);

/// Writes `report` to `path` ("-": standard output), whole or not at all. Throws IoError.
void write_report(const std::string& path, const nlohmann::json& report);

}  // namespace vdbcloud::app
