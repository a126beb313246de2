#pragma once
// Pass two of Kajiya & Von Herzen 1984: what a camera sees of media, given the light that reaches each point.
#include "vdbcloud/core/effects.h"
#include "vdbcloud/core/progress.h"
#include "vdbcloud/optics/collided_light.h"
#include "vdbcloud/optics/medium.h"
#include "vdbcloud/render/film.h"
#include "vdbcloud/render/passes.h"
#include "vdbcloud/scene/camera.h"
#include "vdbcloud/scene/ground.h"
#include "vdbcloud/scene/light.h"
#include "vdbcloud/scene/sky.h"
#include "vdbcloud/scene/solid.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdbcloud {

/// One medium of the scene, as its file gives it. Grids may differ in transform.
struct Volume {
    FloatGridPtr density;   ///< never null; may be empty
    Medium medium;          ///< sigma_t_per_density chosen
    Vec3SGridPtr colour;    ///< Cd: albedo tint, multiplies medium.albedo; may be null
    Vec3SGridPtr emission;  ///< radiance per world unit; may be null
    /// One for each light of the scene, in the scene's order: exp(-tau) towards the light through ALL volumes of the
    /// scene, float or vec3s, at the active voxels of THIS density and one voxel about them. Only light that this
    /// volume scatters is attenuated by these grids, so values elsewhere mean nothing.
    std::vector<GridBasePtr> transmittance;
    /// What p1solve adds; without phi there is none. Where its scaling's f is not 0 the image is formed in the medium
    /// of extinction (1 - f albedo) sigma_t, and `transmittance` must belong to that medium.
    CollidedLight collided;
};

/// What is to be rendered.
struct Scene {
    std::vector<Volume> volumes;  ///< coefficients add where they overlap
    std::vector<Light> lights;    ///< unit directions; names are unique
    Sky background;               ///< seen behind the media; does not light them
    Sky sky;                      ///< lights the media, for Integrator::Path alone, and solids; black: no sky
    /// Index axes along which the media repeat without end, at most two. Each volume repeats by the rule of
    /// period_of(); volumes have equal periods in world space. Lights are at infinity, and not along these axes.
    std::array<bool, 3> periodic{false, false, false};
    /// Beneath all matter; none: light that leaves the media downwards is lost. Lights are above it.
    std::optional<Ground> ground;
    /// What the ground sends upwards, for all integrators but Path: radiance at the voxels of the layer on the ground,
    /// interpolated along the layer, and repeated as the media are. Beyond the grid the ground has its background.
    Vec3SGridPtr ground_radiance;
    /// End rays and shadow the media: `transmittance` is that of light which solids do not hide. What lies within a
    /// solid is not seen.
    std::vector<Solid> solids;
};

enum class Integrator {
    Cells,    ///< exact optical depth per cell of the trilinear interpolant, sparse traversal
    Romberg,  ///< the paper's: adaptive, to a tolerance
    Steps,    ///< midpoint rule with a fixed step
    Path,     ///< unbiased light paths in the true medium, by Monte Carlo: see path.h
};

const char* name(Integrator);
Integrator integrator_kind(const std::string& name);  ///< Throws InputError with the names that there are.

struct IntegratorOptions {
    Integrator kind = Integrator::Cells;
    double tolerance = 1e-4;   ///< Romberg: absolute, of a pixel's radiance relative to its largest source, > 0
    double step = 0.5;         ///< Steps: [voxel edge], > 0
    int parts = 1;             ///< Cells: steps of fourth order a cell is cut into, >= 1
    bool plain_path = true;    ///< Cells: use the faster rule of plain_cells.h where it applies
    bool shadow_rays = false;  ///< find the light at each point by a ray of its own: slow, and free of light grids
    /// Path: paths have at most so many vertices, >= 2, and their last ray sees the picture of Integrator::Cells, which
    /// needs transmittance grids and collided light: less noise, and a bias. 0: whole paths.
    int vertices = 0;
    /// All but Path: rays over the directions above a point of a solid, by which its irradiance from media, sky and
    /// other solids is found; light from suns and lamps is found apart. The noise falls as the square root.
    int solid_rays = 16;
    PassOptions passes;  ///< Path: which samples, and how many; all: the time limit, and how the picture is shown
};

/// The layers render_image fills, for a scene, in the order of the film:
///
///     ""               R G B A  premultiplied, WITHOUT the background; A = 1 - mean of T over r, g, b
///     "background"     R G B    background seen through the medium, T L_sky: picture = RGB + background, per sample.
///                               None where the ray meets the ground or a solid; A is 1 there
///     "sky"            R G B    the same of the sky that lights the media; see certificate.h
///     "Z"              Z        depth along the view axis at which the mean T of the ray falls to 0.5; 1e30 if it does not
///     "transmittance"  R G B    T of the whole ray, without delta scaling; alpha and background use the scaled one
///     "direct_<light>" R G B    light scattered once
///     "multiscatter"   R G B    from phi and flux; Path: light scattered more than once, and the sky's scattered light
///     "emission"       R G B    not scattered
///     "ground"         R G B    from the ground, not scattered in the media; only where the scene has a ground
///     "solid"          R G B    from solids, not scattered in the media; only where the scene has solids
///     "variance"       Y        made by expose()
///     "standard_error" R G B    Path alone: see passes.h
///     "seconds"        Y        Path alone: see passes.h
///
/// RGB = sum of direct_* + multiscatter + emission + ground + solid. "" and "background" always; the others if they are
/// in `wanted`
/// ("direct" stands for the layers of all lights, "all" for every layer but seconds, which depends on the clock).
/// Path's layers are stored as float, so that pictures of different samples merge without loss. Throws UsageError
/// naming what is not in this list.
std::vector<LayerSpec> render_layers(const Scene&, const std::vector<std::string>& wanted,
                                     Integrator = Integrator::Cells);

/// Work of a rendering.
struct RenderCost {
    uint64_t rays = 0;         ///< of the camera and from solids
    uint64_t cells = 0;        ///< cells (or steps, or evaluations) visited; Path: collisions
    uint64_t lit = 0;          ///< Cells: of these, parts that are not hidden by an opaque medium before them
    uint64_t ends = 0;         ///< Path with `vertices`: last rays of paths
    uint64_t end_cells = 0;    ///< cells that last rays cross; `lit` is of these
    uint64_t unconverged = 0;  ///< Romberg: rays that reached the finest level before the tolerance
    PassReport passes;         ///< Path: samples of each pixel, and the noise that they leave
    CoarseReport coarse;       ///< others, with a time limit or a picture that is shown: how far they came
    EffectCosts costs;         ///< of the effects; Path: of the grids that rays read alone
};

/// Fills the film, whose layers are those of render_layers(). The film's window and size are the view's.
/// A ray in a periodic medium ends where its optical depth exceeds 45, or after 100000 periods: an error of the picture
/// below 1e-19 of its brightest source, and below 1e-5 of light from thin media along rays as near to the horizon.
/// Deterministic for any number of threads. Path without `vertices` reads density, colour, emission, lights and sky
/// only: no light grids, no collided light, no scaling. Throws InputError on grids that do not fit together,
/// ConvergenceError on a value that is not finite, Cancelled.
RenderCost render_image(Film&, const Scene&, const CameraView&, const SamplingOptions&, const IntegratorOptions&,
                        const Progress& = {});

}  // namespace vdbcloud
