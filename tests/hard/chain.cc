#include "hard/chain.h"

#include "vdbcloud/core/vdb.h"

#include <algorithm>
#include <filesystem>

namespace vdbcloud::test {

namespace {

void append(Words& words, const Words& more) { words.insert(words.end(), more.begin(), more.end()); }

Words shared(int threads) { return {"--threads", std::to_string(threads), "--trust-input", "--quiet"}; }
const Words writer{"--compression", "none"};

/// "1,2,3" times a factor, or "0.5".
std::string times(const std::string& numbers, double factor)
{
    std::string all;
    for (size_t at = 0; at < numbers.size();) {
        size_t used = 0;
        const double value = std::stod(numbers.substr(at), &used);
        all += (all.empty() ? "" : ",") + digits(factor * value);
        at += used + 1;
    }
    return all;
}

/// The options of a sky with its radiances times a factor.
Words sky_words(const std::string& sky, double factor)
{
    Words words = split(sky);
    for (size_t k = 0; k + 1 < words.size(); ++k) {
        const bool radiance = words[k] == "--sky" || words[k] == "--sky-zenith" || words[k] == "--sky-horizon" ||
                              words[k] == "--sky-ground";
        if (radiance && words[k + 1] != "day") words[k + 1] = times(words[k + 1], factor);
    }
    return words;
}

/// Letters of the index axes of the world as those of a twin.
std::string periodic_axes(const std::string& axes, const Change& change)
{
    std::string all;
    for (int c = 0; c < 3; ++c)
        if (axes.find(char('x' + change.axis[size_t(c)])) != std::string::npos) all += char('x' + c);
    return all;
}

/// A z-up twin of a y-up world, and so on.
std::string up_axis(const World& world, const Change& change)
{
    const Vec3d up = change.point(world.up == "z" ? Vec3d(0, 0, 1) : Vec3d(0, 1, 0));
    return std::abs(up[2]) > std::abs(up[1]) ? "z" : "y";
}

}  // namespace

Words Chain::lights(const World& world, const Change& change)
{
    Words words;
    for (const WorldLight& light : world.lights) {
        const Vec3d power = (light.lamp ? change.size * change.size : 1) * change.power * light.power;
        append(words, {light.lamp ? "--lamp" : "--sun", digits(change.point(light.at)),
                       light.lamp ? "--lamp-intensity" : "--sun-irradiance", digits(power)});
    }
    const bool discs =
        std::any_of(world.lights.begin(), world.lights.end(), [](const auto& l) { return l.diameter > 0; });
    for (const WorldLight& light : world.lights)
        if (discs && !light.lamp) append(words, {"--sun-diameter", digits(light.diameter)});
    return words;
}

Words Chain::write_inputs(const World& world, const Change& change)
{
    Words inputs;
    box_ = {};
    for (size_t k = 0; k < world.bodies.size(); ++k) {
        inputs.push_back((k == 0 ? "in-" : "also-") + std::to_string(k));  // not the frames of a sequence
        if (const auto table = table_of_body(world.bodies[k])) {
            inputs.back() += ".txt";
            write_text(folder_ + "/" + inputs.back(), *table);
            continue;
        }
        inputs.back() += ".vdb";
        const GridFile file = make_body(programs_, world.bodies[k], world.axes, world.origin, change, folder_);
        write_own(folder_ + "/" + inputs.back(), file);
        const auto bounds = density_of_body(file)->evalActiveVoxelBoundingBox();
        for (int corner = 0; corner < 8 && !bounds.empty(); ++corner) {
            Vec3d at;
            for (int c = 0; c < 3; ++c) at[c] = corner >> c & 1 ? bounds.max()[c] : bounds.min()[c];
            box_.push_back(density_of_body(file)->transform().indexToWorld(at));
        }
    }
    return inputs;
}

/// A camera outside the bodies, or the automatic one, whose frame depends on the leaf blocks of the grid.
Words Chain::camera(const World& world, const Change& change) const
{
    const Vec3d look = change.point(world.look);
    if (world.view.find("framed") != std::string::npos || box_.empty()) return {"--direction", digits(look)};
    Vec3d middle(0);
    for (const Vec3d& corner : box_) middle += corner / double(box_.size());
    double radius = 0;
    for (const Vec3d& corner : box_) radius = std::max(radius, (corner - middle).length());
    radius += change.size * (world.axes[0] + world.axes[1] + world.axes[2]).length();
    Words words{"--camera", digits(middle - 3 * radius * look.unit()), "--look-at", digits(middle)};
    if (world.view.find("orthographic") != std::string::npos) append(words, {"--ortho-width", digits(1.4 * radius)});
    return words;
}

/// Runs one program; false with `seen.failure` if the status is not 0.
bool Chain::step(Seen& seen, const std::string& name, const Words& arguments)
{
    for (const std::string& word : arguments)
        if (word.size() > 2 && word[0] == '-' && !std::isdigit(static_cast<unsigned char>(word[1])))
            ++reached_[name + " " + word];
    const Answer answer = programs_.run(name, arguments, folder_);
    seen.seconds = std::max(seen.seconds, answer.seconds);
    seen.bytes = std::max(seen.bytes, answer.bytes);
    seen.status = answer.status;
    if (answer.status == 0) return true;
    seen.over_limit = answer.status > 128;
    seen.failure = name + " ended with status " + std::to_string(answer.status) + ": " + read_text(folder_ + "/stderr");
    while (!seen.failure.empty() && seen.failure.back() == '\n') seen.failure.pop_back();
    return false;
}

Seen Chain::run(const World& world, const Change& change)
{
    Seen seen;
    std::filesystem::remove(folder_ + "/lit.vdb");
    Words inputs = inputs_ = write_inputs(world, change);
    const std::string axes = periodic_axes(world.periodic, change);
    // The first stage gets lights and medium; the file carries both to later stages.
    Words first = lights(world, change);
    append(first, split(world.medium));
    append(first, {"--up", up_axis(world, change)});
    if (!axes.empty()) append(first, {"--periodic", axes});
    const auto stage = [&](const std::string& name, const std::string& output, const Words& options) {
        Words words = inputs;
        append(words, {"-o", output});
        append(words, first);
        append(words, options);
        append(words, shared(threads_));
        if (name != "render") append(words, writer);
        first.clear();
        inputs = {output};
        seen.last = name == split(world.stages).back();
        return step(seen, name, words);
    };
    if (world.runs("illuminate") && !stage("illuminate", "lit.vdb", split(world.light))) return seen;
    if (world.runs("p1solve")) {
        Words options = sky_words(world.sky, change.power);
        append(options, split(world.solve));
        append(options, {"--json", "solved.json"});
        // Of two worlds whose share of multiple scattering is near the limit one might be solved and the other not.
        if (world.solve.find("--effects") == std::string::npos) append(options, {"--accuracy-error", "0"});
        if (!stage("p1solve", "lit.vdb", options)) return seen;
        seen.channels = nlohmann::json::parse(read_text(folder_ + "/solved.json")).value("channels", nlohmann::json());
    }
    if (world.runs("illuminate") || world.runs("p1solve"))
        for (const GridBasePtr& grid : read_own(folder_ + "/lit.vdb").grids) seen.grids[grid->getName()] = grid;
    if (world.runs("render")) {
        Words options = camera(world, change);
        append(options, {"--aov", "all"});
        if (world.view.find("--resolution") == std::string::npos) append(options, {"--resolution", "3"});
        if (world.view.find("--background") == std::string::npos) append(options, {"--background", "none"});
        for (const std::string& word : split(world.view))
            if (word != "framed") options.push_back(word);
        if (!stage("render", "picture.exr", options)) return seen;
        seen.picture = test::picture(folder_ + "/picture.exr");
    }
    return seen;
}

Seen Chain::run_render(const World& world, const Words& options)
{
    Seen seen;
    Words words = inputs_;
    append(words, {"-o", "other.exr"});
    append(words, lights(world, {}));
    append(words, split(world.medium));
    append(words, {"--up", world.up});
    if (!world.periodic.empty()) append(words, {"--periodic", world.periodic});
    append(words, options);
    append(words, shared(threads_));
    if (step(seen, "render", words)) seen.picture = test::picture(folder_ + "/other.exr");
    return seen;
}

Seen Chain::run_commands(const World& world)
{
    Seen seen;
    if (!world.bodies.empty()) write_inputs(world, {});
    for (const std::string& line : world.commands) {
        Words words = split(line);
        const std::string name = words.at(0);
        words.erase(words.begin());
        seen.last = &line == &world.commands.back();
        if (!step(seen, name, words)) return seen;
        const auto output = std::find(words.begin(), words.end(), "-o");
        if (output == words.end() || output + 1 == words.end()) continue;
        const std::string path = folder_ + "/" + output[1];
        if (output[1].find('%') != std::string::npos) continue;  // frames
        if (output[1].find(".vdb") != std::string::npos)
            for (const GridBasePtr& grid : read_own(path).grids) seen.grids[grid->getName()] = grid;
        else
            seen.picture = test::picture(path);
    }
    return seen;
}

}  // namespace vdbcloud::test
