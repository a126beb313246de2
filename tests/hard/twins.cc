// Invariants that compare a world with other worlds.
#include "hard/invariants.h"
#include "hard/values.h"

#include <algorithm>

namespace vdbcloud::test {

namespace {

Verdict twin(Chain& chain, const World& world, const Seen& seen, const Change& change, double factor = 1)
{
    return difference(seen, chain.run(world, change), change, factor);
}

/// Each light alone.
std::vector<World> lights_apart(const World& world)
{
    std::vector<World> all;
    for (const WorldLight& light : world.lights) {
        all.push_back(world);
        all.back().lights = {light};
        all.back().sky.clear();
    }
    if (!world.sky.empty() && world.runs("p1solve")) {
        all.push_back(world);
        all.back().lights.clear();
        all.back().stages = world.runs("render") ? "p1solve render" : "p1solve";  // illuminate would bring its own sun
    }
    // Options of suns are refused without a sun.
    for (World& part : all) {
        if (std::none_of(part.lights.begin(), part.lights.end(), [](const auto& light) { return !light.lamp; })) {
            for (const char* of_suns : {"--fidelity", "--rays-per-voxel", "--error-samples"})
                remove_option(part.light, of_suns);
            remove_option(part.solve, "--rays-per-voxel");
        }
        if (!has_discs(part)) {
            remove_option(part.light, "--disc-samples");
            remove_option(part.solve, "--disc-samples");
        }
    }
    return all;
}

}  // namespace

namespace invariant_of {

/// (x, y, z) -> (z, x, y), in the world and in the index space: +y up becomes +z up.
Verdict turned(Chain& chain, const World& world, const Seen& seen)
{
    Change change;
    change.axis = {2, 0, 1};
    change.world = {Vec3d(0, 0, 1), Vec3d(1, 0, 0), Vec3d(0, 1, 0)};
    return twin(chain, world, seen, change);
}

Verdict mirrored(Chain& chain, const World& world, const Seen& seen)
{
    Change change;
    change.sign = {-1, 1, 1};
    change.world[0] = Vec3d(-1, 0, 0);
    change.flipped = true;
    return twin(chain, world, seen, change);
}

/// Other index axes for the same body at the same place.
Verdict relabelled(Chain& chain, const World& world, const Seen& seen)
{
    Change change;
    change.axis = {1, 2, 0};
    change.sign = {1, -1, 1};
    return twin(chain, world, seen, change);
}

/// The same body at the same place, by indices that differ: leaf blocks cut it elsewhere.
Verdict shifted(Chain& chain, const World& world, const Seen& seen)
{
    Change change;
    change.shift = Vec3i(3, 5, 2);
    for (int c = 0; c < 3; ++c)
        if (world.periodic.find(char('x' + c)) != std::string::npos) change.shift[c] = 0;  // a period begins at a block
    return twin(chain, world, seen, change);
}

Verdict rescaled(Chain& chain, const World& world, const Seen& seen)
{
    Change change;
    change.size = world.axes[0].length() > 0.1 ? 1.0 / 768 : 768;  // OpenVDB calls a matrix of tiny voxels singular
    for (size_t c = 0; c < 3; ++c) change.world[c] *= change.size;
    change.density = 1 / change.size;
    return twin(chain, world, seen, change);
}

Verdict brighter(Chain& chain, const World& world, const Seen& seen)
{
    Change change;
    change.power = 300;
    return twin(chain, world, seen, change, change.power);
}

Verdict threads(Chain& chain, const World& world, const Seen& seen)
{
    chain.set_threads(3);
    const Seen other = chain.run(world);
    chain.set_threads(1);
    return difference(seen, other, {}, 1);
}

Verdict denser(Chain& chain, const World& world, const Seen& seen)
{
    Change change;
    change.density = 1.7;
    const Seen other = chain.run(world, change);
    Verdict verdict;
    if (failed(other, verdict)) return verdict;
    for (const auto& [name, grid] : seen.grids) {
        if (!begins(name, "transmittance_") || !other.grids.count(name)) continue;
        const Vectors thin(grid), dense(other.grids.at(name));
        const std::string& grid_name = name;
        thin.each([&](const openvdb::Coord& c) {
            const Vec3d more = dense.value(c) - thin.value(c);
            for (int k = 0; k < 3; ++k) verdict.take(more[k], name_of(grid_name, c));
        });
    }
    for (const char* channel : {"transmittance.R", "transmittance.G", "transmittance.B"}) {
        const auto thin = seen.picture.layer(channel), dense = other.picture.layer(channel);
        for (size_t k = 0; k < thin.size() && k < dense.size(); ++k)
            verdict.take(double(dense[k]) - double(thin[k]) * (1 + half_rounding), std::string("picture, ") + channel);
    }
    for (const auto& [channel, report] : seen.channels.items()) {
        const double thin = report["budget"]["beam_lost_in_medium"].get<double>();
        const double dense = other.channels[channel]["budget"]["beam_lost_in_medium"].get<double>();
        // Shadows fall on quarters of the faces of opaque voxels. In a regular body the same quarter of all faces
        // across one axis darkens: a twelfth of the light where the axes count alike.
        if (thin > 0) verdict.take((thin - dense) / thin - 0.1, "beam_lost_in_medium of channel " + channel);
    }
    return verdict;
}

Verdict lights(Chain& chain, const World& world, const Seen& seen)
{
    std::vector<Seen> parts;
    Verdict verdict;
    for (const World& part : lights_apart(world)) {
        parts.push_back(chain.run(part));
        if (failed(parts.back(), verdict)) return verdict;
    }
    if (seen.grids.count("phi")) {
        const Vectors phi(seen.grids.at("phi"));
        double most = 0, worst = 0;
        openvdb::Coord where(0);
        phi.each([&](const openvdb::Coord& c) {
            Vec3d sum(0);
            for (const Seen& part : parts)  // without phi: the light is not scattered, and adds nothing
                if (const auto own = part.grids.find("phi"); own != part.grids.end())
                    sum += Vectors(own->second).colour(c);
            most = std::max(most, largest(phi.colour(c)));
            const double error = largest(phi.colour(c) - sum);
            if (!(error <= worst)) worst = error, where = c;
        });
        verdict.take(worst == 0 ? 0 : worst / most, name_of("phi", where));
    }
    const auto limited = [](const Seen& one) {
        for (const auto& [channel, report] : one.channels.items())
            if (report["flux_limited_voxels"].get<double>() > 0) return true;
        return false;
    };
    if (limited(seen) || std::any_of(parts.begin(), parts.end(), limited)) return verdict;
    for (const char* channel : {"R", "G", "B"}) {
        const auto together = seen.picture.layer(channel);
        double most = 0, worst = 0;
        for (size_t k = 0; k < together.size(); ++k) {
            double sum = 0, rounding = half_rounding * double(std::abs(together[k]));
            for (const Seen& part : parts) {
                const double value = part.picture.layer(channel).at(k);
                sum += value;
                rounding += half_rounding * std::abs(value) + half_least;
            }
            most = std::max(most, std::abs(sum));
            worst = std::max(worst, std::abs(sum - double(together[k])) - rounding);
        }
        verdict.take(worst == 0 ? 0 : worst / most, std::string("picture, ") + channel);
    }
    return verdict;
}

/// Green of a coloured world against a grey world of green's numbers.
Verdict grey(Chain& chain, const World& world, const Seen& seen)
{
    World one = world;
    Words medium = split(world.medium);
    one.medium.clear();
    for (std::string& word : medium) {
        if (word.find(',') != std::string::npos) word = digits(colour(word)[1]);
        one.medium += word + " ";
    }
    for (WorldLight& light : one.lights) light.power = Vec3d(light.power[1]);
    const Seen other = chain.run(one);
    Verdict verdict;
    if (failed(other, verdict)) return verdict;
    for (const auto& [name, grid] : seen.grids) {
        if (!(begins(name, "transmittance_") || name == "phi") || !other.grids.count(name)) continue;
        const Vectors a(grid), b(other.grids.at(name));
        double most = 0, worst = 0;
        openvdb::Coord where(0);
        a.each([&](const openvdb::Coord& c) {
            most = std::max(most, std::abs(b.colour(c)[1]));
            const double error = std::abs(a.colour(c)[1] - b.colour(c)[1]);
            if (!(error <= worst)) worst = error, where = c;
        });
        verdict.take(worst == 0 ? 0 : worst / most, name_of(name, where));
    }
    const auto a = seen.picture.layer("G"), b = other.picture.layer("G");
    double most = 0, worst = 0;
    for (size_t k = 0; k < a.size() && k < b.size(); ++k) {
        const double size = std::max(std::abs(a[k]), std::abs(b[k]));
        most = std::max(most, size);
        worst = std::max(worst, double(std::abs(a[k] - b[k])) - half_rounding * size - half_least);
    }
    verdict.take(worst == 0 ? 0 : worst / most, "picture, G");
    return verdict;
}

/// 16-bit floats against floats, beyond their rounding.
Verdict half(Chain& chain, const World& world, const Seen& seen)
{
    World small = world;
    small.solve += " --half";
    small.stages = "p1solve";
    const Seen other = chain.run(small);
    Verdict verdict;
    if (failed(other, verdict)) return verdict;
    for (const auto& [name, grid] : seen.grids) {
        if (!begins(name, "phi") && !begins(name, "flux")) continue;
        const Vectors a(grid), b(other.grids.at(name));
        const std::string& grid_name = name;
        double most = 0;
        a.each([&](const openvdb::Coord& c) { most = std::max(most, largest(a.value(c))); });
        a.each([&](const openvdb::Coord& c) {
            const double rounding = half_rounding / 2 * largest(a.value(c)) + half_least;
            verdict.take((largest(a.value(c) - b.value(c)) - rounding) / most, name_of(grid_name, c));
        });
    }
    return verdict;
}

/// Two files of half the density each are the medium of one file.
Verdict inputs(Chain& chain, const World& world, const Seen& seen)
{
    World two = world;
    two.bodies = {world.bodies[0] + " times=0.5", world.bodies[0] + " times=0.5"};
    return difference(seen, chain.run(two), {}, 1);
}

}  // namespace invariant_of

}  // namespace vdbcloud::test
