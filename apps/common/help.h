#pragma once
// --help and shell completion, both from the table of options.
#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>

#include <string>

namespace vdbcloud::app {

/// The group of options that all programs have; --help only lists them, --help-all explains them.
inline constexpr const char* common = "Every program";

/// Help in two columns, at most 100 wide: names and kind of value, then what it does, its range and its default.
class Help : public CLI::Formatter {
public:
    std::string make_help(const CLI::App*, std::string name, CLI::AppFormatMode) const override;
};

/// A script for `shell` (bash, zsh or fish) that completes the options of `app`. Throws UsageError for another shell.
std::string completion_script(const CLI::App& app, const std::string& shell);

}  // namespace vdbcloud::app
