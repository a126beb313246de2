#include "hard/judge.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/optics/phase_function.h"
#include "vdbcloud/scene/camera.h"

#include <algorithm>
#include <limits>
#include <regex>
#include <stdexcept>

namespace vdbcloud::test {

namespace {

constexpr double pi = 3.14159265358979323846;
const double half_rounding = 0x1p-10, half_least = 0x1p-24;  ///< of 16-bit floats: relative and absolute

bool begins(const std::string& text, const std::string& with) { return text.rfind(with, 0) == 0; }

std::string name_of(const std::string& grid, const openvdb::Coord& c)
{
    return grid + " at " + std::to_string(c.x()) + "," + std::to_string(c.y()) + "," + std::to_string(c.z());
}

/// Reads a float or vec3s grid as vectors: of a float grid three times its value.
class Vectors {
public:
    explicit Vectors(const GridBasePtr& grid)
        : grid_(grid), floats_(openvdb::gridPtrCast<FloatGrid>(grid)), vectors_(openvdb::gridPtrCast<Vec3SGrid>(grid))
    {
        if (const auto scale = grid->getMetadata<openvdb::Vec3DMetadata>("vdbcloud:channel_scale"); floats_ && scale)
            scale_ = scale->value();
    }
    Vec3d place(const openvdb::Coord& c) const { return grid_->transform().indexToWorld(c); }
    Vec3d index(const Vec3d& place) const { return grid_->transform().worldToIndex(place); }
    bool readable() const { return floats_ || vectors_; }
    bool active(const openvdb::Coord& c) const
    {
        return floats_ ? floats_->tree().isValueOn(c) : vectors_->tree().isValueOn(c);
    }
    /// With the factors of the channels that share the grid.
    Vec3d colour(const openvdb::Coord& c) const { return scale_ * value(c); }
    Vec3d value(const openvdb::Coord& c) const
    {
        return floats_ ? Vec3d(floats_->tree().getValue(c)) : Vec3d(vectors_->tree().getValue(c));
    }
    void each(const std::function<void(const openvdb::Coord&)>& visit) const
    {
        if (floats_)
            for (auto v = floats_->cbeginValueOn(); v; ++v) visit(v.getCoord());
        if (vectors_)
            for (auto v = vectors_->cbeginValueOn(); v; ++v) visit(v.getCoord());
    }

private:
    GridBasePtr grid_;
    std::shared_ptr<FloatGrid> floats_;
    std::shared_ptr<Vec3SGrid> vectors_;
    Vec3d scale_{1, 1, 1};
};

double largest(const Vec3d& v)
{
    double most = 0;
    for (int c = 0; c < 3; ++c)
        if (!(std::abs(v[c]) <= most)) most = std::abs(v[c]);
    return most;
}

bool holds_light(const std::string& grid)
{
    return begins(grid, "transmittance_") || begins(grid, "phi") || begins(grid, "flux") || begins(grid, "heating") ||
           begins(grid, "ground_radiance");
}

/// What a grid's values of the world become in the twin.
Vec3d expected(const std::string& grid, const Vec3d& value, const Change& change, double factor)
{
    if (begins(grid, "transmittance_")) return value;
    if (begins(grid, "flux")) return factor / change.size * change.point(value);
    return factor / (begins(grid, "heating") ? change.size : 1) * value;
}

/// Differences of two grids over the largest value.
void compare_grids(const std::string& name, const Vectors& a, const Vectors& b, const Change& change, double factor,
                   Verdict& verdict)
{
    double most = 0, worst = 0;
    int voxels = 0, compared = 0;
    openvdb::Coord where(0);
    a.each([&](const openvdb::Coord& c) {
        ++voxels;
        const Vec3d from = expected(name, a.value(c), change, factor);
        const Vec3d place = b.index(change.point(a.place(c)));
        const openvdb::Coord there = openvdb::Coord::round(place);
        // The places of a refined grid are not symmetric: half of them coincide.
        if ((place - there.asVec3d()).length() > 0.01 || !b.active(there)) return;
        ++compared;
        const double error = largest(from - b.value(there));
        most = std::max(most, largest(from));
        if (!(error <= worst)) worst = error, where = c;
    });
    verdict.take(worst == 0 ? 0 : worst / most, name_of(name, where));
    if (compared < voxels / 5) verdict.take(std::numeric_limits<double>::infinity(), name + " is at other places");
}

void compare_powers(const Seen& a, const Seen& b, const Change& change, double factor, Verdict& verdict)
{
    for (const auto& [channel, report] : a.channels.items())
        for (const char* key : {"beam_lost_in_medium", "emitted", "absorbed"}) {
            const double from = factor * change.size * change.size * report["budget"][key].get<double>();
            const double to = b.channels[channel]["budget"][key].get<double>();
            const double most = factor * change.size * change.size *
                                std::max({report["budget"]["beam_lost_in_medium"].get<double>(),
                                          report["budget"]["emitted"].get<double>(),
                                          std::abs(report["budget"]["sky_in"].get<double>())});
            if (from != to) verdict.take(std::abs(from - to) / most, std::string(key) + " of channel " + channel);
        }
}

double layer_factor(const std::string& channel, const Change& change, double factor)
{
    if (begins(channel, "transmittance") || channel == "A") return 1;
    if (begins(channel, "variance")) return factor * factor;
    return channel == "Z" ? change.size : factor;
}

/// Z of a ray whose transmittance stays above 0.5. Rounding decides whether a ray gets there.
bool endless_depth(double a, double b) { return a > 1e29 || b > 1e29; }

/// Differences of two pictures beyond the rounding of 16-bit floats, over the largest value of a layer.
void compare_pictures(const Picture& a, const Picture& b, const Change& change, double factor, Verdict& verdict)
{
    if (a.channels != b.channels || a.width != b.width || a.height != b.height)
        return verdict.take(std::numeric_limits<double>::infinity(), "the layers or the size of the picture");
    for (size_t c = 0; c < a.channels.size(); ++c) {
        const double scale = layer_factor(a.channels[c], change, factor);
        double most = 0, worst = 0;
        std::string where;
        for (int y = 0; y < a.height; ++y)
            for (int x = 0; x < a.width; ++x) {
                const double from = scale * double(a.at(x, y, c));
                const double to = b.at(change.flipped ? a.width - 1 - x : x, y, c);
                if (from == to || (a.channels[c] == "Z" && endless_depth(from / scale, to))) continue;
                const double size = std::max(std::abs(from), std::abs(to));
                most = std::max(most, size);
                const double error = std::abs(from - to) - half_rounding * size - half_least * std::max(1.0, scale);
                if (!(error <= worst)) worst = error, where = std::to_string(x) + "," + std::to_string(y);
            }
        verdict.take(worst == 0 ? 0 : worst / most, "picture, " + a.channels[c] + " at pixel " + where);
    }
}

/// A twin that could not be computed differs without end.
bool failed(const Seen& seen, Verdict& verdict)
{
    if (seen.failure.empty()) return false;
    verdict.take(std::numeric_limits<double>::infinity(), seen.failure);
    return true;
}

Verdict twin(Chain& chain, const World& world, const Seen& seen, const Change& change, double factor = 1)
{
    return difference(seen, chain.run(world, change), change, factor);
}

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

Verdict rescaled(Chain& chain, const World& world, const Seen& seen)
{
    Change change;
    change.size = 1.0 / 768;
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
        thin.each([&](const openvdb::Coord& c) {
            const Vec3d more = dense.value(c) - thin.value(c);
            for (int k = 0; k < 3; ++k) verdict.take(more[k], name_of(name, c));
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
        // Where a voxel is opaque, the beam's rays meet the faces of a voxel with an error of some percent.
        if (thin > 0) verdict.take((thin - dense) / thin - 0.03, "beam_lost_in_medium of channel " + channel);
    }
    return verdict;
}

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
    for (const auto& [name, grid] : seen.grids) {
        const Vectors values(grid);
        if (!values.readable()) continue;
        values.each([&](const openvdb::Coord& c) { look(values.value(c).lengthSqr(), name_of(name, c)); });
    }
    for (size_t k = 0; k < seen.picture.values.size(); ++k) {
        const std::string& channel = seen.picture.channels[k % seen.picture.channels.size()];
        if (channel != "Z") look(seen.picture.values[k], "picture, " + channel);
    }
    const auto flat = seen.channels.is_null() ? nlohmann::json::object() : seen.channels.flatten();
    for (const auto& [key, value] : flat.items())
        if (value.is_null()) look(std::numeric_limits<double>::quiet_NaN(), "report, " + key);
    Verdict verdict;
    verdict.take(wrong, where);
    return verdict;
}

/// The value after an option, or `otherwise`.
std::string option(const std::string& words, const std::string& name, const std::string& otherwise)
{
    const Words all = split(words);
    const auto found = std::find(all.begin(), all.end(), name);
    return found == all.end() || found + 1 == all.end() ? otherwise : found[1];
}

Vec3d colour(const std::string& numbers)
{
    Vec3d v(std::stod(numbers));
    if (const size_t a = numbers.find(','); a != std::string::npos) {
        v[1] = std::stod(numbers.substr(a + 1));
        v[2] = std::stod(numbers.substr(numbers.find(',', a + 1) + 1));
    }
    return v;
}

/// The largest value of the phase function, which is at an end for every form of the table but Rayleigh's, whose ends
/// are both largest.
double largest_phase(const std::string& medium)
{
    const PhaseForm& form = phase_form(option(medium, "--phase", "henyey-greenstein"));
    std::vector<double> parameters;
    for (const PhaseParameter& p : form.parameters)
        parameters.push_back(std::stod(option(medium, std::string("--") + p.name, "0")));
    const PhaseFunction phase(form.name, parameters);
    return std::max(phase(1), phase(-1));
}

bool has_discs(const World& world)
{
    return std::any_of(world.lights.begin(), world.lights.end(), [](const auto& light) { return light.diameter > 0; });
}

bool has_lamps(const World& world)
{
    return std::any_of(world.lights.begin(), world.lights.end(), [](const auto& light) { return light.lamp; });
}

bool emits(const World& world)
{
    return std::any_of(world.bodies.begin(), world.bodies.end(),
                       [](const auto& body) { return body.find("emission=") != std::string::npos; });
}

void bound_fluence(const World& world, const Seen& seen, Verdict& verdict)
{
    const std::string sky = option(world.sky, "--sky", "0");
    if (has_lamps(world) || emits(world) || !world.periodic.empty() || sky == "day" || !seen.grids.count("phi") ||
        world.sky.find("--sky-") != std::string::npos || world.solve.find("--ground-albedo") != std::string::npos)
        return;
    // Under beams alone, the largest fluence of collided light in a half-space that absorbs nothing is 3 mu + 2 times
    // E, mu <= 1, in P1 (Eddington); a body that ends on all sides has less. Where light meets a thin part, P1's own
    // fluence of forward scattering falls below 0, by up to 0.02 of that in these worlds.
    // At the middle of a voxel it grows by 3/2 of the optical depth of its edge.
    Vec3d most = 4 * pi * colour(sky);
    double edge = 0;
    for (const Vec3d& axis : world.axes) edge = std::max(edge, axis.length());
    const Vec3d depth = edge * colour(option(world.medium, "--extinction", "1"));
    for (const WorldLight& light : world.lights) most += (Vec3d(5) + 1.5 * depth) * light.power;
    const Vectors phi(seen.grids.at("phi"));
    phi.each([&](const openvdb::Coord& c) {
        const Vec3d here = phi.colour(c);
        for (int k = 0; k < 3; ++k)
            if (most[k] > 0)
                verdict.take(std::max(here[k] / most[k] - 1, -here[k] / most[k] - 0.02), name_of("phi", c));
    });
}

void bound_radiance(const World& world, const Picture& picture, Verdict& verdict)
{
    for (size_t k = 0; k < picture.values.size(); ++k) {
        const std::string& channel = picture.channels[k % picture.channels.size()];
        const double value = picture.values[k];
        if (begins(channel, "transmittance") || channel == "A") verdict.take(value - 1, "picture, " + channel);
        if (channel != "Z") verdict.take(-value, "picture, " + channel);
    }
    if (has_lamps(world) || picture.values.empty()) return;
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

void remove_option(std::string& words, const std::string& name)
{
    std::string left;
    const Words all = split(words);
    for (size_t k = 0; k < all.size(); ++k)
        if (all[k] == name)
            ++k;
        else
            left += all[k] + " ";
    words = left;
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
            part.light.clear();
            remove_option(part.solve, "--rays-per-voxel");
        }
        if (!has_discs(part)) {
            remove_option(part.light, "--disc-samples");
            remove_option(part.solve, "--disc-samples");
        }
    }
    return all;
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
            for (const Seen& part : parts) sum += Vectors(part.grids.at("phi")).colour(c);
            most = std::max(most, largest(phi.colour(c)));
            const double error = largest(phi.colour(c) - sum);
            if (!(error <= worst)) worst = error, where = c;
        });
        verdict.take(worst == 0 ? 0 : worst / most, name_of("phi", where));
    }
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

