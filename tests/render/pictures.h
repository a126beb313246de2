#pragma once
// Scenes of a few voxels and pictures of one pixel, for the tests of layers.
#include "support/fields.h"
#include "vdbcloud/render/integrator.h"

#include <gtest/gtest.h>

namespace vdbcloud::test {

inline constexpr Integrator integrators[] = {Integrator::Cells, Integrator::Romberg, Integrator::Steps};

/// Fine enough for 1e-4 of a pixel: steps of 1/16 voxel of voxels of a tenth of a mean free path err by 1e-6 of the
/// source function, kinks included; Romberg's tolerance is 1e-6.
inline IntegratorOptions fine(Integrator kind)
{
    IntegratorOptions o;
    o.kind = kind;
    o.step = 1.0 / 16;
    o.tolerance = 1e-6;
    return o;
}

inline Medium medium(const Vec3d& sigma_t, const Vec3d& albedo, double g)
{
    Medium m;
    m.sigma_t_per_density = sigma_t;
    m.albedo = albedo;
    m.phase = PhaseFunction::henyey_greenstein(g);
    return m;
}

inline Volume volume_of(const FloatGridPtr& density, const Medium& m)
{
    Volume volume;
    volume.density = density;
    volume.medium = m;
    return volume;
}

/// One value wherever `like` is active.
template<typename Grid>
typename Grid::Ptr constant_like(const FloatGrid& like, const typename Grid::ValueType& value)
{
    auto grid = Grid::create(typename Grid::ValueType(0));
    grid->setTransform(like.transform().copy());
    for (auto v = like.cbeginValueOn(); v; ++v) grid->tree().setValueOn(v.getCoord(), value);
    return grid;
}

/// A view of one pixel along `direction` through `target`, from a distance of 100.
inline CameraView one_pixel(const Vec3d& target, const Vec3d& direction)
{
    Camera camera;
    camera.projection = Projection::Orthographic;
    camera.position = target - 100 * direction.unit();
    camera.look_at = target;
    camera.up = Vec3d(0.1, 1, 0.3);
    ImageSize size;
    size.width = size.height = 1;
    return {camera, size};
}

/// The layers of one pixel.
class Picture {
public:
    Picture(const Scene& scene, const CameraView& view, const IntegratorOptions& options)
        : film_(view.size(), render_layers(scene, {"all"}))
    {
        cost = render_image(film_, scene, view, {}, options);
    }
    double at(const std::string& layer, int channel) const
    {
        EXPECT_GE(film_.find(layer), 0) << layer;
        return film_.pixel(0, 0)[film_.offset(film_.find(layer)) + channel];
    }
    RenderCost cost;

private:
    Film film_;
};

/// A cube of 16 voxels of edge h, density 1: a ray along an axis through it has the density depth 16 h exactly.
inline FloatGridPtr cube(double h = 1)
{
    return box({16, 16, 16}, h, [](openvdb::Coord) { return 1.0; });
}

}  // namespace vdbcloud::test
