#include "hard/world.h"

#include "hard/programs.h"
#include "vdbcloud/core/shortest.h"
#include "vdbcloud/core/vdb.h"

#include <algorithm>
#include <fstream>
#include <stdexcept>

namespace vdbcloud::test {

std::string digits(double value) { return shortest(value); }
std::string digits(const Vec3d& v) { return shortest(v); }

namespace {

Vec3d vector_of(const std::string& text)
{
    Vec3d v;
    size_t at = 0;
    for (int c = 0; c < 3; ++c) {
        size_t used = 0;
        v[c] = std::stod(text.substr(at), &used);
        at += used + 1;
    }
    return v;
}

WorldLight light_of(const Words& words)
{
    WorldLight light;
    light.lamp = words.at(0) == "lamp";
    if (!light.lamp && words[0] != "sun") throw std::runtime_error("expected sun or lamp");
    light.at = vector_of(words.at(1));
    for (size_t k = 2; k + 1 < words.size(); k += 2) {
        if (words[k] == "power")
            light.power = vector_of(words[k + 1]);
        else if (words[k] == "diameter")
            light.diameter = std::stod(words[k + 1]);
        else
            throw std::runtime_error("expected power or diameter");
    }
    return light;
}

std::string text_of(const WorldLight& light)
{
    return std::string(light.lamp ? "lamp " : "sun ") + digits(light.at) + " power " + digits(light.power) +
           (light.diameter > 0 ? " diameter " + digits(light.diameter) : "");
}

/// The keys that hold options or one word.
std::vector<std::pair<std::string, std::string World::*>> plain_keys()
{
    return {{"name", &World::name},    {"why", &World::why},           {"medium", &World::medium},
            {"sky", &World::sky},      {"light", &World::light},       {"solve", &World::solve},
            {"view", &World::view},    {"periodic", &World::periodic}, {"up", &World::up},
            {"stages", &World::stages}};
}

void set_key(World& world, const std::string& key, const std::string& value)
{
    for (const auto& [name, member] : plain_keys())
        if (name == key) {
            world.*member = value;
            return;
        }
    const Words words = split(value);
    if (key == "body") {
        world.bodies.push_back(value);
    } else if (key == "axes") {
        for (size_t c = 0; c < 3; ++c) world.axes[c] = vector_of(words.at(c));
    } else if (key == "origin") {
        world.origin = vector_of(value);
    } else if (key == "look") {
        world.look = vector_of(value);
    } else if (key == "sun" || key == "lamp") {
        world.lights.push_back(light_of(split(key + " " + value)));
    } else if (key == "run") {
        world.commands.push_back(value);
    } else if (key == "refused") {
        world.refused = std::stoi(words.at(0));
        world.sentence = value.substr(value.find(words.at(1)));
    } else if (key == "holds") {
        world.holds.push_back({value.substr(0, value.rfind(' ')), std::stod(words.back())});
    } else if (key == "known") {
        const size_t colon = value.find(": ");
        if (colon == std::string::npos) throw std::runtime_error("expected known: invariant: reason");
        world.known[value.substr(0, colon)] = value.substr(colon + 2);
    } else {
        throw std::runtime_error("unknown key " + key);
    }
}

}  // namespace

bool World::runs(const std::string& stage) const
{
    const Words all = split(stages);
    return std::find(all.begin(), all.end(), stage) != all.end();
}

std::string World::text() const
{
    std::string all;
    const auto line = [&](const std::string& key, const std::string& value) { all += key + ": " + value + "\n"; };
    line("name", name);
    if (!why.empty()) line("why", why);
    for (const std::string& body : bodies) line("body", body);
    line("axes", digits(axes[0]) + " " + digits(axes[1]) + " " + digits(axes[2]));
    line("origin", digits(origin));
    for (const WorldLight& one : lights) {
        const std::string value = text_of(one);
        line(value.substr(0, value.find(' ')), value.substr(value.find(' ') + 1));
    }
    for (const auto& [key, member] : plain_keys())
        if (key != "name" && key != "why" && !(this->*member).empty()) line(key, this->*member);
    line("look", digits(look));
    for (const std::string& command : commands) line("run", command);
    if (refused != 0) line("refused", std::to_string(refused) + " " + sentence);
    for (const auto& [invariant, limit] : holds) line("holds", invariant + " " + digits(limit));
    return all;
}

std::vector<World> read_worlds(const std::string& path)
{
    std::ifstream in(path);
    if (!in) throw std::runtime_error(path + ": cannot be read");
    std::vector<World> worlds;
    bool open = false;
    int number = 0;
    for (std::string line; std::getline(in, line);) {
        ++number;
        if (!line.empty() && line[0] == '#') continue;
        if (line.find_first_not_of(' ') == std::string::npos) {
            open = false;
            continue;
        }
        if (!open) worlds.emplace_back();
        open = true;
        try {
            const size_t colon = line.find(':');
            if (colon == std::string::npos) throw std::runtime_error("expected key: value");
            const size_t begin = line.find_first_not_of(' ', colon + 1);
            set_key(worlds.back(), line.substr(0, colon), begin == std::string::npos ? "" : line.substr(begin));
        } catch (const std::exception& e) {
            throw std::runtime_error(path + ":" + std::to_string(number) + ": " + e.what());
        }
    }
    return worlds;
}

std::vector<World> simpler_worlds(const World& world)
{
    std::vector<World> all;
    const auto with = [&](auto change) {
        World simpler = world;
        change(simpler);
        if (simpler.text() != world.text()) all.push_back(simpler);
    };
    for (size_t k = 0; k < world.lights.size(); ++k)
        // illuminate without a light would bring its own, which does not change with the world.
        if (world.lights.size() > 1 || (!world.sky.empty() && !world.runs("illuminate")))
            with([&](World& w) { w.lights.erase(w.lights.begin() + std::ptrdiff_t(k)); });
    if (!world.lights.empty()) with([](World& w) { w.sky.clear(); });
    if (world.bodies.size() > 1) with([](World& w) { w.bodies.pop_back(); });
    for (const char* stage : {"illuminate ", " render"})
        with([&](World& w) {
            const size_t at = w.stages.find(stage);
            if (at != std::string::npos) w.stages.erase(at, std::string(stage).size());
        });
    // The tolerance stays: with a looser one the world would fail for another reason.
    const Words solve = split(world.solve);
    const auto tolerance = std::find(solve.begin(), solve.end(), "--tolerance");
    with([&](World& w) { w.solve = solve.end() - tolerance > 1 ? "--tolerance " + tolerance[1] : ""; });
    with([](World& w) { w.light.clear(); });
    with([](World& w) { w.view = "--resolution 3"; });
    with([](World& w) { w.periodic.clear(); });
    with([](World& w) {
        for (WorldLight& light : w.lights) light.power = Vec3d(1), light.diameter = 0;
    });
    // Of colours the red, of phase functions the isotropic one.
    const Words medium = split(world.medium);
    for (size_t k = 0; k + 1 < medium.size(); ++k) {
        if (medium[k].rfind("--", 0) != 0) continue;
        if (const size_t comma = medium[k + 1].find(','); comma != std::string::npos)
            with([&](World& w) {
                w.medium.replace(w.medium.find(medium[k + 1]), medium[k + 1].size(), medium[k + 1].substr(0, comma));
            });
        else if (medium[k] == "--g" && medium[k + 1] != "0")
            with([&](World& w) {
                w.medium.replace(w.medium.find("--g " + medium[k + 1]), 4 + medium[k + 1].size(), "--g 0");
            });
        else if (medium[k] == "--phase" && medium[k + 1] != "isotropic")
            with([&](World& w) { w.medium = w.medium.substr(0, w.medium.find("--phase")) + "--phase isotropic"; });
    }
    with([](World& w) { w.origin = Vec3d(0); });
    with([](World& w) { w.axes = World().axes; });
    return all;
}

}  // namespace vdbcloud::test