/// Camera rays against the exact optical depth in double.
Verdict lines(Chain& chain, const World& world, const Seen&)
{
    Programs programs;
    std::vector<FloatGridPtr> densities;
    openvdb::BBoxd box;
    for (const std::string& body : world.bodies) {
        densities.push_back(density_of_body(make_body(programs, body, world.axes, world.origin, {}, chain.folder())));
        const auto bounds = densities.back()->evalActiveVoxelBoundingBox();
        if (!bounds.empty())
            box.expand(densities.back()->transform().indexToWorld(
                openvdb::BBoxd(bounds.min().asVec3d(), bounds.max().asVec3d())));
    }
    Camera camera;
    camera.projection = Projection::Orthographic;
    camera.look_at = box.getCenter();
    const double size =
        box.extents().length() + 8 * world.axes[0].length() + 8 * world.axes[1].length() + 8 * world.axes[2].length();
    camera.position = camera.look_at - size * world.look.unit();
    camera.up = world.up == "z" ? Vec3d(0, 0, 1) : Vec3d(0, 1, 0);
    camera.width = 0.8 * std::max(box.extents().length(), world.axes[0].length());
    ImageSize pixels;
    pixels.width = pixels.height = 5;
    const Seen seen = chain.run_render(world, {"--projection", "orthographic", "--camera", digits(camera.position),
                                               "--look-at", digits(camera.look_at), "--ortho-width",
                                               digits(camera.width), "--resolution", "5", "--aov", "transmittance"});
    Verdict verdict;
    if (failed(seen, verdict)) return verdict;
    const CameraView view(camera, pixels);
    const Vec3d extinction = colour(option(world.medium, "--extinction", "1"));
    const char* names[] = {"transmittance.R", "transmittance.G", "transmittance.B"};
    for (int c = 0; c < 3; ++c) {
        const auto layer = seen.picture.layer(names[c]);
        for (int k = 0; k < 25; ++k) {
            const WorldRay ray = view.ray(k % 5 + 0.5, k / 5 + 0.5);
            double depth = 0;
            for (const auto& density : densities)
                depth += extinction[c] * line_integral(*density, ray.origin, ray.direction);
            const double exact = std::exp(-depth);
            verdict.take(std::abs(double(layer.at(size_t(k))) - exact) - half_rounding * exact,
                         std::string(names[c]) + " at pixel " + std::to_string(k % 5) + "," + std::to_string(k / 5) +
                             ", exactly " + digits(exact));
        }
    }
    return verdict;
}

