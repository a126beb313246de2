#pragma once
// Options whose value is text of some form.
#include <CLI/Option.hpp>

#include <functional>
#include <string>

namespace vdbcloud::app {

/// Takes text of which `holds`; `expected` says how such text looks.
CLI::Validator formed(const std::string& expected, std::function<bool(const std::string&)> holds);

/// True for one number or three, of a size that files take: a colour.
bool is_colour(const std::string& text);

}  // namespace vdbcloud::app
