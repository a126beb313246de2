#include "config.h"

#include "nearest.h"
#include "options.h"
#include "toml_items.h"

#include "vdbcloud/core/error.h"

#include <charconv>
#include <cstdint>
#include <istream>

namespace vdbcloud::app {

namespace {

/// A number as TOML writes it, the same text for each way to write it; in quotes what exceeds TOML's integers.
std::string toml_number(const std::string& word)
{
    const char *begin = word.data() + (word[0] == '+'), *end = word.data() + word.size();
    int64_t whole = 0;
    if (const auto read = std::from_chars(begin, end, whole); read.ec == std::errc() && read.ptr == end)
        return std::to_string(whole);
    uint64_t large = 0;  // seeds use all 64 bits
    if (const auto read = std::from_chars(begin, end, large); read.ec == std::errc() && read.ptr == end)
        return quoted(word);
    const std::string text = shortest(*number(word));
    if (text.find_first_of(".e") != std::string::npos) return text;
    return text.size() > 18 ? text + ".0" : toml_number(text);
}

const CLI::Option* option_called(const CLI::App& app, const std::string& key)
{
    const CLI::Option* option = app.get_option_no_throw("--" + key);
    if (!option && key.size() == 1) option = app.get_option_no_throw("-" + key);
    return option ? option : app.get_option_no_throw(key);
}

}  // namespace

std::string suggestion(const CLI::App& app, const std::string& name, const std::string& dashes)
{
    std::vector<std::string> known;
    for (const CLI::Option* option : app.get_options())
        if (!option->get_group().empty())
            known.insert(known.end(), option->get_lnames().begin(), option->get_lnames().end());
    const std::string best = nearest(name, known);
    return best.empty() ? "" : "; did you mean '" + dashes + best + "'?";
}

std::string quoted(const std::string& text)
{
    std::string out = "\"";
    for (char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (c == '"' || c == '\\') {
            out += {'\\', c};
        } else if (c == '\n') {
            out += "\\n";
        } else if (c == '\t') {
            out += "\\t";
        } else if (byte < 0x20 || byte == 0x7f) {
            const char* digits = "0123456789abcdef";
            out += "\\u00";
            out += {digits[byte >> 4], digits[byte & 15]};
        } else {
            out += c;
        }
    }
    return out + "\"";
}

std::string toml(const Setting& setting)
{
    if (setting.kind == Setting::Flag) return setting.words.front();
    const auto one = [&](const std::string& word) -> std::string {
        if (!setting.numeric) return quoted(word);
        if (word.find(',') == std::string::npos) return toml_number(word);
        std::string list;
        const auto parts = numbers(word);
        for (double x : *parts) list += (list.empty() ? "" : ", ") + toml_number(shortest(x));
        return "[" + list + "]";
    };
    if (setting.kind == Setting::One) return one(setting.words.front());
    std::string list;
    for (const std::string& word : setting.words) list += (list.empty() ? "" : ", ") + one(word);
    return "[" + list + "]";
}

std::vector<CLI::ConfigItem> Toml::from_config(std::istream& input) const
{
    const std::string path = printable(app_.get_config_ptr()->results().back(), 4096);
    const std::string text = read_text(input, path);
    std::vector<CLI::ConfigItem> all;
    try {
        const toml::table table = parse_toml(text);
        for (const TomlItem& item : items_of(table)) {
            if (item.value().is_table())
                refuse_line(item.line, "'" + printable(item.name) +
                                           "' is a table: tables are not used here, only lines key = value");
            const CLI::Option* option = option_called(app_, item.name);
            if (!option)
                refuse_line(item.line, "unknown key '" + printable(item.name) + "'" + suggestion(app_, item.name));
            if (!option->get_configurable())
                refuse_line(item.line, "'" + item.name + "' belongs on the command line, not in a file");
            if (!places_.emplace(option, path + ": line " + std::to_string(item.line) + ": ").second)
                refuse_line(item.line, "'" + item.name + "' is set twice");
            CLI::ConfigItem& read = all.emplace_back();
            read.name = item.name;
            read.inputs = item.words(*option);
        }
    } catch (const UsageError& error) {
        throw UsageError(path + ": " + error.what());
    }
    return all;
}

std::string Toml::place(const CLI::Option* option) const
{
    const auto found = places_.find(option);
    return found == places_.end() ? "" : found->second;
}

std::string Toml::to_config(const CLI::App* app, bool default_also, bool descriptions, std::string prefix) const
{
    std::string out;
    for (const Setting& setting : settings(*app)) {
        if (!default_also && setting.option->count() == 0) continue;
        if (descriptions) out += "# " + setting.option->get_description() + "\n";
        const std::string key = prefix + setting.name;
        out += setting.words.empty() ? "# " + key + " =\n" : key + " = " + toml(setting) + "\n";
    }
    return out;
}

}  // namespace vdbcloud::app
