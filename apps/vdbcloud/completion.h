#pragma once
// Completion of `vdbcloud PROGRAM ...`, made from what each program prints for itself.
#include <string>
#include <vector>

namespace vdbcloud::command {

struct Program {
    std::string name, summary;
    std::string completion;  ///< what `NAME --completion SHELL` prints
};

/// The completion script of `vdbcloud` for a shell: "bash", "zsh" or "fish".
std::string completion(const std::string& shell, const std::vector<Program>& programs);

}  // namespace vdbcloud::command
