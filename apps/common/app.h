#pragma once
// What every executable shares: options, exit status, threads, progress, signals, report, provenance, reading and
// writing. The library never includes this.
#include "vdbcloud/core/progress.h"
#include "vdbcloud/grid/io.h"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <nlohmann/json.hpp>

#include <functional>
#include <memory>
#include <string>

namespace vdbcloud::app {

/// Exit status: what a Makefile sees.
enum Exit { ok = 0, failed = 1, usage = 2, unconverged = 3 };

extern const CLI::Validator positive;     ///< a finite number above 0
extern const CLI::Validator nonnegative;  ///< a finite number, 0 or above
extern const CLI::Validator finite;       ///< a finite number
/// A finite number within [low, high].
CLI::Validator within(double low, double high);

/// A CLI::App with the options every tool has:
/// --threads --quiet --verbose --progress --json --config --print-config --dry-run --force --version --help-all, and for
/// tools that write grids: --compression --half --no-clobber --keep; for tools that read grids: --trust-input --max-input.
class App : public CLI::App {
public:
    App(const std::string& name, const std::string& summary);
    ~App() override;

    /// Declares the shared options of tools that read one .vdb / write one .vdb. Call while declaring.
    void reads_grids();
    void writes_grids();

    /// Parses, limits threads, installs signal handling, runs `body`, writes the --json report, and reports what was
    /// thrown as one sentence "name: message" on stderr. Returns the exit status. The only `try` of the program.
    int run(int argc, char** argv, const std::function<void()>& body);

    /// A bar on a terminal, a line each 10 % with --progress always, JSON lines with machine, else nothing.
    Progress progress(const std::string& label);

    /// Warnings: one line on stderr, and into the report.
    Warn warnings();

    /// A line for a person on stderr, not with --quiet.
    void say(const std::string& line);

    /// Times a phase from here to the end of the returned object's life (wall and CPU seconds, into the report).
    class Phase;
    std::unique_ptr<Phase> phase(const std::string& name);

    /// The report that --json writes: fill "counts", "accuracy", "estimate" and what the tool adds.
    nlohmann::json& report();

    bool dry_run() const;

    /// True if the user gave `option` on the command line or in the --config file (not its default).
    bool given(const std::string& option) const;

    /// Reads a .vdb under the shared options; notes path, bytes, digest, grids and statistics in the report.
    GridFile read(const std::string& path);

    /// Stamps creator and history (what `file` inherited plus this command line), applies --keep, writes, notes it in the report.
    /// Refuses a terminal without --force (UsageError). Does nothing under --dry-run.
    void write(const std::string& path, GridFile& file);

    /// `inherited` plus one line for this run: version, and every option with its value, in --config syntax; no clock
    /// and no host name, so equal runs give equal files.
    std::string history(const std::string& inherited) const;

private:
    struct Shared;
    std::unique_ptr<Shared> shared_;
};

}  // namespace vdbcloud::app
