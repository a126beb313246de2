#include "hard/judge.h"

#include "hard/invariants.h"
#include "hard/values.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>

namespace vdbcloud::test {

namespace {

bool anything(const World& world) { return world.commands.empty(); }
bool solves(const World& world) { return world.runs("p1solve"); }
bool limited(const World& world) { return world.solve.find("--limiter") != std::string::npos; }
bool linear(const World& world) { return anything(world) && !limited(world); }
/// The directions over a sun's disc are not symmetric.
bool symmetric(const World& world) { return anything(world) && !has_discs(world); }
bool sweeps(const World& world) { return world.solve.find("--iterations") != std::string::npos; }
/// Leaf blocks cut a mirrored body elsewhere. Sweeps interpolate light that crosses emptiness within blocks, and follow
/// it by rays between blocks.
bool in_any_block(const World& world)
{
    if (!anything(world)) return false;
    const std::string& body = world.bodies[0];
    const bool full = body.find("void=") == std::string::npos && split(body)[0] != "line" &&
                      split(body)[0] != "stray" && split(body)[0] != "fractal";
    return full || !sweeps(world);
}
/// The places of a pixel's samples are not symmetric.
bool mirrorable(const World& world)
{
    return symmetric(world) && in_any_block(world) && world.view.find("--samples") == std::string::npos;
}
/// The rays of a sun's lattice pass through voxel 0.
bool shiftable(const World& world)
{
    return anything(world) && !sweeps(world) &&
           std::all_of(world.lights.begin(), world.lights.end(), [](const auto& light) { return light.lamp; });
}
bool many_lights(const World& world)
{
    return linear(world) && !emits(world) && world.lights.size() + !world.sky.empty() > 1 &&
           world.sky.find("day") == std::string::npos && world.solve.find("--ground-albedo") == std::string::npos;
}
bool one_body(const World& world)
{
    return anything(world) && world.bodies.size() == 1 && !emits(world) &&
           world.bodies[0].find("cd=") == std::string::npos;
}
bool bounded(const World& world) { return anything(world) && world.periodic.empty(); }
bool one_sun(const World& world)
{
    return bounded(world) && world.bodies.size() == 1 && world.lights.size() == 1 && !world.lights[0].lamp &&
           world.lights[0].diameter == 0;
}
bool white(const World& world)
{
    return bounded(world) && solves(world) && !emits(world) &&
           world.solve.find("--ground-albedo") == std::string::npos &&
           std::none_of(world.bodies.begin(), world.bodies.end(),
                        [](const auto& b) { return b.find("cd=") != std::string::npos; });
}
bool coloured(const World& world)
{
    return anything(world) && world.medium.find(',') != std::string::npos && !emits(world) && world.sky.empty() &&
           world.bodies[0].find("cd=") == std::string::npos;
}
/// At two mean free paths a voxel P1's picture of a box errs by 30 %, at ten by 300 %, at one by 1 %.
bool resolved(const World& world)
{
    double edge = 0;
    for (const Vec3d& axis : world.axes) edge = std::max(edge, axis.length());
    return edge * largest(colour(option(world.medium, "--extinction", "1"))) <= 1;
}
bool seen_by_paths(const World& world)
{
    return bounded(world) && resolved(world) && solves(world) && world.runs("render") && !world.lights.empty() &&
           world.sky.empty() && world.view.find("--integrator") == std::string::npos &&
           world.view.find("--samples") == std::string::npos &&
           world.solve.find("--ground-albedo") == std::string::npos;
}

}  // namespace

const std::vector<Invariant>& invariants()
{
    static const std::vector<Invariant> all = {
        {"finite", "values that are not finite", 0, "none may be", anything, invariant_of::finite},
        {"bounds",
         "excess of T over [0, 1], of fluence and radiance over what the lights can give, and of collided radiance "
         "over "
         "that of the fluence",
         1e-3, "P1's fluence at a corner may be below 0 by rounding", anything, invariant_of::bounds},
        {"balance", "power in less power out, over power in", 2e-5, "twenty times the solver's tolerance", solves,
         invariant_of::balance},
        {"turned", "difference of the world turned by 120 degrees", 1e-4, "the solver's tolerance times its condition",
         symmetric, invariant_of::turned},
        {"mirrored", "difference of the mirrored world", 1e-4, "as above", mirrorable, invariant_of::mirrored},
        {"relabelled", "difference with other index axes", 1e-4, "as above", in_any_block, invariant_of::relabelled},
        {"shifted", "difference where leaf blocks cut the body elsewhere", 1e-4, "as above", shiftable,
         invariant_of::shifted},
        {"rescaled", "difference of the world 768 times smaller and denser, or larger and thinner", 1e-4, "as above",
         anything, invariant_of::rescaled},
        {"brighter", "difference with all light 300 times stronger", 1e-4, "as above", anything,
         invariant_of::brighter},
        {"threads", "difference with 3 threads", 0, "results do not depend on threads", anything,
         invariant_of::threads},
        {"denser", "growth of a transmittance where the density grows", 1e-5, "rounding of float", bounded,
         invariant_of::denser},
        {"lights", "difference of all lights together and the sum of each alone", 1e-4,
         "as above; in pictures only where no flux is limited, as the limit is not linear", many_lights,
         invariant_of::lights},
        {"grey", "difference of green and a grey world of green's numbers", 1e-4, "as above", coloured,
         invariant_of::grey},
        {"half", "difference of 16-bit moments beyond their rounding", 1e-6, "rounding of float", solves,
         invariant_of::half},
        {"inputs", "difference of one file and two files of half the density", 1e-4, "as above", one_body,
         invariant_of::inputs},
        {"furnace", "difference from radiance 1 under a sky of 1 without absorption", 1e-4, "as above", white,
         invariant_of::furnace},
        {"lines", "difference of a camera ray's transmittance and its value in double", 1e-4, "floats in cells",
         bounded, invariant_of::lines},
        {"beams", "difference of the sun's transmittance and its value in double", 1e-4, "floats in cells", one_sun,
         invariant_of::beams},
        {"path", "difference of the picture's mean and that of light paths beyond four standard errors", 0.3,
         "the error of P1 in a body of some mean free paths, whose voxels are at most one long", seen_by_paths,
         invariant_of::path},
    };
    return all;
}

namespace {

nlohmann::json report_in(const std::string& path)
{
    const std::string text = read_text(path);
    nlohmann::json whole = nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
    if (!whole.is_discarded() && whole.is_object()) return whole;
    whole = nlohmann::json::array();
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) whole.push_back(nlohmann::json::parse(line));
    return whole;
}

double number_in(const std::string& path, const std::string& pointer)
{
    const nlohmann::json value = report_in(path).at(nlohmann::json::json_pointer(pointer));
    return value.is_boolean() ? double(value.get<bool>()) : value.get<double>();
}

}  // namespace

Verdict judged(Chain& chain, const World& world, const Seen& seen, const std::string& held)
{
    const Words words = split(held);
    if (words.at(0) != "number") return invariant(held).judge(chain, world, seen);
    const std::string folder = chain.folder() + "/";
    const double found = number_in(folder + words.at(1), words.at(2));
    const double expected = words.size() > 4 ? number_in(folder + words[3], words[4]) : std::stod(words.at(3));
    Verdict verdict;
    verdict.take(std::abs(found - expected) / (expected == 0 ? 1 : std::abs(expected)),
                 words[2] + " is " + digits(found) + ", expected " + digits(expected));
    return verdict;
}

const Invariant& invariant(const std::string& name)
{
    for (const Invariant& one : invariants())
        if (one.name == name) return one;
    throw std::runtime_error("no invariant is called " + name);
}

}  // namespace vdbcloud::test
