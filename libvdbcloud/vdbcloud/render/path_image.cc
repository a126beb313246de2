#include "vdbcloud/render/path_image.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/render/layer_places.h"
#include "vdbcloud/render/path.h"
#include "vdbcloud/render/scene_costs.h"

#include <atomic>
#include <memory>

namespace vdbcloud {

RenderCost render_paths(Film& film, const Scene& scene, const CameraView& view, const SamplingOptions& sampling,
                        const IntegratorOptions& options, const Progress& progress)
{
    const PathScene prepared(scene);
    const std::unique_ptr<PathEndScene> end = options.vertices > 0 ? std::make_unique<PathEndScene>(scene) : nullptr;
    const LayerPlaces places(film, scene);
    const PixelFilter filter(sampling);
    std::atomic<uint64_t> rays{0}, collisions{0}, ends{0}, end_cells{0}, lit{0};

    const IndexedSampleFactory factory = [&]() -> IndexedSample {
        auto trace = std::make_shared<PathTracer>(prepared, end.get(), options.vertices);
        // Depth is that of the integrator that knows the medium without its light.
        std::shared_ptr<RayIntegrator> march;
        if (places.depth >= 0) march = make_cells_integrator(prepared.media, IntegratorOptions());
        auto result = std::make_shared<RayResult>(), depth = std::make_shared<RayResult>();
        return [&, trace, march, result, depth](int i, int j, uint64_t k, double* out) {
            PathRandom random(sampling.seed, i, j, k);
            const double u = random.next(), v = random.next();
            const double x = i + 0.5 + filter.inverse_cumulative(u), y = j + 0.5 + filter.inverse_cumulative(v);
            const WorldRay ray = view.ray(x, y);
            (*trace)(ray, random, *result);
            if (march) {
                (*march)(ray, *depth);
                result->half_way = depth->half_way;
            }
            places.put(*result, view, scene.background, x, y, ray.direction, out);
            rays.fetch_add(1, std::memory_order_relaxed);
            collisions.fetch_add(result->cells, std::memory_order_relaxed);
            if (!end) return;
            ends.fetch_add(result->ends, std::memory_order_relaxed);
            end_cells.fetch_add(result->end_cells, std::memory_order_relaxed);
            lit.fetch_add(result->lit, std::memory_order_relaxed);
        };
    };
    const PassReport report = expose_in_passes(film, sampling, options.passes, factory, progress);
    return {rays, collisions, lit, ends, end_cells, 0, report, {}, costs_of(scene, prepared.media, rays, collisions)};
}

}  // namespace vdbcloud
