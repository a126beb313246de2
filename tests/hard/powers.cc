// Invariants of one world: values, bounds, powers, and the furnace.
#include "hard/invariants.h"
#include "hard/values.h"
#include "vdbcloud/optics/delta_scaling.h"
#include "vdbcloud/optics/phase_function.h"

#include <algorithm>
#include <limits>
#include <regex>

namespace vdbcloud::test {

namespace {

PhaseFunction phase_of(const std::string& medium)
{
    const PhaseForm& form = phase_form(option(medium, "--phase", "henyey-greenstein"));
    std::vector<double> parameters;
    for (const PhaseParameter& p : form.parameters)
        parameters.push_back(std::stod(option(medium, std::string("--") + p.name, "0")));
    return PhaseFunction(form.name, parameters);
}

/// The largest value of the phase function, which is at an end for every form of the table but Rayleigh's, whose ends
/// are both largest.
double largest_phase(const std::string& medium)
{
    const PhaseFunction phase = phase_of(medium);
    return std::max(phase(1), phase(-1));
}

/// A bound of -phi / E where a beam E meets a surface head-on, in P1 with delta scaling.
///
/// The flux q E T s of the beam's first moment, q = w0' g' / (1 - w0' g'), begins at the lit surface and is a sink of
/// phi there; its divergence and the first scattering are sources (w0' + q) sigma_t' E T. In the coordinate r,
/// dr = 3 sigma_tr dx, P1 is
///
///     phi'' = -c E exp(-k r),   phi'(0) = q E + phi(0) / 2,   c = (w0' + q) k,   k = 1 / (3 (1 - w0' g'))
///
/// for any density. Light that leaves through other surfaces ends the layer of negative phi at some r = R, phi(R) = 0.
/// The bound is the largest over R. Absorption only raises phi < 0. Where q < 0 the layer lies on the far side, whose
/// sources grow with r. `uniform`: the albedo is; without it the sources do not count, and the bound is 2 |q|, that of
/// the maximum principle.
double deepest_negative(const PhaseFunction& phase, double albedo, bool uniform)
{
    const DeltaScaling delta = delta_scaling(phase, 1);
    const double forward = delta.albedo(albedo) * delta.mean_cosine(), q = forward / (1 - forward);
    const double k = 1 / (3 * (1 - forward)), c = uniform ? (delta.albedo(albedo) + q) * k : 0.0;
    double most = uniform ? 0.0 : 2 * std::abs(q);
    for (double r = 0.01; uniform && r < 1e4; r *= 1.05) {
        const double sources = q > 0 ? (r + std::expm1(-k * r) / k) / k : r * r / 2;
        most = std::max(most, (std::abs(q) * r - c * sources) / (1 + r / 2));
    }
    return most;
}

void bound_fluence(const World& world, const Seen& seen, Verdict& verdict)
{
    const std::string sky = option(world.sky, "--sky", "0");
    // Without delta scaling P1 has a fluence far below 0 where a narrow peak enters.
    if (world.solve.find("--delta off") != std::string::npos) return;
    if (has_lamps(world) || emits(world) || !world.periodic.empty() || sky == "day" || !seen.grids.count("phi") ||
        world.sky.find("--sky-") != std::string::npos || world.solve.find("--ground-albedo") != std::string::npos)
        return;
    // Under beams alone, the largest fluence of collided light in a half-space that absorbs nothing is 3 mu + 2 times
    // E, mu <= 1, in P1 (Eddington); a body that ends on all sides has less.
    // At the middle of a voxel it grows by 3/2 of the optical depth of its edge.
    Vec3d most = 4 * pi * colour(sky);
    double edge = 0;
    for (const Vec3d& axis : world.axes) edge = std::max(edge, axis.length());
    const Vec3d depth = edge * colour(option(world.medium, "--extinction", "1"));
    for (const WorldLight& light : world.lights) most += (Vec3d(5) + 1.5 * depth) * light.power;

    // Where light meets a thin part, P1's own fluence of forward scattering falls below 0. Layers of negative fluence
    // along the index axes add up at a corner. Sweeps and the limiter leave up to 0.02 of `most` in these worlds.
    Vec3d least = -0.02 * most;
    if (world.solve.find("--iterations") == std::string::npos && world.solve.find("--limiter") == std::string::npos) {
        const PhaseFunction phase = phase_of(world.medium);
        const Vec3d albedo = colour(option(world.medium, "--albedo", "1"));
        const bool uniform = std::none_of(world.bodies.begin(), world.bodies.end(),
                                          [](const auto& body) { return body.find("cd=") != std::string::npos; });
        least = Vec3d(0);
        for (const WorldLight& light : world.lights) {
            double corner = 0;  // of the light's components along the index axes
            for (const Vec3d& axis : world.axes) corner += std::abs(light.at.unit().dot(axis.unit()));
            for (int k = 0; k < 3; ++k)
                least[k] -= corner * deepest_negative(phase, albedo[k], uniform) * light.power[k];
        }
    }
    const Vectors phi(seen.grids.at("phi"));
    phi.each([&](const openvdb::Coord& c) {
        const Vec3d here = phi.colour(c);
        for (int k = 0; k < 3; ++k)
            if (most[k] > 0)
                verdict.take(std::max(here[k] / most[k] - 1, (least[k] - here[k]) / most[k]), name_of("phi", c));
    });
}

/// Collided radiance along a ray is a mean of albedo (phi + 3 g s.F) / 4 pi of voxels and of 0, where |F| <= phi / 3
/// and F = 0 where phi < 0. Sweeps of degree d expand it in (d + 1)^2 harmonics, whose sum is at most (d + 1)^2 phi and
/// at least phi less the others.
void bound_collided(const World& world, const Seen& seen, Verdict& verdict)
{
    if (!seen.grids.count("phi")) return;
    const Vectors phi(seen.grids.at("phi"));
    Vec3d least(0), most(0);
    phi.each([&](const openvdb::Coord& c) {
        least = openvdb::math::minComponent(least, phi.colour(c));
        most = openvdb::math::maxComponent(most, phi.colour(c));
    });
    double times = 2;
    if (world.solve.find("--iterations") != std::string::npos) {
        times = std::pow(std::stoi(option(world.solve, "--degree", "1")) + 1, 2);
        least -= (times - 1) * most;
    }
    const Vec3d scale = openvdb::math::maxComponent(most, -least);
    const char* names[] = {"multiscatter.R", "multiscatter.G", "multiscatter.B"};
    for (int c = 0; c < 3; ++c)
        for (const float value : seen.picture.layer(names[c])) {
            const double size = 4 * pi * double(value);
            const double beyond = std::max(size - times * most[c], least[c] - size) - half_least;
            if (beyond > 0) verdict.take(beyond / scale[c] - half_rounding, std::string("picture, ") + names[c]);
        }
}

void bound_radiance(const World& world, const PictureFile& picture, Verdict& verdict)
{
    for (size_t k = 0; k < picture.pixels.size(); ++k) {
        const std::string& channel = picture.channels[k % picture.channels.size()];
        const double value = picture.pixels[k];
        if (begins(channel, "transmittance") || channel == "A") verdict.take(value - 1, "picture, " + channel);
        // Collided light has bounds of its own. The picture's sum has them, too.
        const bool sum = channel == "R" || channel == "G" || channel == "B";
        const bool collided = world.runs("p1solve") && (sum || begins(channel, "multiscatter"));
        if (channel != "Z" && !collided) verdict.take(-value, "picture, " + channel);
    }
    if (has_lamps(world) || picture.pixels.empty()) return;
    // Light scattered once along a ray is at most albedo x phase function x E x (1 - T).
    const double phase = largest_phase(world.medium);
    const char* names[] = {"direct.R", "direct.G", "direct.B"};
    for (int c = 0; c < 3; ++c) {
        double most = 0;
        for (const WorldLight& light : world.lights) most += light.power[c] * phase;
        most *= colour(option(world.medium, "--albedo", "1"))[c];
        for (const float value : picture.layer(names[c]))
            if (most > 0) verdict.take(double(value) / most - 1 - half_rounding, std::string("picture, ") + names[c]);
    }
}

}  // namespace

namespace invariant_of {

/// Values that are no number, everywhere.
Verdict finite(Chain&, const World&, const Seen& seen)
{
    double wrong = 0;
    std::string where;
    const auto look = [&](double value, const std::string& what) {
        if (std::isfinite(value)) return;
        if (wrong == 0) where = what;
        ++wrong;
    };
    for (const auto& entry : seen.grids) {
        const std::string& name = entry.first;
        const Vectors values(entry.second);
        if (!values.readable()) continue;
        values.each([&](const openvdb::Coord& c) { look(values.value(c).lengthSqr(), name_of(name, c)); });
    }
    for (size_t k = 0; k < seen.picture.pixels.size(); ++k) {
        const std::string& channel = seen.picture.channels[k % seen.picture.channels.size()];
        if (channel != "Z") look(seen.picture.pixels[k], "picture, " + channel);
    }
    const auto flat = seen.channels.is_null() ? nlohmann::json::object() : seen.channels.flatten();
    for (const auto& [key, value] : flat.items())
        if (value.is_null()) look(std::numeric_limits<double>::quiet_NaN(), "report, " + key);
    Verdict verdict;
    verdict.take(wrong, where);
    return verdict;
}

Verdict bounds(Chain&, const World& world, const Seen& seen)
{
    Verdict verdict;
    for (const auto& [name, grid] : seen.grids) {
        if (!begins(name, "transmittance_")) continue;
        const Vectors values(grid);
        const std::string& grid_name = name;
        values.each([&](const openvdb::Coord& c) {
            const Vec3d t = values.value(c);
            for (int k = 0; k < 3; ++k) verdict.take(std::max(t[k] - 1, -t[k]), name_of(grid_name, c));
        });
    }
    bound_fluence(world, seen, verdict);
    bound_radiance(world, seen.picture, verdict);
    bound_collided(world, seen, verdict);
    return verdict;
}

/// Power in less power out, of P1's report.
Verdict balance(Chain&, const World& world, const Seen& seen)
{
    Verdict verdict;
    const Vec3d albedo = colour(option(world.medium, "--albedo", "1"));
    const bool coloured = std::any_of(world.bodies.begin(), world.bodies.end(),
                                      [](const auto& body) { return body.find("cd=") != std::string::npos; });
    for (const auto& [channel, report] : seen.channels.items()) {
        const nlohmann::json& budget = report["budget"];
        const auto power = [&](const char* key) { return budget.value(key, 0.0); };
        verdict.take(std::abs(power("defect")), "defect of channel " + channel);
        double in = power("beam_lost_in_medium") + power("emitted") + std::abs(power("sky_in"));
        if (in <= 0) continue;
        verdict.take(-power("absorbed") / in, "absorbed of channel " + channel);
        const size_t c = std::string("rgb").find(channel);
        if (albedo[int(c)] == 1 && !coloured)
            verdict.take(power("absorbed") / in, "absorbed of channel " + channel + ", which absorbs nothing");
        if (!budget.contains("out_by_plane") || !world.periodic.empty() ||
            world.solve.find("--ground-albedo") != std::string::npos)
            continue;
        in = power("beam_lost_in_medium") + power("emitted") + power("sky_into_box");
        double out = power("entered_again") + power("absorbed");
        for (const auto& plane : budget["out_by_plane"]) out += plane.get<double>();
        verdict.take(std::abs(in - out) / in, "power through the planes, channel " + channel);
    }
    return verdict;
}

/// A sky of radiance 1 and no absorption: radiance 1 everywhere.
Verdict furnace(Chain& chain, const World& world, const Seen&)
{
    World white = world;
    white.lights.clear();
    white.sky = "--sky 1";
    white.stages = "p1solve render";
    Words medium = split(world.medium);
    const auto found = std::find(medium.begin(), medium.end(), "--albedo");
    if (found != medium.end()) medium.erase(found, found + 2);
    white.medium = "--albedo 1";
    for (const std::string& word : medium) white.medium += " " + word;
    remove_option(white.solve, "--disc-samples");
    remove_option(white.solve, "--rays-per-voxel");
    white.solve = std::regex_replace(white.solve, std::regex("--heating"), "");
    for (const char* own : {"--integrator", "--step", "--tolerance"})
        remove_option(white.view, own);  // their own errors
    white.view += " --background 1,1,1";
    const Seen seen = chain.run(white);
    Verdict verdict;
    if (failed(seen, verdict)) return verdict;
    const Vectors phi(seen.grids.at("phi"));
    phi.each([&](const openvdb::Coord& c) {
        verdict.take(largest(phi.colour(c) / (4 * pi) - Vec3d(1)), name_of("phi", c));
    });
    for (const char* channel : {"R", "G", "B"})
        for (const float value : seen.picture.layer(channel))
            verdict.take(std::abs(double(value) - 1) - half_rounding, std::string("picture, ") + channel);
    return verdict;
}

}  // namespace invariant_of

}  // namespace vdbcloud::test
