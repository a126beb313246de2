#include "app.h"

#include "options.h"

#include "vdbcloud/core/number_range.h"

#include <cctype>
#include <cmath>
#include <cstdio>
#include <limits>

namespace vdbcloud::app {

namespace {

/// A validator that holds for each number of a list; the sentence names the word as the user wrote it.
CLI::Validator each(const std::string& expected, const std::string& shown, std::function<bool(double)> holds)
{
    const auto check = [=](const std::string& text) -> std::string {
        const auto values = numbers(text);
        bool good = values.has_value();
        for (size_t k = 0; good && k < values->size(); ++k) {
            const double x = (*values)[k];
            if (std::abs(x) > largest_number)
                return "'" + text + "': expected numbers of a size up to " + shortest(largest_number);
            good = holds(x);
        }
        return good ? std::string() : "'" + text + "': expected " + expected;
    };
    return CLI::Validator(check, shown);
}

CLI::Validator vector_of(bool one_will_do)
{
    const std::string expected = one_will_do ? "one finite number, or three as r,g,b" : "three finite numbers x,y,z";
    return CLI::Validator(
        [=](const std::string& text) -> std::string {
            const auto values = numbers(text);
            const bool good = values && (values->size() == 3 || (one_will_do && values->size() == 1));
            return good ? std::string() : "'" + text + "': expected " + expected;
        },
        "");
}

bool read_vector(const std::string& text, Vec3d& out)
{
    const auto values = numbers(text);
    if (!values) return false;
    const std::vector<double>& v = *values;
    if (v.size() == 1)
        out = Vec3d(v[0], v[0], v[0]);
    else if (v.size() == 3)
        out = Vec3d(v[0], v[1], v[2]);
    else
        return false;
    return true;
}

}  // namespace

std::vector<std::string> split(const std::string& text, char at)
{
    std::vector<std::string> parts(1);
    for (char c : text)
        if (c == at)
            parts.emplace_back();
        else
            parts.back() += c;
    return parts;
}

std::optional<double> number(const std::string& text)
{
    const char *begin = text.data(), *end = begin + text.size();
    if (text.size() > 1 && *begin == '+' && begin[1] != '-') ++begin;
    double x = 0;
    const auto [rest, error] = std::from_chars(begin, end, x);
    if (error != std::errc() || rest != end || !std::isfinite(x)) return std::nullopt;
    return x;
}

std::optional<std::vector<double>> numbers(const std::string& text)
{
    std::vector<double> all;
    for (const std::string& part : split(text, ',')) {
        const auto x = number(part);
        if (!x) return std::nullopt;
        all.push_back(*x);
    }
    return all;
}

std::string brief(double x)
{
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", x);
    return text;
}

std::string brief(const Vec3d& v)
{
    if (v[0] == v[1] && v[1] == v[2]) return brief(v[0]);
    return brief(v[0]) + "," + brief(v[1]) + "," + brief(v[2]);
}

const CLI::Validator positive = each("a finite number above 0", ">0", [](double x) { return x > 0; });
const CLI::Validator nonnegative = each("a finite number, 0 or above", ">=0", [](double x) { return x >= 0; });
const CLI::Validator finite = each("a finite number", "", [](double) { return true; });

CLI::Validator within(double low, double high)
{
    const std::string a = shortest(low), b = shortest(high);
    return each("a number in [" + a + ", " + b + "]", a + ".." + b, [=](double x) { return x >= low && x <= high; });
}

Option App::add_option(const std::string& names, double& value, const std::string& description)
{
    const auto read = [&value](const CLI::results_t& words) {
        const auto x = number(words.front());
        if (x) value = *x;
        return x.has_value();
    };
    return Option(*this, CLI::App::add_option(names, CLI::callback_t(read), description))
        ->default_str(shortest(value))
        ->type_name("NUMBER")
        ->check(finite);
}

Option App::add_option(const std::string& names, Vec3d& value, const std::string& description)
{
    const auto read = [&value](const CLI::results_t& words) { return read_vector(words.front(), value); };
    return Option(*this, CLI::App::add_option(names, CLI::callback_t(read), description))
        ->default_str(shortest(value))
        ->type_name("X,Y,Z")
        ->check(vector_of(false));
}

Option App::vectors_option(const std::string& names, std::vector<Vec3d>& values, const std::string& description)
{
    const auto read = [&values](const CLI::results_t& words) {
        values.assign(words.size(), Vec3d(0, 0, 0));
        for (size_t k = 0; k < words.size(); ++k)
            if (!read_vector(words[k], values[k])) return false;
        return true;
    };
    std::string present;
    for (const Vec3d& v : values) present += (present.empty() ? "" : " ") + shortest(v);
    CLI::Option* option = CLI::App::add_option(names, CLI::callback_t(read), description);
    option->default_str(present)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    return {*this, option};
}

Option App::add_option(const std::string& names, std::vector<Vec3d>& values, const std::string& description)
{
    return vectors_option(names, values, description)->type_name("X,Y,Z ...")->check(vector_of(false));
}

Option App::add_vec3(const std::string& names, Vec3d& value, const std::string& description)
{
    return add_option(names, value, description);
}

Option App::add_vec3s(const std::string& names, std::vector<Vec3d>& values, const std::string& description)
{
    return add_option(names, values, description);
}

Option App::add_rgb(const std::string& names, Vec3d& value, const std::string& description)
{
    const bool grey = value[0] == value[1] && value[1] == value[2];
    const auto read = [&value](const CLI::results_t& words) { return read_vector(words.front(), value); };
    return Option(*this, CLI::App::add_option(names, CLI::callback_t(read), description))
        ->default_str(grey ? shortest(value[0]) : shortest(value))
        ->type_name("R,G,B")
        ->check(vector_of(true));
}

Option App::add_rgbs(const std::string& names, std::vector<Vec3d>& values, const std::string& description)
{
    return vectors_option(names, values, description)->type_name("R,G,B ...")->check(vector_of(true));
}

Option App::add_flag(const std::string& names, bool& value, const std::string& description)
{
    const bool present = value;  // CLI11 may set it to false on the way
    CLI::Option* option = CLI::App::add_flag(names, value, description);
    value = present;
    return Option(*this, option).default_str(present ? "true" : "");
}

namespace {

std::string lower(std::string text)
{
    for (char& c : text) c = c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c;
    return text;
}

}  // namespace

Option App::word_option(const std::string& names, const std::vector<std::string>& words, const std::string& present,
                        const std::function<void(const std::string&)>& chosen, const std::string& description)
{
    std::string shown;
    for (const std::string& word : words) shown += (shown.empty() ? "" : "|") + word;
    // Upper case is accepted and becomes the word, so that history and report have one spelling.
    const auto check = [=](std::string& text) -> std::string {
        for (const std::string& word : words)
            if (lower(word) == lower(text)) return text = word, std::string();
        return "'" + text + "': expected " + shown;
    };
    const auto read = [=](const CLI::results_t& given) { return chosen(given.front()), true; };
    const Option option(*this, CLI::App::add_option(names, CLI::callback_t(read), description));
    option.cli()->transform(CLI::Validator(check, ""));
    return option->default_str(present)->type_name(shown);
}

std::vector<std::string> default_words(const Setting& setting)
{
    std::string text = setting.option->get_default_str();
    if (setting.kind == Setting::Flag) return {text.empty() ? "false" : text};
    if (text.empty()) return {};
    if (setting.kind == Setting::One) return {text};
    const char between = text.front() == '[' ? ',' : ' ';  // CLI11 shows a container as [a,b]
    if (between == ',') text = text.substr(1, text.size() - 2);
    if (text.empty()) return {};
    return split(text, between);
}

namespace {

/// What looks like a number there is text nevertheless.
bool is_text(const CLI::Option& option)
{
    const std::string type = option.get_type_name();
    for (const char* kind : {"TEXT", "FILE", "FOLDER", "NAME"})
        if (type.rfind(kind, 0) == 0) return true;
    return false;
}

}  // namespace

Setting setting_of(const CLI::Option* option, std::vector<std::string> words)
{
    Setting one{option, option->get_single_name(), std::move(words), Setting::One, false};
    const bool several =
        option->get_items_expected_max() > 1 || option->get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll;
    if (option->get_items_expected_max() == 0)
        one.kind = Setting::Flag;
    else if (several)
        one.kind = Setting::Many;
    one.numeric = one.kind != Setting::Flag && !is_text(*option);
    for (const std::string& word : one.words) one.numeric = one.numeric && numbers(word);
    return one;
}

std::vector<Setting> settings(const CLI::App& app)
{
    std::vector<Setting> all;
    for (const CLI::Option* option : app.get_options()) {
        if (!option->get_configurable()) continue;
        Setting one = setting_of(option, option->count() > 0 ? option->reduced_results() : std::vector<std::string>());
        if (option->count() == 0) one = setting_of(option, default_words(one));
        all.push_back(std::move(one));
    }
    return all;
}

}  // namespace vdbcloud::app
