#pragma once
// Every option of every program: a command in which the option has an effect, and one in which it can have none.
#include <string>
#include <vector>

namespace vdbcloud::test {

/// Where the effect is seen.
enum class Seen {
    Values,    ///< of the grids or of the picture
    Metadata,  ///< of the grids
    Png,       ///< in out.png
    Report,    ///< "accuracy" or "channels" of --json
    Files,     ///< that are written
    Status,    ///< of the exit
    Elsewhere  ///< by the test that `with` names
};

struct EffectRow {
    std::string option;  ///< with its value: "--step 0.5"
    Seen seen;
    std::string with;     ///< what else the command needs for the effect; inputs (*.vdb) replace those of the base
    std::string without;  ///< values that leave the option without effect: status 2
    bool always = false;  ///< no values leave the option without effect; `without` is not run
};

struct ToolEffects {
    std::string tool, base;  ///< the base takes part unless a row gives the same option
    std::vector<EffectRow> rows;
};

/// Words in these are separated by blanks. Files that they read: see OptionEffects::prepare.
const std::vector<ToolEffects>& tool_effects();

/// Options that all programs share, and the test that holds each.
const std::vector<std::pair<std::string, std::string>>& shared_options();

}  // namespace vdbcloud::test
