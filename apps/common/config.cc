#include "config.h"

#include "nearest.h"
#include "options.h"

#include "vdbcloud/core/error.h"

#include <toml++/toml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <istream>
#include <string_view>

namespace vdbcloud::app {

namespace {

const std::string value_kinds = "a number, true, false, \"text\" or a [list]";

[[noreturn]] void refuse(size_t line, const std::string& why)
{
    throw UsageError("line " + std::to_string(line) + ": " + why);
}

/// toml++ says what it was parsing and what is wrong there; what belongs there is said here.
[[noreturn]] void refuse(const toml::parse_error& error)
{
    std::string why = printable(std::string(error.description()));
    const std::string twice = "cannot redefine existing ", prefix = "Error while parsing ";
    const size_t line = error.source().begin.line, quote = why.find('\'');
    if (why.find(twice) != std::string::npos && quote != std::string::npos)
        refuse(line, why.substr(quote, why.rfind('\'') - quote + 1) + " is set twice");
    if (why.rfind(prefix, 0) == 0) why.erase(0, prefix.size());
    refuse(line, why + "; expected lines key = value, the value " + value_kinds);
}

toml::table parsed(const std::string& text)
{
    try {
        return toml::parse(std::string_view(text));
    } catch (const toml::parse_error& error) {
        refuse(error);
    }
}

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

/// The words of one `key = value`, as they would stand on the command line.
class Item {
public:
    Item(const toml::key& key, const toml::node& value) : name(key.str()), line(key.source().begin.line), value_(&value)
    {
    }

    std::vector<std::string> words(const CLI::Option& option) const
    {
        const bool flag = option.get_items_expected_max() == 0;
        if (flag && !value_->is_boolean()) refuse(line, "'" + name + "': expected true or false");
        const toml::array* list = value_->as_array();
        if (!list) return {word(*value_)};
        std::vector<std::string> all;
        bool nested = false;
        for (const toml::node& entry : *list) {
            nested = nested || entry.is_array();
            all.push_back(entry.is_array() ? joined(*entry.as_array()) : word(entry));
        }
        // [0.3, 1, 0.2] for an option of one word is the vector "0.3,1,0.2".
        const bool vector = option.get_items_expected_max() == 1 && !nested && !all.empty() && number(all.front());
        return vector ? std::vector<std::string>{joined(*list)} : all;
    }

    std::string name;
    size_t line;

private:
    std::string word(const toml::node& node) const
    {
        if (const auto* text = node.as_string()) return text->get();
        if (const auto* yes = node.as_boolean()) return yes->get() ? "true" : "false";
        if (const auto* whole = node.as_integer()) return std::to_string(whole->get());
        if (const auto* x = node.as_floating_point()) {
            if (std::isfinite(x->get())) return shortest(x->get());
            refuse(line, "'" + name + "': expected a finite number; text goes between quotes");
        }
        refuse(line, "'" + name + "': expected " + value_kinds);
    }

    std::string joined(const toml::array& list) const
    {
        std::string all;
        for (const toml::node& entry : list) {
            if (entry.is_array()) refuse(line, "'" + name + "': a list of lists of lists has no meaning here");
            all += (all.empty() ? "" : ",") + word(entry);
        }
        return all;
    }

    const toml::node* value_;
};

/// What the file holds, in the order of its lines. Throws UsageError "line N: ...".
std::vector<Item> items_of(const toml::table& table)
{
    std::vector<Item> items;
    for (auto&& [key, value] : table) {
        const Item& item = items.emplace_back(key, value);
        if (value.is_table())
            refuse(item.line,
                   "'" + printable(item.name) + "' is a table: tables are not used here, only lines key = value");
    }
    std::sort(items.begin(), items.end(), [](const Item& a, const Item& b) { return a.line < b.line; });
    return items;
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
    constexpr size_t most = size_t(1) << 20;
    std::string text(most + 1, ' ');
    input.read(text.data(), std::streamsize(text.size()));
    text.resize(size_t(input.gcount()));
    if (input.bad()) throw IoError(path + ": cannot read it");
    if (text.size() > most)
        throw IoError(path + ": has more than " + std::to_string(most) + " bytes: expected a smaller configuration");
    std::vector<CLI::ConfigItem> all;
    try {
        const toml::table table = parsed(text);
        for (const Item& item : items_of(table)) {
            const CLI::Option* option = option_called(app_, item.name);
            if (!option) refuse(item.line, "unknown key '" + printable(item.name) + "'" + suggestion(app_, item.name));
            if (!option->get_configurable())
                refuse(item.line, "'" + item.name + "' belongs on the command line, not in a file");
            if (!places_.emplace(option, path + ": line " + std::to_string(item.line) + ": ").second)
                refuse(item.line, "'" + item.name + "' is set twice");
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
