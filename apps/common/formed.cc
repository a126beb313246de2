#include "formed.h"

#include "options.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/number_range.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace vdbcloud::app {

CLI::Validator formed(const std::string& expected, std::function<bool(const std::string&)> holds)
{
    const auto check = [expected, holds = std::move(holds)](const std::string& text) {
        return holds(text) ? std::string() : "'" + printable(text) + "': expected " + expected;
    };
    return CLI::Validator(check, "");
}

bool is_colour(const std::string& text)
{
    const auto c = numbers(text);
    const auto fits = [](double x) { return std::abs(x) <= largest_number; };
    return c && (c->size() == 1 || c->size() == 3) && std::all_of(c->begin(), c->end(), fits);
}

}  // namespace vdbcloud::app