/// The sun's transmittance at voxel centres against the exact optical depth in double.
Verdict beams(Chain& chain, const World& world, const Seen&)
{
    World light = world;
    light.stages = "illuminate";
    light.light = "--fidelity exact";
    const Seen seen = chain.run(light);
    Verdict verdict;
    if (failed(seen, verdict)) return verdict;
    Programs programs;
    const auto density =
        density_of_body(make_body(programs, world.bodies[0], world.axes, world.origin, {}, chain.folder()));
    const Vec3d extinction = colour(option(world.medium, "--extinction", "1"));
    for (const auto& [name, grid] : seen.grids) {
        if (!begins(name, "transmittance_")) continue;
        const Vectors values(grid);
        const std::string& grid_name = name;
        values.each([&](const openvdb::Coord& c) {
            const double depth =
                line_integral(*density, density->transform().indexToWorld(c), world.lights[0].at.unit());
            for (int k = 0; k < 3; ++k)
                verdict.take(std::abs(values.value(c)[k] - std::exp(-extinction[k] * depth)), name_of(grid_name, c));
        });
    }
    return verdict;
}

double mean(const std::vector<float>& values)
{
    double sum = 0;
    for (const float value : values) sum += double(value);
    return values.empty() ? 0 : sum / double(values.size());
}

