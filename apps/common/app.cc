#include "app.h"

#include "config.h"
#include "frames.h"
#include "help.h"
#include "rungs.h"
#include "scarcity.h"
#include "shared.h"
#include "signals.h"
#include "standard_streams.h"
#include "threads.h"
#include "version.h"

#include "vdbcloud/core/error.h"

#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <new>
#include <utility>

namespace vdbcloud::app {

namespace {

constexpr const char *reading = "Reading", *writing = "Writing";

/// Throws IoError if a file cannot come to be at `path`.
void check_target(const std::string& path, bool no_clobber)
{
    namespace fs = std::filesystem;
    if (path == "-") return require_standard_output();
    if (path.empty()) throw IoError("'': expected a file name to write to");
    std::error_code none;
    if (fs::is_directory(path, none)) throw IoError(one_line(path) + ": expected a file to write to, this is a folder");
    if (no_clobber && fs::exists(path, none))
        throw IoError(one_line(path) + ": file exists and --no-clobber was given");
    const fs::path folder = fs::path(path).parent_path();
    if (!folder.empty() && !fs::is_directory(folder, none))
        throw IoError(one_line(path) + ": there is no folder " + one_line(folder.string()));
}

/// What a run without any of `inputs` has to add: "input or --envelope-from".
std::string names_of(const std::vector<Option>& inputs)
{
    std::string all;
    for (const Option& input : inputs) all += (all.empty() ? "" : " or ") + input.name();
    return all;
}

/// A command in lines of help: where it is long, a line ends after each && and |, where the shell reads on.
std::string broken(std::string command)
{
    if (command.size() < 96) return command;
    for (const std::string end : {" && ", " | "})
        for (size_t at = 0; (at = command.find(end, at)) != std::string::npos;)
            command.replace(at + end.size() - 1, 1, "\n    ");
    return command;
}

// CLI11 reads -output as -o utput.
[[noreturn]] void refuse_single_dash(const std::string& name)
{
    throw UsageError("unknown option '" + name + "'; did you mean '-" + name + "'?");
}

}  // namespace

App::App(const std::string& name, const std::string& summary)
    : CLI::App(summary, name), shared_(std::make_unique<Shared>())
{
    option_defaults()->always_capture_default();
    allow_config_extras(CLI::config_extras_mode::error);
    config_formatter(shared_->toml = std::make_shared<Toml>(*this));
    formatter(std::make_shared<Help>());
}

App::~App() = default;

void App::reads_grids(const std::vector<Option>& inputs)
{
    shared_->reads = true;
    shared_->inputs = inputs;
}

void App::writes_grids() { shared_->writes = shared_->may_clobber = true; }
void App::examples(const std::vector<std::pair<std::string, std::string>>& examples)
{
    std::string text = "Examples:\n";
    if (shared_->rung_option.declared()) text = "Rungs:\n" + shown(rungs()) + "\n" + text;
    for (const auto& [purpose, command] : examples) text += "  # " + purpose + "\n  " + broken(command) + "\n";
    footer(text);
}

void App::never_clobbers() { shared_->may_clobber = true; }

/// After the tool's own options, so that its help begins with those.
void App::declare_shared()
{
    Shared& s = *shared_;
    for (const char* path : {"--output", "input"})
        if (CLI::Option* option = get_option_no_throw(path)) option->type_name("FILE");
    const auto in = [](const char* group, const Option& option) { return option.group(group); };
    if (s.reads) {
        const auto of_reading = [&](const Option& option) {
            in(reading, option)->configurable(false);
            if (s.inputs.empty()) return option;
            const auto any_given = [inputs = s.inputs] {
                return std::any_of(inputs.begin(), inputs.end(), [](const Option& input) { return input.given(); });
            };
            return option.only_with(any_given, names_of(s.inputs));
        };
        of_reading(add_flag("--trust-input", s.trust_input,
                            "read in this process, without the guard against damaged files; use it for files of your "
                            "own, it is faster"));
        of_reading(add_option("--max-input", s.max_input, "refuse inputs larger than this [GiB]"))->check(positive);
    }
    if (s.may_clobber)
        in(writing, add_flag("--no-clobber", s.no_clobber,
                             "end with status 1 if an output file exists, instead of replacing it"))
            ->configurable(false);
    if (s.writes) {
        in(writing, add_choice<Compression>(
                        "--compression", s.compression,
                        {{"blosc", Compression::Blosc}, {"zip", Compression::Zip}, {"none", Compression::None}},
                        "compression of the output; blosc is fast, zip is smaller, none suits pipes"));
        in(writing,
           add_flag("--half", s.half, "write density, Cd and moments as 16-bit floats: half the size, three digits"));
        if (CLI::Option* input = s.reads ? get_option_no_throw("input") : nullptr) {
            const Option keep = in(writing, add_option("--keep", s.keep,
                                                       "grids to copy from the input that this program does not use: "
                                                       "all, none, or names a,b,c"));
            if (!input->get_required()) keep.needs(Option(*this, input));
        }
    }
    declare_frames();
    if (!s.scene_keys.empty()) declare_scene();
    declare_common();
}

void App::declare_common()
{
    Shared& s = *shared_;
    const auto machine = [this](CLI::Option* option) {
        return Option(*this, option).configurable(false).group(common);
    };
    const auto shared = [](const Option& option) { return option.configurable(false).group(common); };
    shared(add_option("--threads", s.threads,
                      "number of threads; 0: all that this process may use. Results do not depend on it"))
        ->check(within(0, 4096));
    shared(add_choice<int>(
        "--progress", s.progress_choice, {{"auto", 0}, {"always", 1}, {"never", 2}, {"machine", 3}},
        "auto: a bar on a terminal; always: lines, too; never: none; machine: a JSON line each second"));
    shared(add_flag("-q,--quiet", s.quiet, "print warnings and errors alone on standard error"));
    machine(CLI::App::add_flag("-v,--verbose", s.verbosity, "print the time of each phase and more on standard error"));
    shared(add_flag("--werror", s.werror, "end with status 1 at the first warning; use it in scripts"));
    shared(add_option("--json", s.json, "write a report of the run as JSON to FILE, or - for standard output"))
        ->type_name("FILE")
        ->writes_file(FileKind::Report);
    shared(add_flag("--dry-run", s.dry_run, "read the input and estimate memory and time, compute and write nothing"));
    shared(add_flag("-f,--force", s.force, "write binary data even to a terminal"));
    const Option config =
        machine(set_config("--config", "", "read options from FILE (TOML, lines key = value); the command line wins"))
            ->type_name("FILE");
    s.files.push_back({config, std::nullopt, false, true});
    shared(add_flag("--print-config", s.print_config, "print all options as a file for --config, and exit"));
    const std::string name = get_name();
    set_version_flag(
        "--version", [name] { return version_text(name); }, "print versions and codecs, and exit")
        ->group(common);
    set_help_flag("-h,--help", "print this help, and exit")->group(common);
    set_help_all_flag("--help-all",
                      "print this help with the options of every program, files, exit status and signals, and exit")
        ->group(common);
    CLI::App::add_option("--completion", s.completion)->configurable(false)->group("");
}

void App::declare_scene()
{
    Shared& s = *shared_;
    const auto of_scene_file = [](const Option& option) { return option.configurable(false).group("Scene"); };
    of_scene_file(
        add_option("--scene", s.scene,
                   "read medium, lights, sky, camera and so on from FILE, which all programs of a picture share: "
                   "each takes its keys, and refuses what is no key of any program. --config and the command "
                   "line win"))
        ->type_name("FILE");
    s.files.push_back({Option(*this, get_option("--scene")), std::nullopt, false, true});
    of_scene_file(
        add_flag("--print-scene", s.print_scene,
                 "print the part of the scene file that this program takes, in one form whatever the order of "
                 "its lines, and exit; to see whether a change concerns this program"));
}

void App::add_work(const Workload& work) { shared_->work += work; }
Workload App::take_work() { return std::exchange(shared_->work, {}); }

bool App::dry_run() const { return shared_->dry_run; }
bool App::verbose() const { return shared_->verbosity > 0; }
bool App::no_clobber() const { return shared_->no_clobber; }
nlohmann::json& App::report() { return shared_->report; }
void App::uses(const std::string& grid_name) { shared_->used.insert(grid_name); }

int App::threads() const { return shared_->threads > 0 ? shared_->threads : allowed_threads(); }

bool App::on_command_line(const CLI::Option* option) const
{
    const std::vector<CLI::Option*> typed = parse_order();
    return std::count(typed.begin(), typed.end(), option) > 0;
}

std::string App::place(const CLI::Option* option) const
{
    if (on_command_line(option)) return "";
    const auto found = shared_->scene_places.find(option);
    return found == shared_->scene_places.end() ? shared_->toml->place(option) : found->second;
}

Progress App::progress(const std::string& label) { return shared_->meter.of(label); }

void App::say(const std::string& line)
{
    if (!shared_->quiet) shared_->meter.line(get_name() + ": " + one_line(line));
}

Warn App::warnings()
{
    return [this](const std::string& sentence) {
        Shared& s = *shared_;
        {
            const std::lock_guard<std::mutex> lock(s.mutex);
            s.warnings.push_back(one_line(sentence));
        }
        if (s.werror) throw InputError(sentence + " (a warning, and --werror was given)");
        const bool colour = coloured();
        s.meter.line(get_name() + ": " + (colour ? "\033[33mwarning:\033[0m " : "warning: ") + one_line(sentence));
    };
}

void App::print(const std::string& text)
{
    if (shared_->json != "-") to_standard_output(text);
}

void App::check_output(const std::string& path) const
{
    if (path == "-" && ::isatty(STDOUT_FILENO) && !shared_->force)
        throw UsageError("standard output is a terminal: redirect it, name a file, or insist with --force");
    check_target(path, shared_->no_clobber);
}

/// Looks at the place of each output before the work. The folder of numbered frames may be made later.
void App::check_places() const
{
    const Shared& s = *shared_;
    const auto folder_of = [](const std::string& path) { return std::filesystem::path(path).parent_path(); };
    const auto makes_folder_of = [&](const std::string& path) {
        return std::any_of(s.files.begin(), s.files.end(), [&](const NamedFile& file) {
            return file.kind && file.own_number && file.option.cli()->count() > 0 &&
                   folder_of(file.option.cli()->results().back()) == folder_of(path);
        });
    };
    for (const NamedFile& file : s.files) {
        const CLI::Option* option = file.option.cli();
        const std::string path = file.kind && option->count() ? at_frame(option->results().back()) : "";
        if (path.empty() || (file.kind == FileKind::Other && makes_folder_of(path))) continue;
        if (file.kind == FileKind::Report || file.kind == FileKind::Other)
            check_target(path, false);
        else if (const bool later = file.own_number || (!s.numbers.empty() && !s.frame);
                 !dry_run() && !(later && FramePattern::in(file.option.name(), path)))
            check_output(path);
    }
}

void App::begin()
{
    Shared& s = *shared_;
    check_frames();
    check_files();
    leave_out_idle_scene();
    for (const Rule& rule : s.rules) rule.check();
    const bool tty = ::isatty(STDERR_FILENO);
    Meter::Mode mode = s.quiet || !tty ? Meter::Off : Meter::Bar;
    if (s.progress_choice == 1) mode = tty ? Meter::Bar : Meter::Lines;
    if (s.progress_choice == 2) mode = Meter::Off;
    if (s.progress_choice == 3) mode = Meter::Machine;
    s.meter.set(mode, get_name());

    check_places();

    s.parameters = parameters_of(*this);
    s.limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                    size_t(startable_threads(threads())));
    if (!s.json.empty() && s.json != "-") {
        const nlohmann::json ended = finished_report("STATUS", "ended by SIGNAL");
        report_if_ended(s.json, ended.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
    }
}

bool App::parse_line(int argc, char** argv)
{
    Shared& s = *shared_;
    declare_shared();
    for (int k = 1; k < argc && std::string(argv[k]) != "--"; ++k) {
        const std::string word = argv[k];
        if (word.size() > 3 && word.rfind("--", 0) == 0 && word.back() == '=' && word.find('=') == word.size() - 1)
            throw UsageError(word.substr(0, word.size() - 1) + ": expected a value after =");
        const std::string name = word.substr(0, word.find('='));
        if (name.size() > 2 && name[0] == '-' && name[1] != '-' && get_option_no_throw("-" + name))
            refuse_single_dash(name);
    }
    try {
        parse(argc, argv);
    } catch (const CLI::CallForHelp&) {
        return to_standard_output(help()), false;
    } catch (const CLI::CallForAllHelp&) {
        return to_standard_output(help("", CLI::AppFormatMode::All)), false;
    } catch (const CLI::CallForVersion& versions) {
        return to_standard_output(versions.what()), false;
    } catch (const CLI::RequiredError&) {
        if (remaining_size() > 0) throw CLI::ExtrasError(remaining());
        if (!s.print_config && !s.print_scene && s.completion.empty()) throw;
    }
    if (s.completion.empty() && !read_scene()) return false;
    apply_rung();
    if (!s.completion.empty()) return to_standard_output(completion_script(*this, s.completion)), false;
    if (s.print_config) return to_standard_output(config_to_str(true, true)), false;
    return true;
}

App::Outcome App::attempt(const std::function<void()>& work)
{
    try {
        work();
        return {};
    } catch (const Cancelled&) {
        return {128 + SIGINT, "interrupted"};
    } catch (const UsageError& error) {
        return {usage, error.what() + set_by_rung(error.what())};
    } catch (const ConvergenceError& error) {
        return {unconverged, error.what()};
    } catch (const CLI::FileError& error) {
        return {failed, explain(error)};
    } catch (const CLI::ParseError& error) {
        return {usage, explain(error)};
    } catch (const std::exception& error) {
        const char* const scarce = scarcity();
        return {failed, scarce ? scarce : error.what()};
    } catch (...) {
        return {failed, "internal error: an object that is no exception was thrown"};
    }
}

int App::run(int argc, char** argv, const std::function<void()>& body)
{
    Shared& s = *shared_;
    occupy_standard_descriptors();
    install_signals(get_name());
    bool ran = false;
    Outcome outcome = attempt([&] {
        if (!parse_line(argc, argv)) return;
        ran = true;
        begin();
        body();
    });
    s.meter.clear();
    if (!ran) {
        if (s.json.empty()) s.json = json_asked(argc, argv);
        forget_unsafe_report(argc, argv);
    }
    if (!s.json.empty() && (ran || outcome.status != ok)) {
        const Outcome reported =
            attempt([&] { write_report(s.json, finished_report(outcome.status, outcome.message)); });
        if (outcome.status == ok)
            outcome = reported;
        else if (reported.status != ok)
            outcome.message += "; and " + reported.message;
    }
    report_if_ended("", "");
    if (outcome.status == 128 + SIGINT) end_by(SIGINT);
    if (outcome.status != ok) {
        const std::string what =
            outcome.message.empty() ? "internal error: exception without a message" : one_line(outcome.message);
        s.meter.line((coloured() ? "\033[31m" + get_name() + ":\033[0m " : get_name() + ": ") + what);
    }
    return outcome.status;
}

}  // namespace vdbcloud::app
