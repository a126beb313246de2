#pragma once
// Media that repeat along x and z, and the same media as explicit tilings, for the tests of periodic pictures.
#include "render/pictures.h"
#include "support/fields.h"
#include "vdbcloud/light/transmittance_grid.h"

namespace vdbcloud::test {

inline constexpr std::array<bool, 3> xz{true, false, true};
inline const Vec3i period_voxels(16, 12, 16);

/// Calls f(x, y, z, i, k) for the voxels of copies first .. last along x and z, whose voxel of the first copy is x, y,
/// z; the medium is moved by `shift` voxels along x and z, cyclically.
template<typename F>
void for_each_tile(int first, int last, const Vec3i& shift, const F& f)
{
    for (int i = first * period_voxels[0]; i < (last + 1) * period_voxels[0]; ++i)
        for (int y = 0; y < period_voxels[1]; ++y)
            for (int k = first * period_voxels[2]; k < (last + 1) * period_voxels[2]; ++k)
                f(openvdb::Coord(((i - shift[0]) % 16 + 16) % 16, y, ((k - shift[2]) % 16 + 16) % 16),
                  openvdb::Coord(i, y, k));
}

/// A value of voxel c in 0.2 .. 1.
inline double noise(const openvdb::Coord& c, uint64_t seed)
{
    return 0.2 + 0.8 * uniform(hash_bits(seed, uint64_t(c[0]), uint64_t(c[1]), uint64_t(c[2])));
}

/// Which copies a scene holds, and how its medium is moved.
struct Tiles {
    int first = 0, last = 0;
    bool periodic = true;  ///< else the copies are all there is
    Vec3i shift{0, 0, 0};
};

/// A clumpy medium with colour, emission, phi, flux and moments of degree 2, whose values are random: what a picture
/// makes of them is to be the same, whatever they are. Lit by a sun from aside.
inline Scene periodic_scene(const Tiles& tiles, const Vec3d& sigma_t, double g)
{
    Scene scene;
    Volume v = volume_of(FloatGrid::create(0.0f), medium(sigma_t, Vec3d(0.9, 0.8, 0.7), g));
    v.colour = Vec3SGrid::create(Vec3f(1.0f));
    v.emission = Vec3SGrid::create(Vec3f(0.0f));
    const auto phi = Vec3SGrid::create(Vec3f(0.0f));
    v.collided.scaling = delta_scaling(v.medium.phase, 2);
    for (auto& flux : v.collided.flux) flux = Vec3SGrid::create(Vec3f(0.0f));
    for (auto& moments : v.collided.moments)
        for (int m = 0; m < 5; ++m) moments.push_back(FloatGrid::create(0.0f));
    for_each_tile(tiles.first, tiles.last, tiles.shift, [&](const openvdb::Coord& c, const openvdb::Coord& at) {
        const double clump = clumps(c, 4, 1);
        // Active everywhere at the base, so that the extent is the period.
        if (!(clump > 0) && c[1] > 0) return;
        v.density->tree().setValueOn(at, float(clump));
        const auto random = [&](uint64_t seed) {
            return Vec3f(float(noise(c, seed)), float(noise(c, seed + 1)), float(noise(c, seed + 2)));
        };
        v.colour->tree().setValueOn(at, random(10));
        if (c[0] % 3 == 0) v.emission->tree().setValueOn(at, 0.1f * random(20));
        phi->tree().setValueOn(at, random(30));
        for (size_t k = 0; k < 3; ++k) {
            v.collided.flux[k]->tree().setValueOn(at, 0.3f * random(40 + 10 * k));
            for (size_t m = 0; m < 5; ++m)
                v.collided.moments[k][m]->tree().setValueOn(at, 0.1f * float(noise(c, 100 + 5 * k + m)));
        }
    });
    v.collided.phi = phi;
    scene.volumes.push_back(v);
    scene.lights = {make_sun(Vec3d(0.5, 1, -0.3), Vec3d(2, 3, 5))};
    if (tiles.periodic) scene.periodic = xz;
    return scene;
}

/// Adds the light grids, by exact rays.
inline void add_light(Scene& scene)
{
    TransmittanceOptions o;
    o.fidelity = Fidelity::Exact;
    o.periodic = scene.periodic;
    for (Volume& v : scene.volumes)
        for (const Light& light : scene.lights)
            v.transmittance.push_back(transmittance_grid(*v.density, v.medium, light, o));
}

/// A layer of n voxels of density 1 and edge 1 / n along y, 8 voxels wide.
inline FloatGridPtr periodic_layer(int n)
{
    return box({8, n, 8}, 1.0 / n, [](openvdb::Coord) { return 1.0; });
}

}  // namespace vdbcloud::test