/// The picture's mean against that of light paths, beyond four standard errors.
Verdict path(Chain& chain, const World& world, const Seen& seen)
{
    Words options = split(world.view);
    const Words more{"--direction", digits(world.look), "--integrator", "path", "--samples", "256",
                     "--aov",       "standard_error",   "--background", "none"};
    options.insert(options.end(), more.begin(), more.end());
    const Seen other = chain.run_render(world, options);
    Verdict verdict;
    if (failed(other, verdict)) return verdict;
    for (const char* channel : {"R", "G", "B"}) {
        const auto errors = other.picture.layer(std::string("standard_error.") + channel);
        double squares = 0;
        for (const float error : errors) squares += double(error) * double(error);
        const double error = std::sqrt(squares) / double(errors.size());
        const double exact = mean(other.picture.layer(channel)), found = mean(seen.picture.layer(channel));
        if (exact > 0) verdict.take((std::abs(found - exact) - 4 * error) / exact, std::string("picture, ") + channel);
    }
    return verdict;
}

bool anything(const World& world) { return world.commands.empty(); }
bool solves(const World& world) { return world.runs("p1solve"); }
bool limited(const World& world) { return world.solve.find("--limiter") != std::string::npos; }
bool linear(const World& world) { return anything(world) && !limited(world); }
/// The directions over a sun's disc are not symmetric.
bool symmetric(const World& world) { return anything(world) && !has_discs(world); }
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
bool seen_by_paths(const World& world)
{
    return bounded(world) && solves(world) && world.runs("render") && !world.lights.empty() && world.sky.empty() &&
           world.view.find("--integrator") == std::string::npos &&
           world.solve.find("--ground-albedo") == std::string::npos;
}

}  // namespace

