#include "config.h"

#include "options.h"

#include "vdbcloud/core/error.h"

#include <algorithm>
#include <cctype>
#include <istream>
#include <iterator>
#include <numeric>

namespace vdbcloud::app {

namespace {

bool bare(char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-'; }

/// A number as TOML writes it: no leading +, no leading zeros, digits on both sides of a point.
bool toml_number(const std::string& word)
{
    if (!number(word)) return false;
    const size_t first = word[0] == '-', point = word.find('.');
    if (first >= word.size() || !std::isdigit(static_cast<unsigned char>(word[first]))) return false;
    if (word[first] == '0' && first + 1 < word.size() && std::isdigit(static_cast<unsigned char>(word[first + 1])))
        return false;
    return point == std::string::npos ||
           (point + 1 < word.size() && std::isdigit(static_cast<unsigned char>(word[point + 1])));
}

void append_utf8(std::string& out, unsigned long code)
{
    if (code < 0x80) {
        out += char(code);
    } else if (code < 0x800) {
        out += {char(0xc0 | (code >> 6)), char(0x80 | (code & 63))};
    } else if (code < 0x10000) {
        out += {char(0xe0 | (code >> 12)), char(0x80 | ((code >> 6) & 63)), char(0x80 | (code & 63))};
    } else {
        out += {char(0xf0 | (code >> 18)), char(0x80 | ((code >> 12) & 63)), char(0x80 | ((code >> 6) & 63)),
                char(0x80 | (code & 63))};
    }
}

/// A cursor over the text of a config file.
class Reader {
public:
    explicit Reader(std::string text) : text_(std::move(text)) {}

    [[noreturn]] void refuse(const std::string& why) const
    {
        throw UsageError("line " + std::to_string(line_) + ": " + why);
    }

    size_t line() const { return line_; }
    char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }
    bool done() const { return at_ >= text_.size(); }

    char next()
    {
        const char c = text_[at_++];
        if (c == '\n') ++line_;
        return c;
    }

    /// Passes over blanks and comments, and over ends of lines if asked.
    void skip(bool lines)
    {
        while (!done()) {
            if (peek() == '#') {
                while (!done() && peek() != '\n') next();
            } else if (peek() == ' ' || peek() == '\t' || peek() == '\r' || (lines && peek() == '\n')) {
                next();
            } else {
                return;
            }
        }
    }

    std::string key()
    {
        if (peek() == '"' || peek() == '\'') return string();
        if (peek() == '[') refuse("tables are not used here, only lines like key = value");
        std::string name;
        while (bare(peek())) name += next();
        if (name.empty()) refuse("expected a line like key = value");
        return name;
    }

    /// One word: a number, true, false or a string.
    std::string word()
    {
        if (peek() == '"' || peek() == '\'') return string();
        std::string token;
        while (bare(peek()) || peek() == '+' || peek() == '.') token += next();
        if (token == "true" || token == "false" || number(token)) return token;
        if (token.empty()) refuse("expected a value: a number, true, false, \"text\" or a [list]");
        refuse("'" + printable(token) + "': text goes between quotes, and numbers are finite");
    }

    /// A list; an inner list becomes one word "a,b,c".
    std::vector<std::string> list(bool inner, bool& nested)
    {
        std::vector<std::string> words;
        next();
        for (skip(true); peek() != ']'; skip(true)) {
            if (peek() == '[') {
                if (inner) refuse("lists within lists of lists are not used here");
                nested = true;
                words.push_back(join(list(true, nested)));
            } else {
                words.push_back(word());
            }
            skip(true);
            if (done()) refuse("a list has no end");
            if (peek() == ',')
                next();
            else if (peek() != ']')
                refuse("expected , or ] in a list");
        }
        next();
        return words;
    }

    static std::string join(const std::vector<std::string>& words)
    {
        std::string joined;
        for (size_t k = 0; k < words.size(); ++k) joined += (k ? "," : "") + words[k];
        return joined;
    }

private:
    std::string string()
    {
        const char quote = next();
        std::string out;
        for (;;) {
            if (done() || peek() == '\n') refuse("a string has no closing quote");
            const char c = next();
            if (c == quote) return out;
            if (c == '\\' && quote == '"')
                escape(out);
            else
                out += c;
        }
    }

    void escape(std::string& out)
    {
        static const std::string letters = "btnfr\"\\", meanings = "\b\t\n\f\r\"\\";
        const char c = done() ? '\0' : next();
        if (const size_t k = letters.find(c); c && k != std::string::npos) {
            out += meanings[k];
        } else if (c == 'u' || c == 'U') {
            std::string digits;
            while (digits.size() < (c == 'u' ? 4u : 8u) && std::isxdigit(static_cast<unsigned char>(peek())))
                digits += next();
            if (digits.size() != (c == 'u' ? 4u : 8u)) refuse("expected hexadecimal digits after \\u");
            const unsigned long code = std::stoul(digits, nullptr, 16);
            if (code == 0 || code > 0x10ffff || (code >= 0xd800 && code < 0xe000)) refuse("no character has this code");
            append_utf8(out, code);
        } else {
            refuse("an unknown escape in a string");
        }
    }

    std::string text_;
    size_t at_ = 0;
    size_t line_ = 1;
};

const CLI::Option* option_called(const CLI::App& app, const std::string& key)
{
    const CLI::Option* option = app.get_option_no_throw("--" + key);
    if (!option && key.size() == 1) option = app.get_option_no_throw("-" + key);
    return option ? option : app.get_option_no_throw(key);
}

CLI::ConfigItem read_item(Reader& in, const CLI::App& app)
{
    CLI::ConfigItem item;
    item.name = in.key();
    const CLI::Option* option = option_called(app, item.name);
    if (!option) in.refuse("unknown key '" + printable(item.name) + "'" + suggestion(app, item.name));
    if (!option->get_configurable()) in.refuse("'" + item.name + "' belongs on the command line, not in a file");
    in.skip(false);
    if (in.peek() != '=') in.refuse("expected = after '" + item.name + "'");
    in.next();
    in.skip(false);
    if (in.peek() == '[') {
        bool nested = false;
        item.inputs = in.list(false, nested);
        const bool one_word = option->get_items_expected_max() == 1 && !nested;
        if (one_word && !item.inputs.empty() && numbers(item.inputs.front()) &&
            item.inputs.front().find(',') == std::string::npos)
            item.inputs = {Reader::join(item.inputs)};
    } else {
        item.inputs = {in.word()};
    }
    const bool flag = option->get_items_expected_max() == 0;
    if (flag && (item.inputs.size() != 1 || (item.inputs[0] != "true" && item.inputs[0] != "false")))
        in.refuse("'" + item.name + "': expected true or false");
    in.skip(false);
    if (!in.done() && in.peek() != '\n')
        in.refuse("expected the end of the line after the value of '" + item.name + "'");
    return item;
}

size_t edits(const std::string& a, const std::string& b)
{
    std::vector<size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), size_t(0));
    for (size_t i = 1; i <= a.size(); ++i) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= b.size(); ++j) {
            const size_t above = row[j];
            row[j] = std::min({above + 1, row[j - 1] + 1, diagonal + (a[i - 1] != b[j - 1])});
            diagonal = above;
        }
    }
    return row[b.size()];
}

}  // namespace

std::string suggestion(const CLI::App& app, const std::string& name, const std::string& dashes)
{
    std::string best;
    size_t least = std::min<size_t>(3, 1 + name.size() / 3);
    for (const CLI::Option* option : app.get_options()) {
        if (option->get_group().empty()) continue;
        for (const std::string& known : option->get_lnames()) {
            const size_t distance = edits(name.substr(0, 64), known);
            if (distance >= least) continue;
            least = distance;
            best = known;
        }
    }
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
        if (word.find(',') == std::string::npos) return toml_number(word) ? word : quoted(word);
        std::string list;
        const auto parts = numbers(word);
        for (double x : *parts) list += (list.empty() ? "" : ", ") + shortest(x);
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
    std::string text{std::istreambuf_iterator<char>(input), {}};
    if (input.bad()) throw IoError(path + ": cannot read it");
    Reader in(std::move(text));
    std::vector<CLI::ConfigItem> all;
    try {
        for (in.skip(true); !in.done(); in.skip(true)) {
            const std::string place = path + ": line " + std::to_string(in.line()) + ": ";
            all.push_back(read_item(in, app_));
            if (!places_.emplace(option_called(app_, all.back().name), place).second)
                in.refuse("'" + all.back().name + "' is there twice");
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
