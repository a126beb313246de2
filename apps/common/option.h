#pragma once
// A handle of a declared option: how the option is shown and checked, when it has an effect, whether it was given.
#include "named_files.h"

#include <CLI/Option.hpp>

#include <functional>
#include <string>

namespace vdbcloud::app {

class App;

/// What App::add_option() and its like return. Copies stand for the same option; the App has to outlive them. Every
/// call on a handle of no option throws std::logic_error. The declaring calls return the handle, and `->` is `.`, so
/// that they chain: app.add_option(...)->check(positive)->group("Accuracy").
///
/// An option that has no effect with the values of the others is refused with status 2, in one sentence that names both
/// options and the way out. Where the values alone decide, say it in the declaration: needs(), only_with(), not_with().
/// Where the input decides, say it in the program: check_effect().
class Option {
public:
    Option() = default;
    Option(const App& app, CLI::Option* option) : app_(&app), option_(option) {}

    // As CLI::Option's.
    Option check(const CLI::Validator&) const;
    Option group(const std::string&) const;
    Option required() const;
    Option configurable(bool) const;
    Option default_str(const std::string&) const;
    Option type_name(const std::string&) const;
    Option expected(int) const;
    Option allow_extra_args() const;

    /// The option names files that the program reads.
    Option reads_files() const;
    /// The option names a file that the program writes. run() then refuses, with status 2 and before any work, a name
    /// that does not fit the kind, a file that another option writes, and a file that the program reads.
    Option writes_file(FileKind) const;
    /// The same, and the file may be one that the program reads: for programs that read their input whole and pass on
    /// what it holds.
    Option rewrites_file(FileKind) const;
    /// The same as writes_file(); the program itself puts numbers of frames into the name.
    Option writes_frames(FileKind) const;

    /// The option is a key of scene files (--scene), in a section of scene_sections(). Without `key` the key is the
    /// name of the option, less that of the section: zenith of [sky] is --sky-zenith. Options of several programs with
    /// one key have one meaning. In a scene file an option without effect is left out, not refused: another program may
    /// use it.
    Option scene(const std::string& section, const std::string& key = {}) const;
    /// The same for a parameter of a light in [[lights]], whose place is the option `light`. `otherwise`: its value
    /// where a light gives none.
    Option scene_light(const Option& light, const std::string& otherwise) const;
    /// True if the scene file gave the value that is in force.
    bool by_scene() const;

    /// No effect unless `other` was given.
    Option needs(const Option& other) const;
    /// No effect unless `met` once all options are read; `wanted` is what to add to the command: "--integrator steps".
    Option only_with(const std::function<bool()>& met, const std::string& wanted) const;
    /// No effect if `met` once all options are read; `unwanted` is what to leave out: "--shadow-rays".
    Option not_with(std::function<bool()> met, const std::string& unwanted) const;
    /// The same as only_with(), now. Throws UsageError if the option was given and `met` is false. Of a sequence one
    /// frame is enough, since a fire is cold before it is lit: the end of the last frame throws where none was.
    void check_effect(bool met, const std::string& wanted) const;

    /// A rung leaves the option as it is if `met` once all options are read, and those before it in the table are set.
    Option no_rung_with(std::function<bool()> met) const;
    /// True if --rung has set the value that is in force.
    bool by_rung() const;

    /// True if the user gave the option on the command line, in the scene file, or in the --config file with another
    /// value than its default: a file that --print-config wrote gives nothing that was not given. An option whose
    /// default has a meaning that no value expresses has none: ->default_str("").
    bool given() const;
    /// "--fov", or the name of a positional.
    std::string name() const;
    /// The option and the value that is in force, as on a command line: "--fov 45".
    std::string text() const;

    CLI::Option* cli() const;
    bool declared() const { return option_; }
    const Option* operator->() const { return this; }

private:
    [[noreturn]] void refuse(const std::string& why) const;
    void rule(const std::function<bool()>& holds, const std::string& why) const;

    const App* app_ = nullptr;
    CLI::Option* option_ = nullptr;
};

}  // namespace vdbcloud::app