Verdict difference(const Seen& a, const Seen& b, const Change& change, double factor)
{
    Verdict verdict;
    if (failed(b, verdict)) return verdict;
    for (const auto& [name, grid] : a.grids) {
        if (!holds_light(name)) continue;
        const auto other = b.grids.find(name);
        if (other == b.grids.end() || other->second->type() != grid->type()) {
            verdict.take(std::numeric_limits<double>::infinity(), "grid " + name + " is missing or has another type");
            continue;
        }
        compare_grids(name, Vectors(grid), Vectors(other->second), change, factor, verdict);
    }
    compare_powers(a, b, change, factor, verdict);
    compare_pictures(a.picture, b.picture, change, factor, verdict);
    return verdict;
}

double line_integral(const FloatGrid& density, const Vec3d& p, const Vec3d& d)
{
    const openvdb::math::Transform& transform = density.transform();
    const Vec3d origin = transform.worldToIndex(p), step = transform.worldToIndex(p + d) - origin;
    const auto box = density.evalActiveVoxelBoundingBox();
    if (box.empty()) return 0;
    double begin = 0, end = std::numeric_limits<double>::infinity();
    for (int c = 0; c < 3; ++c) {
        const double low = box.min()[c] - 1 - origin[c], high = box.max()[c] + 1 - origin[c];
        if (std::abs(step[c]) < 1e-300) {
            if (low > 0 || high < 0) return 0;
            continue;
        }
        begin = std::max(begin, std::min(low / step[c], high / step[c]));
        end = std::min(end, std::max(low / step[c], high / step[c]));
    }
    if (!(begin < end)) return 0;
    std::vector<double> places{begin, end};
    for (int c = 0; c < 3; ++c)
        if (std::abs(step[c]) > 1e-300)
            for (int i = box.min()[c] - 1; i <= box.max()[c] + 1; ++i)
                if (const double t = (i - origin[c]) / step[c]; t > begin && t < end) places.push_back(t);
    std::sort(places.begin(), places.end());
    const auto accessor = density.getConstAccessor();
    const auto value = [&](double t) {
        const Vec3d at = origin + t * step;
        const openvdb::Coord c = openvdb::Coord::floor(at);
        const Vec3d f = at - c.asVec3d();
        double sum = 0;
        for (int corner = 0; corner < 8; ++corner) {
            const int i = corner & 1, j = corner >> 1 & 1, k = corner >> 2;
            sum += (i ? f[0] : 1 - f[0]) * (j ? f[1] : 1 - f[1]) * (k ? f[2] : 1 - f[2]) *
                   double(accessor.getValue(c.offsetBy(i, j, k)));
        }
        return sum;
    };
    // Along a line a trilinear function is a cubic, for which two points of Gauss are exact.
    double sum = 0;
    const double offset = 0.5 / std::sqrt(3.0);
    for (size_t k = 0; k + 1 < places.size(); ++k) {
        const double width = places[k + 1] - places[k], middle = 0.5 * (places[k] + places[k + 1]);
        if (width > 0) sum += 0.5 * width * (value(middle - offset * width) + value(middle + offset * width));
    }
    return sum;
}

