#pragma once
// The known name that is nearest to a mistyped name.
#include <string>
#include <vector>

namespace vdbcloud::app {

/// The first of `known` with the fewest insertions, deletions, exchanges of a letter and swaps of two neighbours from
/// `name`; empty if all need more than a third of the letters of `name`, or more than two.
std::string nearest(const std::string& name, const std::vector<std::string>& known);

}  // namespace vdbcloud::app
