#include "option_words.h"

#include "sky_options.h"

#include "vdbcloud/core/error.h"

#include <algorithm>
#include <limits>

namespace vdbcloud::app {

namespace {

std::string trimmed(const std::string& text)
{
    const auto first = text.find_first_not_of(" \t"), last = text.find_last_not_of(" \t");
    return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

bool is_key(const std::string& word, const std::string& key)
{
    const auto sign = word.find('=');
    return sign != std::string::npos && trimmed(word.substr(0, sign)) == key;
}

std::string behind_key(const std::string& word) { return trimmed(word.substr(word.find('=') + 1)); }

}  // namespace

OptionWords::OptionWords(const std::string& option, const std::string& text) : option_(option), text_(text)
{
    for (const std::string& part : split(text, ';')) {
        const std::string word = trimmed(part);
        if (!word.empty()) left_.push_back(word);
    }
    if (left_.empty()) refuse("it is empty");
    shape = left_.front();
    left_.erase(left_.begin());
}

bool OptionWords::has(const std::string& word)
{
    const auto at = std::find(left_.begin(), left_.end(), word);
    if (at == left_.end()) return false;
    left_.erase(at);
    return true;
}

std::string OptionWords::value(const std::string& key)
{
    const auto at = std::find_if(left_.begin(), left_.end(), [&](const std::string& w) { return is_key(w, key); });
    if (at == left_.end()) return "";
    const std::string out = behind_key(*at);
    left_.erase(at);
    if (out.empty()) refuse("'" + key + "=' has no value");
    return out;
}

std::string OptionWords::peek(const std::string& key) const
{
    const auto at = std::find_if(left_.begin(), left_.end(), [&](const std::string& w) { return is_key(w, key); });
    return at == left_.end() ? "" : behind_key(*at);
}

Vec3d OptionWords::place(const std::string& key, const std::optional<Vec3d>& otherwise)
{
    const std::string text = value(key);
    if (text.empty() && otherwise) return *otherwise;
    const auto c = numbers(text);
    if (!c || c->size() != 3) refuse("'" + key + "=" + text + "': expected x,y,z");
    return {(*c)[0], (*c)[1], (*c)[2]};
}

double OptionWords::size(const std::string& key, const std::optional<double>& otherwise)
{
    const std::string text = value(key);
    if (text.empty() && otherwise) return *otherwise;
    const auto x = number(text);
    if (!x) refuse("'" + key + "=" + text + "': expected a number");
    return *x;
}

double OptionWords::time(const std::string& key, const std::optional<double>& otherwise)
{
    const std::string text = value(key);
    if (text.empty() && otherwise) return *otherwise;
    if (text == "never") return std::numeric_limits<double>::infinity();
    const size_t end = std::min(text.find_first_not_of("0123456789.eE+-"), text.size());
    const auto x = number(text.substr(0, end));
    const std::string unit = trimmed(text.substr(end));
    const double scale = unit.empty() || unit == "s" ? 1 : unit == "min" ? 60 : unit == "h" ? 3600 : 0;
    if (!x || *x < 0 || scale == 0) refuse("'" + key + "=" + text + "': expected a time, as 10s, 2min, 1h or never");
    return *x * scale;
}

Vec3d OptionWords::colour(const std::string& key, const Vec3d& otherwise)
{
    const std::string text = value(key);
    return text.empty() ? otherwise : colour_asked(context() + key, text, "one number or r,g,b");
}

void OptionWords::finish(const std::vector<std::string>& known) const
{
    if (left_.empty()) return;
    std::string list;
    for (const std::string& word : known) list += (list.empty() ? "" : ", ") + word;
    refuse("'" + left_.front() + "': expected each of " + list + " once at most");
}

void OptionWords::refuse(const std::string& why) const { throw UsageError(context() + why); }

std::string OptionWords::context() const { return option_ + " '" + printable(text_) + "': "; }

}  // namespace vdbcloud::app
