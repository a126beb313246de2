#include "vdbcloud/render/integrator.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/core/words.h"
#include "vdbcloud/render/coarse_first.h"
#include "vdbcloud/render/layer_places.h"
#include "vdbcloud/render/media.h"
#include "vdbcloud/render/path_image.h"
#include "vdbcloud/render/scene_costs.h"
#include "vdbcloud/render/surface_light.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <memory>

namespace vdbcloud {

namespace {

constexpr auto kinds = words<Integrator>("integrator", {{Integrator::Cells, "cells"},
                                                        {Integrator::Romberg, "romberg"},
                                                        {Integrator::Steps, "steps"},
                                                        {Integrator::Path, "path"}});

bool wants(const std::vector<std::string>& wanted, const std::string& layer)
{
    for (const auto& w : wanted)
        if (w == "all" || w == layer || (w == "direct" && layer.rfind("direct_", 0) == 0)) return true;
    return false;
}

bool wants_by_name(const std::vector<std::string>& wanted, const std::string& layer)
{
    return std::find(wanted.begin(), wanted.end(), layer) != wanted.end();
}

void check(const IntegratorOptions& o)
{
    if (!(o.tolerance > 0)) throw InputError("tolerance " + std::to_string(o.tolerance) + ": expected > 0");
    if (!(o.step > 0)) throw InputError("step " + std::to_string(o.step) + ": expected > 0");
    if (o.vertices != 0 && o.vertices < 2)
        throw InputError("vertices " + std::to_string(o.vertices) + ": expected 2 or more, or 0 for whole paths");
    if (o.parts < 1) throw InputError("parts " + std::to_string(o.parts) + ": expected 1 or more");
    if (o.solid_rays < 1) throw InputError("solid rays " + std::to_string(o.solid_rays) + ": expected 1 or more");
}

/// The random numbers of a sample of the film at x, y.
PathRandom random_of(uint64_t seed, double x, double y)
{
    uint64_t bits[2];
    std::memcpy(&bits[0], &x, sizeof x);
    std::memcpy(&bits[1], &y, sizeof y);
    return PathRandom(seed, int(std::floor(x)), int(std::floor(y)), hash_bits(bits[0], bits[1]));
}

}  // namespace

std::unique_ptr<RayIntegrator> make_integrator(const PreparedScene& scene, const IntegratorOptions& options)
{
    switch (options.kind) {
    case Integrator::Cells: return make_cells_integrator(scene, options);
    case Integrator::Romberg: return make_romberg_integrator(scene, options);
    case Integrator::Steps: return make_steps_integrator(scene, options);
    case Integrator::Path: break;  // render_paths()
    }
    throw InputError("integrator: expected cells, romberg or steps");
}

const char* name(Integrator kind) { return kinds.word(kind); }

Integrator integrator_kind(const std::string& text) { return kinds.value(text); }

std::vector<LayerSpec> render_layers(const Scene& scene, const std::vector<std::string>& wanted, Integrator kind)
{
    const std::vector<std::string> rgb{"R", "G", "B"};
    std::vector<LayerSpec> possible{{"Z", {"Z"}, false, Combine::Nearest},
                                    {"transmittance", rgb, false, Combine::Mean}};
    for (const auto& light : scene.lights) possible.push_back({"direct_" + light.name, rgb, true, Combine::Mean});
    possible.push_back({"multiscatter", rgb, true, Combine::Mean});
    possible.push_back({"emission", rgb, true, Combine::Mean});
    if (scene.ground) possible.push_back({"ground", rgb, true, Combine::Mean});
    if (!scene.solids.empty()) possible.push_back({"solid", rgb, true, Combine::Mean});
    possible.push_back({"variance", {"Y"}, false, Combine::Mean});
    const bool path = kind == Integrator::Path;
    if (path) {
        possible.push_back({"standard_error", rgb, false, Combine::Mean});
        possible.push_back({"seconds", {"Y"}, false, Combine::Sum});
    }

    std::vector<LayerSpec> layers{{"", {"R", "G", "B", "A"}, true, Combine::Mean},
                                  {"background", rgb, true, Combine::Mean}};
    for (const auto& w : wanted) {
        bool known = w == "all" || w == "direct";
        for (const auto& p : possible) known = known || p.name == w;
        if (!known)
            throw UsageError("layer '" + printable(w) +
                             "': expected all, direct, direct_<light>, multiscatter, "
                             "emission, ground over a ground, solid with solids, transmittance, Z or variance" +
                             (path ? ", standard_error or seconds" : "; standard_error and seconds need path"));
    }
    for (const auto& p : possible)
        if (p.name == "seconds" ? wants_by_name(wanted, p.name) : wants(wanted, p.name)) layers.push_back(p);
    if (path)
        for (auto& layer : layers) layer.half = false;
    return layers;
}

RenderCost render_image(Film& film, const Scene& scene, const CameraView& view, const SamplingOptions& sampling,
                        const IntegratorOptions& options, const Progress& progress)
{
    check(options);
    if (options.kind == Integrator::Path) return render_paths(film, scene, view, sampling, options, progress);
    const PreparedScene prepared(scene, options);
    const SurfaceScene surfaces(scene, prepared, options);
    const LayerPlaces places(film, scene);
    std::atomic<uint64_t> rays{0}, cells{0}, lit{0}, unconverged{0};

    const SamplerFactory factory = [&]() -> SampleFunction {
        auto integrate = std::make_shared<SurfaceLight>(surfaces);
        auto result = std::make_shared<RayResult>();
        return [&, integrate, result](double x, double y, double* out) {
            const WorldRay ray = view.ray(x, y);
            (*integrate)(ray, random_of(sampling.seed, x, y), *result);
            places.put(*result, view, scene.background, x, y, ray.direction, out);
            rays.fetch_add(1 + result->further, std::memory_order_relaxed);
            cells.fetch_add(result->cells, std::memory_order_relaxed);
            lit.fetch_add(result->lit, std::memory_order_relaxed);
            if (!result->converged) unconverged.fetch_add(1, std::memory_order_relaxed);
        };
    };
    CoarseReport coarse;
    if (options.passes.time_limit > 0 || options.passes.show)
        coarse = expose_coarse_first(film, sampling, options.passes, factory, progress);
    else
        expose(film, sampling, factory, progress);
    return {rays, cells,  lit,
            0,    0,      unconverged,
            {},   coarse, costs_of(scene, prepared, rays, lit ? lit.load() : cells.load())};
}

}  // namespace vdbcloud
