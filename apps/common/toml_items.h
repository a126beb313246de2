#pragma once
// Lines `key = value` of a TOML file as words of a command line, for --config and --scene. Private to apps/common/.
#include <CLI/Option.hpp>

#include <toml++/toml.h>

#include <istream>
#include <string>
#include <vector>

namespace vdbcloud::app {

/// The whole of `input`. Throws IoError naming `path` if it cannot be read or has more than a mebibyte.
std::string read_text(std::istream& input, const std::string& path);

/// Throws UsageError "line N: ..." for text that is not TOML.
toml::table parse_toml(const std::string& text);

/// Throws UsageError "line N: WHY".
[[noreturn]] void refuse_line(size_t line, const std::string& why);

/// One `key = value`.
class TomlItem {
public:
    TomlItem(const toml::key& key, const toml::node& value);

    /// The value as the words of `option` on a command line. Throws UsageError for a value of no fitting kind.
    std::vector<std::string> words(const CLI::Option& option) const;

    /// The value, which has to outlive nothing but the table.
    const toml::node& value() const { return *value_; }

    std::string name;
    size_t line;

private:
    std::string word(const toml::node&) const;
    std::string joined(const toml::array&) const;

    const toml::node* value_;
};

/// The items of a table in the order of its lines.
std::vector<TomlItem> items_of(const toml::table&);

}  // namespace vdbcloud::app
