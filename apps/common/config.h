#pragma once
// The --config file: a strict subset of TOML, in which a mistyped key is an error.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>

#include <map>
#include <string>
#include <vector>

namespace vdbcloud::app {

/// Reads TOML, writes lines `key = value`, where a key is the name of an option and a value is a number, true, false,
/// text or a [list] of these. A list of numbers for an option of one word is the word "1,2,3". Tables ([name]) are not
/// used. Numbers are written in one way each: 1e5, 100000.0 and +1e+05 are all `1e+05`.
///
/// Reading throws UsageError "FILE: line N: ...": for what is not TOML, for a key that is no option or belongs on the
/// command line, and for a key that is set twice.
class Toml : public CLI::Config {
public:
    explicit Toml(const CLI::App& app) : app_(app) {}
    std::vector<CLI::ConfigItem> from_config(std::istream&) const override;
    std::string to_config(const CLI::App*, bool default_also, bool descriptions, std::string prefix) const override;

    /// "FILE: line N: " where the file that was read gave `option`, else nothing.
    std::string place(const CLI::Option* option) const;

private:
    const CLI::App& app_;
    mutable std::map<const CLI::Option*, std::string> places_;  // reading is const in CLI11's interface
};

/// `text` between quotes, with TOML's escapes.
std::string quoted(const std::string& text);

/// "; did you mean X?" if an option has a name much like `name`, else nothing.
std::string suggestion(const CLI::App&, const std::string& name, const std::string& dashes = {});

}  // namespace vdbcloud::app
