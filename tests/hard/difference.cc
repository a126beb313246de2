// Twins and their worlds, value by value.
#include "hard/values.h"

#include <algorithm>
#include <limits>

namespace vdbcloud::test {

namespace {

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

/// Differences of two grids over the largest value, or over `least` if that is larger.
void compare_grids(const std::string& name, const Vectors& a, const Vectors& b, const Change& change, double factor,
                   double least, Verdict& verdict)
{
    double most = least, worst = 0;
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
void compare_pictures(const PictureFile& a, const PictureFile& b, const Change& change, double factor, Verdict& verdict)
{
    if (a.channels != b.channels || a.width != b.width || a.height != b.height)
        return verdict.take(std::numeric_limits<double>::infinity(), "the layers or the size of the picture");
    for (size_t c = 0; c < a.channels.size(); ++c) {
        const double scale = layer_factor(a.channels[c], change, factor);
        const std::vector<float> before = a.layer(a.channels[c]), after = b.layer(a.channels[c]);
        double most = 0, worst = 0;
        std::string where;
        for (int y = 0; y < a.height; ++y)
            for (int x = 0; x < a.width; ++x) {
                const double from = scale * double(before[size_t(y * a.width + x)]);
                const double to = after[size_t(y * a.width + (change.flipped ? a.width - 1 - x : x))];
                if (from == to || (a.channels[c] == "Z" && endless_depth(from / scale, to))) continue;
                const double size = std::max(std::abs(from), std::abs(to));
                most = std::max(most, size);
                const double error = std::abs(from - to) - half_rounding * size - half_least * std::max(1.0, scale);
                if (!(error <= worst)) worst = error, where = std::to_string(x) + "," + std::to_string(y);
            }
        verdict.take(worst == 0 ? 0 : worst / most, "picture, " + a.channels[c] + " at pixel " + where);
    }
}

}  // namespace

namespace {

/// Of the fluence: the flux against which differences of smaller ones are judged. Sweeps round the radiance of each
/// direction to 2^-24 in each voxel that it crosses, 8 in these worlds: 5e-7 of the fluence, or 1e-4 of 5e-3.
double flux_least(const Seen& seen)
{
    for (const auto& [channel, report] : seen.channels.items())
        if (report.contains("sweeps")) return 5e-3;
    return 1e-3;
}

}  // namespace

Verdict difference(const Seen& a, const Seen& b, const Change& change, double factor)
{
    Verdict verdict;
    if (failed(b, verdict)) return verdict;
    double fluence = 0;
    for (const auto& [name, grid] : a.grids)
        if (begins(name, "phi")) {
            const Vectors phi(grid);
            phi.each([&](const openvdb::Coord& c) { fluence = std::max(fluence, largest(phi.value(c))); });
        }
    for (const auto& [name, grid] : a.grids) {
        if (!holds_light(name)) continue;
        const auto other = b.grids.find(name);
        if (other == b.grids.end() || other->second->type() != grid->type()) {
            verdict.take(std::numeric_limits<double>::infinity(), "grid " + name + " is missing or has another type");
            continue;
        }
        // A flux is what gradients of the fluence leave of each other: it has the fluence's rounding.
        const double least = begins(name, "flux") ? flux_least(a) * factor / change.size * fluence : 0;
        compare_grids(name, Vectors(grid), Vectors(other->second), change, factor, least, verdict);
    }
    compare_powers(a, b, change, factor, verdict);
    compare_pictures(a.picture, b.picture, change, factor, verdict);
    return verdict;
}

}  // namespace vdbcloud::test
