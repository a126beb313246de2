// The generator of random worlds. Each choice is one that the programs allow: a world that a program refuses is a
// failure of the suite.
#include "hard/draw.h"
#include "hard/judge.h"

#include "vdbcloud/core/vdb.h"

#include <algorithm>

namespace vdbcloud::test {

namespace {

Vec3d direction(Draw& draw)
{
    const int kind = draw.whole(0, 5);
    const auto sign = [&] { return draw.chance(0.5) ? 1.0 : -1.0; };
    // Along rows, along diagonals, grazing, else anywhere.
    if (kind == 0) {
        Vec3d v(0);
        v[draw.whole(0, 2)] = sign();
        return v;
    }
    if (kind == 1) return {sign(), sign(), sign()};
    if (kind == 2) return {sign(), 1e-3 * sign(), draw.uniform(-1, 1)};
    for (;;) {
        const Vec3d v(draw.uniform(-1, 1), draw.uniform(-1, 1), draw.uniform(-1, 1));
        if (v.length() > 0.1 && v.length() < 1) return v;
    }
}

std::string number(double value)
{
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", value);
    return text;
}

std::string colour(Draw& draw, double low, double high)
{
    return number(draw.uniform(low, high)) + "," + number(draw.uniform(low, high)) + "," +
           number(draw.uniform(low, high));
}

std::string body(Draw& draw, bool periodic)
{
    const auto side = [&] { return std::to_string(periodic ? 8 : draw.whole(3, 8)); };
    const std::string n = " n=" + side() + "," + side() + "," + side();
    std::string text;
    const int kind = periodic ? draw.whole(0, 3) : draw.whole(0, 10);
    if (kind <= 2)
        text = "noise" + n + " seed=" + std::to_string(draw.whole(1, 1000)) +
               " low=" + number(draw.logarithmic(1e-4, 0.5)) + " high=1" +
               (periodic ? "" : " void=" + number(draw.uniform(0, 0.7)));
    else if (kind <= 4)
        text = "box" + n;
    else if (kind <= 6)
        text = "ball n=" + std::to_string(draw.whole(3, 9));
    else if (kind == 7)
        text = draw.one_of({"layers", "rows", "checker"}) + n + " high=1 low=" + number(draw.logarithmic(1e-8, 0.1));
    else if (kind == 8)
        text = "stray n=3,4,3 distance=" + std::to_string(draw.whole(5, 40));
    else if (kind == 9)
        text = "line n=" + std::to_string(draw.whole(2, 8));
    else
        text = "fractal --size 8 --seed " + std::to_string(draw.whole(1, 99)) + " --envelope " +
               draw.one_of({"sphere", "ellipsoid", "slab", "box", "cumulus"}) + " --beta " +
               number(draw.uniform(2, 5)) + " --coverage " + number(draw.uniform(0.3, 0.9));
    if (draw.chance(0.08)) text += " emission=" + number(draw.logarithmic(0.01, 10));
    if (draw.chance(0.08)) text += " cd=" + std::to_string(draw.whole(1, 99));
    return text;
}

void choose_axes(Draw& draw, World& world)
{
    const int kind = draw.whole(0, 9);
    const double size = draw.chance(0.2) ? draw.logarithmic(1e-3, 1e3) : 1;
    if (kind >= 3)
        for (Vec3d& axis : world.axes) axis *= kind == 9 ? draw.logarithmic(0.05, 20) : draw.logarithmic(0.4, 2.5);
    if (kind == 6 || kind == 7) {  // turned about y
        const double angle = draw.uniform(0, 6.28);
        for (Vec3d& axis : world.axes)
            axis = Vec3d(std::cos(angle) * axis[0] - std::sin(angle) * axis[2], axis[1],
                         std::sin(angle) * axis[0] + std::cos(angle) * axis[2]);
    }
    if (kind == 8 && !world.runs("p1solve")) world.axes[0] += draw.uniform(-0.5, 0.5) * world.axes[2];  // sheared
    for (Vec3d& axis : world.axes) axis *= size;
    if (draw.chance(0.3))
        for (int c = 0; c < 3; ++c) world.origin[c] = std::round(size * draw.uniform(-30, 30));
}

void choose_medium(Draw& draw, World& world)
{
    double edge = 0;
    for (const Vec3d& axis : world.axes) edge += axis.length() / 3;
    const double extinction = draw.logarithmic(1e-3, 30) / edge;
    std::string& m = world.medium;
    m = "--extinction " + (draw.chance(0.3) ? colour(draw, 0.5 * extinction, 2 * extinction) : number(extinction));
    m += " --albedo " + (draw.chance(0.25)
                             ? colour(draw, 0.3, 1)
                             : draw.one_of<std::string>({"0", "0.5", "0.9", "0.999", "0.9999999", "1", "1"}));
    const int phase = draw.whole(0, 7);
    if (phase <= 3) m += " --g " + draw.one_of<std::string>({"-0.5", "0.3", "0.85", "0.98"});
    if (phase == 4) m += " --phase isotropic";
    if (phase == 5) m += " --phase rayleigh";
    if (phase == 6)
        m += " --phase double-henyey-greenstein --g1 0.8 --g2 -0.4 --g1-weight " + number(draw.uniform(0.1, 0.9));
    if (phase == 7) m += " --phase hg-draine --droplet-diameter " + number(draw.uniform(5, 50));
}

/// The middle of the body and its radius [world].
std::pair<Vec3d, double> extent(const World& world)
{
    const Vec3d middle = world.origin + 3.0 * (world.axes[0] + world.axes[1] + world.axes[2]);
    return {middle, 3 * (world.axes[0].length() + world.axes[1].length() + world.axes[2].length())};
}

void choose_lights(Draw& draw, World& world)
{
    const int count = draw.whole(1, 3);
    const auto [middle, radius] = extent(world);
    bool discs = false;
    for (int k = 0; k < count; ++k) {
        WorldLight light;
        light.lamp = world.periodic.empty() && draw.chance(0.2);
        light.at = direction(draw);
        if (!world.periodic.empty()) light.at[1] = (light.at[1] < 0 ? -1 : 1) * (1 + std::abs(light.at[1]));
        if (light.lamp) light.at = middle + radius * draw.uniform(0.5, 2) * light.at.unit();
        light.power = Vec3d(draw.logarithmic(0.1, 10));
        if (draw.chance(0.3)) light.power *= Vec3d(1, draw.uniform(0.5, 1), draw.uniform(0.2, 1));
        if (light.lamp) light.power *= radius * radius;
        if (!light.lamp && draw.chance(0.1)) light.diameter = draw.uniform(0.5, 20), discs = true;
        for (int c = 0; c < 3; ++c) light.at[c] = std::stod(number(light.at[c]));
        for (int c = 0; c < 3; ++c) light.power[c] = std::stod(number(light.power[c]));
        world.lights.push_back(light);
    }
    if (discs) world.light = world.solve = " --disc-samples 4";
}

void choose_options(Draw& draw, World& world)
{
    const bool suns = world.periodic.empty() && std::any_of(world.lights.begin(), world.lights.end(),
                                                            [](const auto& light) { return !light.lamp; });
    if (world.runs("illuminate") && suns) {
        world.light += draw.one_of({"", " --fidelity exact", " --rays-per-voxel 4", " --refine 2"});
        if (world.light.find("exact") == std::string::npos && draw.chance(0.5)) world.light += " --error-samples 0";
    }
    if (world.runs("p1solve")) {
        world.solve += " --tolerance 1e-8";
        const int kind = draw.whole(0, 24);
        const bool peak =
            world.medium.find("--g 0") != std::string::npos || world.medium.find("hg-draine") != std::string::npos;
        if (kind == 0 && peak) world.solve += " --delta off";
        if (kind == 1 && world.periodic.empty() && world.medium.find(',') == std::string::npos &&
            world.lights.size() == 1)
            world.solve += " --limiter levermore-pomraning --allow-unconverged";
        const bool grey = std::all_of(world.lights.begin(), world.lights.end(),
                                      [](const auto& light) { return light.power == Vec3d(light.power[0]); });
        if (kind == 2 && grey && world.bodies[0].find("cd=") == std::string::npos &&
            world.medium.find("--albedo 0.999 ") != std::string::npos && world.medium.find(',') == std::string::npos)
            world.solve += " --series 2";
        if (kind == 3)
            world.solve += " --iterations 2 --change 1e-12 --directions 8 --degree " + std::to_string(draw.whole(1, 3));
        if (kind == 4) world.solve += " --iterations 2 --change 1e-12 --quadrature level-symmetric --directions 8";
        if (kind == 5 && world.medium.find("--albedo 0.") != std::string::npos) world.solve += " --heating";
        if (!world.runs("illuminate") && suns) world.solve += draw.one_of({"", "", " --rays-per-voxel 3"});
        if (kind != 3 && kind != 4) world.solve += draw.chance(0.8) ? " --reentry-rays 0" : " --reentry-rays 200";
        if (draw.chance(0.2)) world.sky = "--sky " + number(draw.logarithmic(0.01, 1));
        const bool coloured = draw.chance(0.06);
        if (coloured && world.sky.empty() && world.solve.find("--series") == std::string::npos)  // of one colour
            world.sky = "--sky-zenith 0.1,0.2,0.4 --sky-horizon 0.5 --sky-ground 0.1 --sky-haze 3";
    }
    if (world.runs("render")) {
        world.look = direction(draw);
        if (std::abs(world.look[0]) + std::abs(world.look[2]) < 1e-6) world.look[2] = 0.3;  // not along the up axis
        for (int c = 0; c < 3; ++c) world.look[c] = std::stod(number(world.look[c]));
        world.view = "--resolution " + std::to_string(draw.whole(2, 5));
        world.view += draw.one_of({"", "", " --projection orthographic", " --fov 60"});
        world.view += draw.one_of({"", "", "", " --integrator romberg --tolerance 1e-5",
                                   " --integrator steps --step 0.2", " --parts 2", " --samples 2"});
    }
}

void choose_invariants(Draw& draw, World& world)
{
    const auto hold = [&](const Invariant& one) {
        if (one.applies(world)) world.holds.push_back({one.name, one.limit});
    };
    for (const char* always : {"finite", "bounds", "balance"}) hold(invariant(always));
    // One that needs more runs.
    std::vector<const Invariant*> others;
    for (const Invariant& one : invariants())
        if (one.name != "finite" && one.name != "bounds" && one.name != "balance" && one.applies(world))
            others.push_back(&one);
    hold(*others[size_t(draw.whole(0, int(others.size()) - 1))]);
}

}  // namespace

World random_world(uint64_t seed)
{
    Draw draw(seed);
    World world;
    world.name = "seed-" + std::to_string(seed);
    if (draw.chance(0.08)) world.periodic = "xz";
    world.bodies.push_back(body(draw, !world.periodic.empty()));
    if (draw.chance(0.07) && world.bodies[0].find("emission") == std::string::npos && world.periodic.empty())
        world.bodies.push_back("box n=2,3,2 value=" + number(draw.uniform(0.1, 2)));
    world.stages = draw.one_of({"p1solve", "p1solve", "p1solve render", "illuminate", "illuminate p1solve",
                                "illuminate p1solve render", "illuminate render", "render"});
    if (world.periodic.empty()) choose_axes(draw, world);
    choose_medium(draw, world);
    choose_lights(draw, world);
    choose_options(draw, world);
    if (world.bodies.size() > 1 && world.stages == "illuminate render") world.stages = "illuminate";
    choose_invariants(draw, world);
    for (std::string* words : {&world.light, &world.solve}) words->erase(0, words->find_first_not_of(' '));
    return world;
}

}  // namespace vdbcloud::test
