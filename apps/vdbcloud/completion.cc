#include "completion.h"

#include <sstream>

namespace vdbcloud::command {

namespace {

std::string names(const std::vector<Program>& programs, const char* separator)
{
    std::string all;
    for (const Program& program : programs) all += (all.empty() ? "" : separator) + program.name;
    return all;
}

/// Each program's own function _NAME does its part, with the command line as the program sees it.
std::string bash(const std::vector<Program>& programs)
{
    std::string text;
    for (const Program& program : programs) text += program.completion;
    return text +
           "_vdbcloud()\n{\n"
           "    if [[ $COMP_CWORD == 1 ]]; then\n"
           "        COMPREPLY=($(compgen -W \"" +
           names(programs, " ") +
           " --help --version --completion\" -- \"${COMP_WORDS[1]}\"))\n"
           "        return\n"
           "    fi\n"
           "    case ${COMP_WORDS[1]} in\n"
           "        " +
           names(programs, "|") +
           ")\n"
           "            local program=${COMP_WORDS[1]}\n"
           "            COMP_WORDS=(\"${COMP_WORDS[@]:1}\")\n"
           "            COMP_CWORD=$((COMP_CWORD - 1))\n"
           "            \"_$program\";;\n"
           "    esac\n"
           "}\n"
           "complete -o filenames -F _vdbcloud vdbcloud\n";
}

std::string zsh(const std::vector<Program>& programs)
{
    std::string text = "#compdef vdbcloud\n"
                       "if (( CURRENT == 2 )); then\n"
                       "    compadd -- " +
                       names(programs, " ") +
                       " --help --version --completion\n"
                       "    return\n"
                       "fi\n"
                       "local program=$words[2]\n"
                       "shift words\n"
                       "(( CURRENT-- ))\n"
                       "case $program in\n";
    // The first line of each program's script is "#compdef NAME".
    for (const Program& program : programs)
        text += program.name + ")\n" + program.completion.substr(program.completion.find('\n') + 1) + ";;\n";
    return text + "esac\n";
}

std::string fish(const std::vector<Program>& programs)
{
    std::string text;
    for (const Program& program : programs) {
        text +=
            "complete -c vdbcloud -n __fish_use_subcommand -f -a " + program.name + " -d '" + program.summary + "'\n";
        const std::string own = "complete -c " + program.name + " ";
        std::istringstream lines(program.completion);
        for (std::string line; std::getline(lines, line);)
            if (line.rfind(own, 0) == 0)
                text += "complete -c vdbcloud -n '__fish_seen_subcommand_from " + program.name + "' " +
                        line.substr(own.size()) + "\n";
    }
    return text;
}

}  // namespace

std::string completion(const std::string& shell, const std::vector<Program>& programs)
{
    if (shell == "bash") return bash(programs);
    return shell == "zsh" ? zsh(programs) : fish(programs);
}

}  // namespace vdbcloud::command
