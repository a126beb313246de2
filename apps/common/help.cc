#include "help.h"

#include "scene_file.h"

#include <sstream>
#include <vector>

namespace vdbcloud::app {

namespace {

constexpr size_t column = 30, width = 100;

constexpr const char* contract = R"(Files:
  A file named - is standard input or standard output; binary data is not written to a terminal. An output
  appears whole or not at all: it is written beside its place and then renamed. No two options may write one
  file, and none may write a file that is read, but for --output of fractalgen, illuminate, p1solve and
  exrmerge: these read their inputs whole, and the output then takes the place of an input. What a program
  does not use of a .vdb passes through it, and every output says how it was made in its metadata `history`.

Configuration:
  --print-config prints every option as a line `key = value` (a subset of TOML), --config reads such a file
  and refuses a key it does not know. The command line wins.

Exit status:
  0    done
  1    an input was refused or could not be read, an output could not be written, or a limit of memory
       or of processor time was reached
  2    the command line or the configuration is wrong
  3    a solver missed its tolerance, or a result is not finite
  130, 143, 129, 141  ended by SIGINT, SIGTERM, SIGHUP, SIGPIPE; nothing half-written stays

Environment:
  SLURM_CPUS_PER_TASK bounds the threads; NO_COLOR leaves messages plain; TMPDIR is the
  folder for private copies of inputs above 256 MiB.
)";

/// `text` in lines that end before the last column, those after the first moved in.
std::string wrapped(const std::string& text, size_t indent)
{
    std::istringstream words(text);
    std::string out;
    size_t at = indent;
    for (std::string word; words >> word;) {
        if (at > indent && at + 1 + word.size() > width) {
            out += "\n" + std::string(indent, ' ');
            at = indent;
        } else if (at > indent) {
            out += " ";
            ++at;
        }
        out += word;
        at += word.size();
    }
    return out;
}

std::string names_of(const CLI::Option& option)
{
    std::string names;
    for (const std::string& name : option.get_snames()) names += (names.empty() ? "-" : ", -") + name;
    for (const std::string& name : option.get_lnames()) names += (names.empty() ? "--" : ", --") + name;
    return names;
}

/// "[sky] zenith" for a key of scene files, else nothing.
std::string scene_place(const CLI::App& app, const CLI::Option& option)
{
    const auto* tool = dynamic_cast<const App*>(&app);
    if (!tool) return {};
    for (const SceneKey& key : tool->scene_keys())
        if (key.option.cli() == &option) return shown(key);
    return {};
}

std::string row(const CLI::Option& option, bool positional, const std::string& scene = {})
{
    const std::string type = option.get_type_name();
    const size_t colon = type.find(':');
    const std::string kind = type.substr(0, colon);
    std::string left = "  " + (positional ? option.get_name(true) : names_of(option));
    if (!positional && option.get_items_expected_max() > 0 && !kind.empty()) left += " " + kind;
    if (option.get_items_expected_max() > 1 && kind.find("...") == std::string::npos) left += " ...";

    std::string facts;
    const auto add = [&](const std::string& fact) { facts += (facts.empty() ? "" : "; ") + fact; };
    if (option.get_required()) add("required");
    for (size_t from = colon; from != std::string::npos && from + 1 < type.size();) {
        const size_t next = type.find(':', from + 1);
        const std::string range = type.substr(from + 1, next == std::string::npos ? next : next - from - 1);
        if (!range.empty()) add(range);
        from = next;
    }
    if (!option.get_default_str().empty() && option.get_default_str() != "[]")
        add("default " + (option.get_items_expected_max() == 0 ? "on" : option.get_default_str()));
    if (!scene.empty()) add("scene " + scene);
    const std::string text = option.get_description() + (facts.empty() ? "" : " (" + facts + ")");

    left += left.size() + 2 > column ? "\n" + std::string(column, ' ') : std::string(column - left.size(), ' ');
    return left + wrapped(text, column) + "\n";
}

}  // namespace

std::string Help::make_help(const CLI::App* app, std::string, CLI::AppFormatMode mode) const
{
    const bool all = mode == CLI::AppFormatMode::All;
    const auto shown = [](const CLI::Option* option) { return !option->get_group().empty(); };
    std::string usage = "Usage: " + app->get_name() + " [OPTIONS]", positionals, body, listed;
    for (const CLI::Option* option : app->get_options(shown)) {
        if (!option->get_positional()) continue;
        usage += " " + make_option_usage(option);
        positionals += row(*option, true);
    }
    if (const CLI::Option* output = app->get_option_no_throw("--output"); output && output->get_required())
        usage += " -o " + output->get_type_name();
    for (const std::string& group : app->get_groups()) {
        std::string rows;
        for (const CLI::Option* option : app->get_options(shown)) {
            if (option->get_group() != group || !option->nonpositional()) continue;
            if (group != common || all)
                rows += row(*option, false, scene_place(*app, *option));
            else
                listed += (listed.empty() ? "" : " ") + ("--" + option->get_lnames().front());
        }
        if (!rows.empty()) body += "\n" + group + ":\n" + rows;
    }
    if (!listed.empty()) body += "\n" + std::string(common) + ": (--help-all explains)\n  " + wrapped(listed, 2) + "\n";
    return wrapped(app->get_name() + ": " + app->get_description(), 0) + "\n\n" + usage + "\n" +
           (positionals.empty() ? "" : "\nArguments:\n" + positionals) + body +
           (all ? "\n" + std::string(contract) : "") + (app->get_footer().empty() ? "" : "\n" + app->get_footer());
}

}  // namespace vdbcloud::app
