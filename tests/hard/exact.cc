// Invariants that compare with values in double and with light paths.
#include "hard/invariants.h"
#include "hard/values.h"
#include "vdbcloud/scene/camera.h"

#include <algorithm>
#include <limits>

namespace vdbcloud::test {

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

namespace invariant_of {

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

/// The picture's mean against that of light paths, beyond four standard errors.
Verdict path(Chain& chain, const World& world, const Seen&)
{
    World smooth = world;                   // light paths see the whole pixel, not its centre alone
    remove_option(smooth.view, "--parts");  // of the picture by cells alone
    const std::string view = smooth.view;
    smooth.view += " --samples 100";
    const Seen seen = chain.run(smooth);
    Words options = chain.camera(world, {});
    for (const std::string& more :
         {view, std::string("--integrator path --samples 256 --aov standard_error --background none")})
        for (const std::string& word : split(more)) options.push_back(word);
    const Seen other = chain.run_render(world, options);
    Verdict verdict;
    if (failed(seen, verdict) || failed(other, verdict)) return verdict;
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

}  // namespace invariant_of

}  // namespace vdbcloud::test