const std::vector<Invariant>& invariants()
{
    static const std::vector<Invariant> all = {
        {"finite", "values that are not finite", 0, "none may be", anything, finite},
        {"bounds", "excess of T over [0, 1], of fluence and radiance over what the lights can give, and below 0", 1e-3,
         "P1's fluence at a corner may be below 0 by rounding", anything, bounds},
        {"balance", "power in less power out, over power in", 2e-5, "twenty times the solver's tolerance", solves,
         balance},
        {"turned", "difference of the world turned by 120 degrees", 1e-4, "the solver's tolerance times its condition",
         symmetric, turned},
        {"mirrored", "difference of the mirrored world", 1e-4, "as above", symmetric, mirrored},
        {"relabelled", "difference with other index axes", 1e-4, "as above", anything, relabelled},
        {"rescaled", "difference of the world 768 times smaller and denser", 1e-4, "as above", anything, rescaled},
        {"brighter", "difference with all light 300 times stronger", 1e-4, "as above", anything, brighter},
        {"threads", "difference with 3 threads", 0, "results do not depend on threads", anything, threads},
        {"denser", "growth of a transmittance where the density grows", 1e-5, "rounding of float", bounded, denser},
        {"lights", "difference of all lights together and the sum of each alone", 1e-4, "as above", many_lights,
         lights},
        {"grey", "difference of green and a grey world of green's numbers", 1e-4, "as above", coloured, grey},
        {"half", "difference of 16-bit moments beyond their rounding", 1e-6, "rounding of float", solves, half},
        {"inputs", "difference of one file and two files of half the density", 1e-4, "as above", one_body, inputs},
        {"furnace", "difference from radiance 1 under a sky of 1 without absorption", 1e-4, "as above", white, furnace},
        {"lines", "difference of a camera ray's transmittance and its value in double", 1e-4, "floats in cells",
         bounded, lines},
        {"beams", "difference of the sun's transmittance and its value in double", 1e-4, "floats in cells", one_sun,
         beams},
        {"path", "difference of the picture's mean and that of light paths beyond four standard errors", 0.3,
         "the error of P1 in a body of some mean free paths, and that of voxels as long as a mean free path",
         seen_by_paths, path},
    };
    return all;
}

const Invariant& invariant(const std::string& name)
{
    for (const Invariant& one : invariants())
        if (one.name == name) return one;
    throw std::runtime_error("no invariant is called " + name);
}

}  // namespace vdbcloud::test
