#include "toml_items.h"

#include "options.h"

#include "vdbcloud/core/error.h"

#include <algorithm>
#include <cmath>
#include <string_view>

namespace vdbcloud::app {

namespace {

const std::string value_kinds = "a number, true, false, \"text\" or a [list]";

/// toml++ says what it was parsing and what is wrong there; what belongs there is said here.
[[noreturn]] void refuse(const toml::parse_error& error)
{
    std::string why = printable(std::string(error.description()));
    const std::string twice = "cannot redefine existing ", prefix = "Error while parsing ";
    const size_t line = error.source().begin.line, quote = why.find('\'');
    if (why.find(twice) != std::string::npos && quote != std::string::npos)
        refuse_line(line, why.substr(quote, why.rfind('\'') - quote + 1) + " is set twice");
    if (why.rfind(prefix, 0) == 0) why.erase(0, prefix.size());
    refuse_line(line, why + "; expected lines key = value, the value " + value_kinds);
}

}  // namespace

void refuse_line(size_t line, const std::string& why) { throw UsageError("line " + std::to_string(line) + ": " + why); }

std::string read_text(std::istream& input, const std::string& path)
{
    constexpr size_t most = size_t(1) << 20;
    std::string text(most + 1, ' ');
    input.read(text.data(), std::streamsize(text.size()));
    text.resize(size_t(input.gcount()));
    if (input.bad()) throw IoError(path + ": cannot read it");
    if (text.size() > most)
        throw IoError(path + ": has more than " + std::to_string(most) + " bytes: expected a smaller configuration");
    return text;
}

toml::table parse_toml(const std::string& text)
{
    try {
        return toml::parse(std::string_view(text));
    } catch (const toml::parse_error& error) {
        refuse(error);
    }
}

TomlItem::TomlItem(const toml::key& key, const toml::node& value)
    : name(key.str()), line(key.source().begin.line), value_(&value)
{
}

std::vector<std::string> TomlItem::words(const CLI::Option& option) const
{
    const bool flag = option.get_items_expected_max() == 0;
    if (flag && !value_->is_boolean()) refuse_line(line, "'" + name + "': expected true or false");
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

std::string TomlItem::word(const toml::node& node) const
{
    if (const auto* text = node.as_string()) return text->get();
    if (const auto* yes = node.as_boolean()) return yes->get() ? "true" : "false";
    if (const auto* whole = node.as_integer()) return std::to_string(whole->get());
    if (const auto* x = node.as_floating_point()) {
        if (std::isfinite(x->get())) return shortest(x->get());
        refuse_line(line, "'" + name + "': expected a finite number; text goes between quotes");
    }
    refuse_line(line, "'" + name + "': expected " + value_kinds);
}

std::string TomlItem::joined(const toml::array& list) const
{
    std::string all;
    for (const toml::node& entry : list) {
        if (entry.is_array()) refuse_line(line, "'" + name + "': a list of lists of lists has no meaning here");
        all += (all.empty() ? "" : ",") + word(entry);
    }
    return all;
}

std::vector<TomlItem> items_of(const toml::table& table)
{
    std::vector<TomlItem> items;
    for (auto&& [key, value] : table) items.emplace_back(key, value);
    std::sort(items.begin(), items.end(), [](const TomlItem& a, const TomlItem& b) { return a.line < b.line; });
    return items;
}

}  // namespace vdbcloud::app
