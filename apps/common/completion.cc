#include "help.h"

#include "vdbcloud/core/error.h"

#include <algorithm>
#include <vector>

namespace vdbcloud::app {

namespace {

/// What a shell needs to know of an option.
struct Entry {
    std::vector<std::string> longs, shorts;
    std::string description, kind;
    std::string words;  // to choose from, separated by blanks
    bool value = false, file = false;
};

std::vector<Entry> entries(const CLI::App& app)
{
    std::vector<Entry> all;
    for (const CLI::Option* option : app.get_options()) {
        if (option->get_group().empty() || !option->nonpositional()) continue;
        Entry e{option->get_lnames(),
                option->get_snames(),
                option->get_description(),
                option->get_type_name(),
                "",
                false,
                false};
        e.value = option->get_items_expected_max() > 0;
        e.kind = e.kind.substr(0, e.kind.find(':'));
        if (e.kind.find('|') != std::string::npos) {
            e.words = e.kind;
            std::replace(e.words.begin(), e.words.end(), '|', ' ');
        }
        e.file = e.kind == "TEXT" || e.kind == "FILE";
        all.push_back(std::move(e));
    }
    return all;
}

std::string without(std::string text, const std::string& unwanted)
{
    for (char& c : text)
        if (unwanted.find(c) != std::string::npos) c = ' ';
    return text;
}

std::string bash(const std::string& tool, const std::vector<Entry>& all)
{
    std::string names, cases;
    for (const Entry& e : all) {
        std::string pattern;
        for (const std::string& name : e.longs) pattern += (pattern.empty() ? "--" : "|--") + name;
        for (const std::string& name : e.shorts) pattern += (pattern.empty() ? "-" : "|-") + name;
        for (const std::string& name : e.longs) names += " --" + name;
        if (!e.value || e.file) continue;
        cases += "        " + pattern + ") COMPREPLY=($(compgen -W \"" + e.words + "\" -- \"$cur\")); return;;\n";
    }
    return "_" + tool +
           "()\n{\n    local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD-1]}\n"
           "    case $prev in\n" +
           cases +
           "    esac\n"
           "    if [[ $cur == -?* ]]; then COMPREPLY=($(compgen -W \"" +
           names.substr(1) +
           "\" -- \"$cur\"))\n"
           "    else COMPREPLY=($(compgen -f -- \"$cur\")); fi\n}\ncomplete -o filenames -F _" +
           tool + " " + tool + "\n";
}

std::string zsh(const std::string& tool, const std::vector<Entry>& all)
{
    std::string out = "#compdef " + tool + "\n_arguments -S \\\n";
    const auto line = [&](const std::string& name, const Entry& e) {
        out += "    '*" + name + "[" + without(e.description, "[]'\\") + "]";
        if (e.value)
            out +=
                ":" + without(e.kind, ":'|") + ":" + (e.words.empty() ? e.file ? "_files" : " " : "(" + e.words + ")");
        out += "' \\\n";
    };
    for (const Entry& e : all) {
        for (const std::string& name : e.longs) line("--" + name, e);
        for (const std::string& name : e.shorts) line("-" + name, e);
    }
    return out + "    '*:file:_files'\n";
}

std::string fish(const std::string& tool, const std::vector<Entry>& all)
{
    std::string out;
    for (const Entry& e : all) {
        out += "complete -c " + tool;
        for (const std::string& name : e.longs) out += " -l " + name;
        for (const std::string& name : e.shorts) out += " -s " + name;
        if (e.value) out += e.file ? " -r" : " -x";
        if (!e.words.empty()) out += " -a '" + e.words + "'";
        out += " -d '" + without(e.description, "'\\") + "'\n";
    }
    return out;
}

}  // namespace

std::string completion_script(const CLI::App& app, const std::string& shell)
{
    if (shell == "bash") return bash(app.get_name(), entries(app));
    if (shell == "zsh") return zsh(app.get_name(), entries(app));
    if (shell == "fish") return fish(app.get_name(), entries(app));
    throw UsageError("--completion: '" + printable(shell) + "': expected bash, zsh or fish");
}

}  // namespace vdbcloud::app
