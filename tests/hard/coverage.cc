#include "hard/coverage.h"

#include "hard/chain.h"

#include <fstream>
#include <regex>
#include <stdexcept>

namespace vdbcloud::test {

namespace {

bool is_long(const std::string& word) { return word.size() > 2 && word[0] == '-' && word[1] == '-'; }

void take(const Words& words, std::set<std::string>& to)
{
    for (const std::string& word : words)
        if (is_long(word) || word == "-o") to.insert(word == "-o" ? "--output" : word);
}

bool has(const OptionSet& set, const std::string& name, const std::string& option)
{
    const auto found = set.find(name);
    return found != set.end() && found->second.count(option) > 0;
}

}  // namespace

OptionSet options_of_help(const std::vector<std::string>& programs)
{
    OptionSet all;
    static const std::regex option("(?:^|[ ,])(--[a-z][a-z0-9-]*)");
    for (const std::string& name : programs) {
        const std::string help = run({program(name), "--help-all"}).out;
        std::istringstream in(help);
        // An option's own line begins with it; elsewhere help speaks of other options.
        for (std::string line; std::getline(in, line);) {
            const size_t begin = line.find_first_not_of(' ');
            if (begin != 2 || line[2] != '-') continue;
            const std::string head = line.substr(0, line.find("  ", 3));
            for (std::sregex_iterator at(head.begin(), head.end(), option), end; at != end; ++at)
                all[name].insert((*at)[1]);
        }
    }
    return all;
}

OptionSet options_of_worlds(const std::vector<World>& worlds)
{
    OptionSet all;
    for (const World& world : worlds) {
        for (const std::string& body : world.bodies)
            if (body.rfind("fractal ", 0) == 0) {
                take(split(body), all["fractalgen"]);
                all["fractalgen"].insert("--output");
            }
        for (const std::string& line : world.commands) {
            const Words words = split(line);
            take(words, all[words.at(0)]);
        }
        if (!world.commands.empty()) continue;
        bool first = true;
        for (const std::string& stage : split(world.stages)) {
            std::set<std::string>& to = all[stage];
            take({"--output", "--threads", "--trust-input", "--quiet"}, to);
            if (stage != "render") to.insert("--compression");
            if (first) {
                take(Chain::lights(world, {}), to);
                take(split(world.medium), to);
                to.insert("--up");
                if (!world.periodic.empty()) to.insert("--periodic");
            }
            first = false;
            if (stage == "illuminate") take(split(world.light), to);
            if (stage == "p1solve") {
                take(split(world.sky), to);
                take(split(world.solve), to);
                to.insert("--json");
            }
            if (stage == "render") {
                take(split(world.view), to);
                take({"--camera", "--look-at", "--aov", "--background", "--resolution"}, to);
                if (world.view.find("framed") != std::string::npos) to.insert("--direction");
                if (world.view.find("orthographic") != std::string::npos) to.insert("--ortho-width");
            }
        }
        // Invariants add options of their own.
        for (const auto& [name, limit] : world.holds) {
            if (name == "half") all["p1solve"].insert("--half");
            if (name == "path") take({"--integrator", "--samples"}, all["render"]);
            if (name == "lines") take({"--projection", "--ortho-width"}, all["render"]);
        }
    }
    return all;
}

OptionSet options_without_rows(const std::string& path, const OptionSet& help, const OptionSet& used)
{
    std::ifstream in(path);
    if (!in) throw std::runtime_error(path + ": cannot be read");
    OptionSet all;
    for (std::string line; std::getline(in, line);) {
        if (line.empty() || line[0] == '#') continue;
        const size_t colon = line.find(": ");
        if (colon == std::string::npos)
            throw std::runtime_error(path + ": expected PROGRAM OPTIONS: reason, got " + line);
        const Words words = split(line.substr(0, colon));
        if (words.at(0) != "*") {
            take(words, all[words[0]]);
            continue;
        }
        for (const auto& [name, options] : help)
            for (const std::string& option : words)
                if (options.count(option) && !has(used, name, option)) all[name].insert(option);
    }
    return all;
}

std::vector<std::string> missing_rows(const OptionSet& help, const OptionSet& used, const OptionSet& excused)
{
    std::vector<std::string> all;
    for (const auto& [name, options] : help)
        for (const std::string& option : options)
            if (!has(used, name, option) && !has(excused, name, option))
                all.push_back(name + " " + option + " has no row");
    for (const auto& [name, options] : excused)
        for (const std::string& option : options)
            if (has(used, name, option))
                all.push_back(name + " " + option + " has rows, and a line that says it has none");
    for (const auto& set : {used, excused})
        for (const auto& [name, options] : set)
            for (const std::string& option : options)
                if (!has(help, name, option)) all.push_back(name + " has no option " + option);
    return all;
}

}  // namespace vdbcloud::test
