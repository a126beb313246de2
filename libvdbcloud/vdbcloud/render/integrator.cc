#include "vdbcloud/render/integrator.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/core/words.h"
#include "vdbcloud/render/media.h"

#include <atomic>
#include <cmath>
#include <memory>

namespace vdbcloud {

namespace {

constexpr auto kinds = words<Integrator>(
    "integrator", {{Integrator::Cells, "cells"}, {Integrator::Romberg, "romberg"}, {Integrator::Steps, "steps"}});

bool wants(const std::vector<std::string>& wanted, const std::string& layer)
{
    for (const auto& w : wanted)
        if (w == "all" || w == layer || (w == "direct" && layer.rfind("direct_", 0) == 0)) return true;
    return false;
}

std::unique_ptr<RayIntegrator> make_integrator(const PreparedScene& scene, const IntegratorOptions& options)
{
    switch (options.kind) {
    case Integrator::Cells: return make_cells_integrator(scene, options);
    case Integrator::Romberg: return make_romberg_integrator(scene, options);
    case Integrator::Steps: return make_steps_integrator(scene, options);
    }
    throw InputError("integrator: expected cells, romberg or steps");
}

/// Where the film keeps each layer, -1 where it does not.
struct Places {
    Places(const Film& film, const Scene& scene)
    {
        const auto place = [&](const std::string& name) {
            const int layer = film.find(name);
            return layer < 0 ? -1 : film.offset(layer);
        };
        beauty = place("");
        background = place("background");
        depth = place("Z");
        transmittance = place("transmittance");
        multiple = place("multiscatter");
        emission = place("emission");
        for (const auto& light : scene.lights) direct.push_back(place("direct_" + light.name));
    }
    int beauty, background, depth, transmittance, multiple, emission;
    std::vector<int> direct;
};

void put(double* out, int place, const Vec3d& value)
{
    if (place < 0) return;
    for (int c = 0; c < 3; ++c) out[place + c] = value[c];
}

void check(const IntegratorOptions& o)
{
    if (!(o.tolerance > 0)) throw InputError("tolerance " + std::to_string(o.tolerance) + ": expected > 0");
    if (!(o.step > 0)) throw InputError("step " + std::to_string(o.step) + ": expected > 0");
    if (o.parts < 1) throw InputError("parts " + std::to_string(o.parts) + ": expected 1 or more");
}

}  // namespace

const char* name(Integrator kind) { return kinds.word(kind); }

Integrator integrator_kind(const std::string& text) { return kinds.value(text); }

std::vector<LayerSpec> render_layers(const Scene& scene, const std::vector<std::string>& wanted)
{
    const std::vector<std::string> rgb{"R", "G", "B"};
    std::vector<LayerSpec> possible{{"Z", {"Z"}, false, Combine::Nearest},
                                    {"transmittance", rgb, false, Combine::Mean}};
    for (const auto& light : scene.lights) possible.push_back({"direct_" + light.name, rgb, true, Combine::Mean});
    possible.push_back({"multiscatter", rgb, true, Combine::Mean});
    possible.push_back({"emission", rgb, true, Combine::Mean});
    possible.push_back({"variance", {"Y"}, false, Combine::Mean});

    std::vector<LayerSpec> layers{{"", {"R", "G", "B", "A"}, true, Combine::Mean},
                                  {"background", rgb, true, Combine::Mean}};
    for (const auto& w : wanted) {
        bool known = w == "all" || w == "direct";
        for (const auto& p : possible) known = known || p.name == w;
        if (!known)
            throw UsageError("layer '" + printable(w) +
                             "': expected all, direct, direct_<light>, multiscatter, "
                             "emission, transmittance, Z or variance");
    }
    for (const auto& p : possible)
        if (wants(wanted, p.name)) layers.push_back(p);
    return layers;
}

RenderCost render_image(Film& film, const Scene& scene, const CameraView& view, const SamplingOptions& sampling,
                        const IntegratorOptions& options, const Progress& progress)
{
    check(options);
    const PreparedScene prepared(scene, options);
    const Places places(film, scene);
    std::atomic<uint64_t> rays{0}, cells{0}, unconverged{0};

    const SamplerFactory factory = [&]() -> SampleFunction {
        std::shared_ptr<RayIntegrator> integrate = make_integrator(prepared, options);
        auto result = std::make_shared<RayResult>();
        return [&, integrate, result](double x, double y, double* out) {
            const WorldRay ray = view.ray(x, y);
            (*integrate)(ray, *result);
            const Vec3d transmittance(std::exp(-result->tau[0]), std::exp(-result->tau[1]), std::exp(-result->tau[2]));
            Vec3d beauty = result->multiple + result->emission;
            for (size_t l = 0; l < result->direct.size(); ++l) {
                beauty += result->direct[l];
                put(out, places.direct[l], result->direct[l]);
            }
            put(out, places.beauty, beauty);
            if (places.beauty >= 0)
                out[places.beauty + 3] = 1 - (transmittance[0] + transmittance[1] + transmittance[2]) / 3;
            put(out, places.background, transmittance * scene.background.radiance(ray.direction));
            const Vec3d& tau = result->true_tau;
            put(out, places.transmittance, {std::exp(-tau[0]), std::exp(-tau[1]), std::exp(-tau[2])});
            put(out, places.multiple, result->multiple);
            put(out, places.emission, result->emission);
            if (places.depth >= 0)
                out[places.depth] = result->half_way < 1e30 ? view.depth(x, y, result->half_way) : 1e30;
            rays.fetch_add(1, std::memory_order_relaxed);
            cells.fetch_add(result->cells, std::memory_order_relaxed);
            if (!result->converged) unconverged.fetch_add(1, std::memory_order_relaxed);
        };
    };
    expose(film, sampling, factory, progress);
    return {rays, cells, unconverged};
}

}  // namespace vdbcloud
