#pragma once
// What every executable shares: options, exit status, threads, progress, signals, report, provenance, reading and
// writing. The library never includes this.
#include "option.h"
#include "options.h"

#include "vdbcloud/core/progress.h"
#include "vdbcloud/core/workload.h"
#include "vdbcloud/grid/grid_file.h"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <nlohmann/json.hpp>

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace vdbcloud::app {

struct SceneKey;  // scene_file.h

/// Exit status: what a Makefile sees. Signals end as the shell shows them: 130, 143, 141.
enum Exit { ok = 0, failed = 1, usage = 2, unconverged = 3 };

/// A CLI::App with the options every tool has:
/// --threads --quiet --verbose --progress --json --config --print-config --dry-run --werror --force --version --help
/// --help-all, and for tools that write grids: --compression --half --no-clobber; for tools that read grids:
/// --trust-input --max-input; for those that do both: --keep.
///
/// A tool declares its output as "-o,--output", a required option of one path. Every option that names a file says so
/// (Option::reads_files, writes_file): run() then looks at names, folders, the terminal and --no-clobber before the
/// work begins. Paths are plain std::string, without CLI::ExistingFile: a file that is not there is status 1, found by
/// read(), where a wrong option is status 2.
class App : public CLI::App {
public:
    App(const std::string& name, const std::string& summary);
    ~App() override;

    /// Declares the shared options of tools that read .vdb files / write one .vdb. Call while declaring. `inputs`: for
    /// a tool that can run without an input, the options that name one. Without any of them given, --trust-input and
    /// --max-input have no effect and are refused.
    void reads_grids(const std::vector<Option>& inputs = {});
    void writes_grids();
    /// The same for --no-clobber alone, for tools that write no grids.
    void never_clobbers();

    /// Declares --frames for numbered files in and out, and with `several_inputs` --one-medium. Call while declaring.
    void takes_frames(bool several_inputs);
    /// Puts the number of a frame into a path that an option gave.
    using PlaceFrame = std::function<void(std::string& path)>;
    /// Calls `work` once; with --frames for each frame, in turn. The report then has a list "frames".
    void each_frame(const std::function<void(const PlaceFrame&)>& work);

    /// Declares --rung for a program of data/rungs.txt, and shows the table in the help. Call while declaring, before
    /// examples().
    void takes_rungs();

    /// What --help ends with: commands that run as printed, one after the other, in an empty folder. The first is what
    /// a newcomer needs. Each is a line, {"what it is for", "command"}.
    void examples(const std::vector<std::pair<std::string, std::string>>&);

    /// An option bound to `value`, whose present value is the default (shown in help, in --print-config and in the
    /// history, exactly). Numbers must be finite. A Vec3d takes one word of three numbers, "0.3,1,0.2"; a vector
    /// takes one word each time the option is given. Positionals: a name without dashes.
    template<typename T>
    Option add_option(const std::string& names, T& value, const std::string& description)
    {
        if constexpr (traits::is_whole<T>) return add_whole(names, value, description);
        CLI::Option* option = CLI::App::add_option(names, value, description);
        if constexpr (traits::holds_numbers<T>) option->check(finite);
        if constexpr (traits::holds_unsigned<T>) option->check(nonnegative);  // CLI11 wraps -1 around
        if constexpr (traits::is_vector<T>) {
            option->allow_extra_args(false);
            if (value.empty()) option->default_str("");
        }
        return {*this, option};
    }
    Option add_option(const std::string& names, double& value, const std::string& description);
    Option add_option(const std::string& names, Vec3d& value, const std::string& description);
    Option add_option(const std::string& names, std::vector<Vec3d>& values, const std::string& description);

    /// A switch; "--haze,!--no-haze" has a negative form.
    Option add_flag(const std::string& names, bool& value, const std::string& description);

    /// As add_option with a Vec3d.
    Option add_vec3(const std::string& names, Vec3d& value, const std::string& description);
    /// The same, given as often as wanted.
    Option add_vec3s(const std::string& names, std::vector<Vec3d>& values, const std::string& description);
    /// Three numbers "r,g,b", or one for all three channels.
    Option add_rgb(const std::string& names, Vec3d& value, const std::string& description);
    /// The same, given as often as wanted.
    Option add_rgbs(const std::string& names, std::vector<Vec3d>& values, const std::string& description);

    /// One of several words, each standing for a value.
    template<typename E>
    Option add_choice(const std::string& names, E& value, const std::vector<std::pair<std::string, E>>& choices,
                      const std::string& description)
    {
        std::vector<std::string> words;
        std::string present;
        for (const auto& [word, meaning] : choices) {
            words.push_back(word);
            if (meaning == value) present = word;
        }
        const auto chosen = [&value, choices](const std::string& text) {
            for (const auto& [word, meaning] : choices)
                if (word == text) value = meaning;
        };
        return word_option(names, words, present, chosen, description);
    }

    /// Parses, limits threads, installs signal handling, runs `body`, writes the --json report, and reports what was
    /// thrown as one sentence "name: message" on stderr. Returns the exit status. The only `try` of the program.
    int run(int argc, char** argv, const std::function<void()>& body);

    /// A bar on a terminal, a line each 10 % with --progress always, a JSON line each second with machine, else
    /// nothing.
    Progress progress(const std::string& label);

    /// Warnings: one line on stderr, and into the report. With --werror the first one ends the run (InputError).
    Warn warnings();

    /// A line for a person on stderr, not with --quiet.
    void say(const std::string& line);

    /// The result of a tool whose result is text, on standard output; nothing if the report goes there (--json -).
    /// Throws IoError if it cannot be written.
    void print(const std::string& text);

    /// Times from here to the end of its life (wall and CPU seconds of the process) into the report's phases.
    class Phase {
    public:
        Phase(App&, const std::string& name);
        ~Phase();
        Phase(const Phase&) = delete;
        Phase& operator=(const Phase&) = delete;

    private:
        App& app_;
        std::string name_;
        double wall_, cpu_;
    };
    std::unique_ptr<Phase> phase(const std::string& name);

    /// The report that --json writes: fill "counts", "accuracy", "estimate" and what the tool adds.
    /// A member that the tool does not fill is not in the report.
    nlohmann::json& report();

    /// Events that a run counted: into the report as "events". read() and write() count theirs.
    void add_work(const Workload&);
    /// The events counted so far, which are forgotten.
    Workload take_work();

    /// The options that are keys of scene files.
    const std::vector<SceneKey>& scene_keys() const;

    bool dry_run() const;
    bool verbose() const;
    /// How many threads this run may use, at least 1.
    int threads() const;

    /// Throws UsageError if `path` is "-" and standard output is a terminal without --force; IoError if `path` is a
    /// folder, its folder is not there, or --no-clobber and it exists. run() does this for every option that names an
    /// output.
    void check_output(const std::string& path) const;
    /// True with --no-clobber, for tools that write by other means than write().
    bool no_clobber() const;

    /// Reads a .vdb under the shared options; notes path, bytes, digest, grids and statistics in the report.
    GridFile read(const std::string& path);

    /// Stamps creator and history (what `file` inherited plus this command line), applies --keep, writes, notes it in
    /// the report. Does nothing under --dry-run.
    void write(const std::string& path, GridFile& file);

    /// Names a grid that --keep never drops, for it was used here and later stages need it. The density is, always.
    void uses(const std::string& grid_name);

    /// `inherited` plus one line for this run: version, and every option with its value, in --config syntax; no clock
    /// and no host name, so equal runs give equal files. Neither the output nor an input that has a history of its own
    /// is named, and of paths only the last part: a pipe leaves the same line as files.
    std::string history(const std::string& inherited) const;

private:
    friend class Option;
    friend class SceneReader;
    struct Shared;
    struct Outcome {
        int status = ok;
        std::string message;
    };

    void declare_shared();
    void declare_common();
    void declare_scene();
    void declare_frames();
    bool read_scene();  // false: its part is all that was asked for, and is printed
    static void give(CLI::Option&, const std::vector<std::string>& words);  // as a file gives a value
    void leave_out_idle_scene();              // values of the scene file that have no effect in this run
    bool of_scene(const CLI::Option*) const;  // the scene file gave the value that is in force
    void apply_rung();                        // sets what the user left to the rung
    bool given_beside_rung(const Option&) const;
    std::string set_by_rung(const std::string& message) const;  // what to add where the rung set what it names
    bool parse_line(int argc, char** argv);                     // false: all that was asked for is printed
    void begin();                                               // looks at what was asked, before the work
    void check_places() const;                                  // of outputs
    void check_files();                                         // names of outputs, and each a file of its own
    void check_frames();                                        // names and numbers of --frames
    void refuse_unasked_frames() const;
    std::string at_frame(const std::string& path) const;  // with the number of the frame that is worked on
    void join_report(nlohmann::json& whole, int number) const;
    void forget_unsafe_report(int argc, char** argv);              // no --json over another file of the command
    void note(const std::string& phase, double wall, double cpu);  // into the report
    Outcome attempt(const std::function<void()>& work);
    bool on_command_line(const CLI::Option*) const;
    std::string
    place(const CLI::Option*) const;  // "FILE: line N: " if --config or --scene gave the option, else nothing
    std::string explain(const CLI::ParseError&) const;
    std::string reworded(const CLI::ParseError&) const;
    static std::string json_asked(int argc, char** argv);
    nlohmann::json finished_report(const nlohmann::json& status, const std::string& error) const;

    // CLI11's own reading of whole numbers wraps around.
    template<typename T>
    Option add_whole(const std::string& names, T& value, const std::string& description)
    {
        const auto check = [](const std::string& text) -> std::string {
            T read = 0;
            const char* const said[] = {"", "expected a whole number", "expected a smaller whole number"};
            const char* const natural[] = {"", "expected a whole number, 0 or above",
                                           "expected a smaller whole number"};
            const int fault = read_whole(text, read);
            return fault ? "'" + text + "': " + (std::is_unsigned_v<T> ? natural : said)[fault] : std::string();
        };
        const auto read = [&value](const CLI::results_t& words) { return read_whole(words.front(), value) == 0; };
        return Option(*this, CLI::App::add_option(names, CLI::callback_t(read), description))
            .default_str(std::to_string(value))
            .type_name("N")
            .check(CLI::Validator(check, ""));
    }

    Option vectors_option(const std::string& names, std::vector<Vec3d>& values, const std::string& description);
    Option word_option(const std::string& names, const std::vector<std::string>& words, const std::string& present,
                       const std::function<void(const std::string&)>& chosen, const std::string& description);

    std::unique_ptr<Shared> shared_;
};

}  // namespace vdbcloud::app
