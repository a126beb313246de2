#pragma once
// Which programs and options the suite uses.
#include "hard/world.h"

#include <map>
#include <set>
#include <string>
#include <vector>

namespace vdbcloud::test {

using OptionSet = std::map<std::string, std::set<std::string>>;  ///< program: its options

/// All options of --help-all. `programs`: names.
OptionSet options_of_help(const std::vector<std::string>& programs);

/// Options that these worlds give to programs, those of their bodies among them.
OptionSet options_of_worlds(const std::vector<World>&);

/// Lines "PROGRAM --option --option: reason" of a file; PROGRAM * stands for each program that has the option and does
/// not use it.
OptionSet options_without_rows(const std::string& path, const OptionSet& help, const OptionSet& used);

/// Sentences: options that no world uses and no line excuses, and lines that excuse what worlds use or no program has.
std::vector<std::string> missing_rows(const OptionSet& help, const OptionSet& used, const OptionSet& excused);

}  // namespace vdbcloud::test
