#include "options.h"

#include "vdbcloud/core/error.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud::app {

namespace {

void declare_noise(App& app, Options& o)
{
    const auto group = "Noise";
    app.add_option("--seed", o.seed, "chooses one of 2^64 clouds")->group(group);
    app.add_option("--beta", o.beta,
                   "mean power of a wave falls as its wave number to -beta; else 4.2, a mountain's 3.5")
        ->check(within(0, 12))
        ->group(group);
    app.add_option("--outer", o.outer,
                   "wave number below which the spectrum is flat [per longest side]; else 4, a mountain's 0")
        ->check(nonnegative)
        ->group(group);
    app.add_option("--low-cut", o.spectrum.low_cut, "leave out waves below this wave number [per longest side]")
        ->check(within(0, 256))
        ->group(group);
    app.add_option("--high-cut", o.spectrum.high_cut, "leave out waves above this wave number [per longest side]")
        ->check(positive)
        ->group(group);
    app.add_vec3("--stretch", o.spectrum.stretch, "how many times longer features are along x,y,z")
        ->check(within(0.01, 100))
        ->group(group);
}

void declare_shape(App& app, Options& o)
{
    const auto group = "Shape; lengths are fractions of the longest side";
    app.add_choice<Region>("--envelope", o.envelope,
                           {{"cumulus", Region::Cumulus},
                            {"sphere", Region::Sphere},
                            {"ellipsoid", Region::Ellipsoid},
                            {"slab", Region::Slab},
                            {"box", Region::Box}},
                           "what the cloud fills")
        ->group(group);
    app.add_option("--envelope-from", o.envelope_from,
                   "fill the fog or level set of this .vdb instead; - for standard input")
        ->group(group);
    app.add_option("--envelope-grid", o.mask_grid, "which grid of that file: NAME or NAME[k]")->group(group);
    app.add_option("--towers", o.cumulus.towers, "towers of a cumulus")->check(within(1, 64))->group(group);
    app.add_option("--height", o.cumulus.height, "of a cumulus, over the broader side of its footprint")
        ->check(positive)
        ->group(group);
    app.add_option("--generations", o.cumulus.generations, "of bulges upon bulges of a cumulus")
        ->check(within(1, 4))
        ->group(group);
    app.add_option("--coverage", o.shape.coverage, "fraction of the envelope to fill, by a threshold of the noise")
        ->check(within(0, 1))
        ->group(group);
    app.add_option("--edge", o.shape.edge, "width of the edge, from no density to 1")
        ->check(within(0, 1))
        ->group(group);
    app.add_option("--roughness", o.shape.roughness, "how far noise moves the surface")
        ->check(within(0, 10))
        ->group(group);
    app.add_option("--warp", o.shape.warp, "how far noise displaces the envelope: wisps")
        ->check(within(0, 1))
        ->group(group);
    app.add_option("--billow", o.shape.billow, "0: plain noise, 1: round outwards and creased inwards")
        ->check(within(0, 1))
        ->group(group);
}

void declare_mountain(App& app, Options& o)
{
    const auto group = "Mountain";
    app.add_flag("--mountain", o.mountain, "a mountain as a level set named 'solid', instead of a cloud")->group(group);
    app.add_option("--relief", o.relief.relief,
                   "from its lowest to its highest point, over the longest horizontal side")
        ->check(positive)
        ->group(group);
    app.add_option("--ridges", o.relief.ridges, "0: rolling land, 1: sharp ridges")->check(within(0, 1))->group(group);
    app.add_option("--peak", o.relief.peak, "0: as high at the edges as in the middle, 1: one mountain")
        ->check(within(0, 1))
        ->group(group);
    app.add_option("--band", o.relief.half_width, "half the width of the level set's narrow band [voxels]")
        ->check(within(1.5, 16))
        ->group(group);
}

}  // namespace

void declare(App& app, Options& o)
{
    app.reads_grids();
    app.writes_grids();
    app.add_option("input", o.input, "a .vdb to add the grid to, or - for standard input; without it a new file");
    app.add_option("-o,--output", o.output, "output .vdb, or - for standard output")->required();
    declare_noise(app, o);
    declare_shape(app, o);

    const auto space = "Space";
    app.add_option("--size", o.size, "voxels along the longest side, or NX,NY,NZ; at most 512 each")->group(space);
    app.add_option("--bounds", o.bounds,
                   "x0,y0,z0,x1,y1,z1 in world units; else two units broad, 1.25 high, standing on the origin")
        ->group(space);
    app.add_choice<UpAxis>("--up", o.up, {{"y", UpAxis::Y}, {"z", UpAxis::Z}}, "axis that points up")->group(space);

    declare_mountain(app, o);
    const auto medium = "Medium, written for later stages if given";
    o.extinction = app.add_rgb("--extinction", o.medium.sigma_t_per_density,
                               "sigma_t at density 1 [1/world unit], one number or r,g,b")
                       ->check(positive)
                       ->default_str("")
                       ->group(medium);
    o.albedo = app.add_rgb("--albedo", o.medium.albedo, "share of extinguished light that is scattered")
                   ->check(within(0, 1))
                   ->default_str("")
                   ->group(medium);
    o.g = app.add_option("--g", o.medium.g, "mean cosine of Henyey-Greenstein")
              ->check(within(-0.999999, 0.999999))
              ->default_str("")
              ->group(medium);
}

Box default_bounds(const Options& o)
{
    Box box{{-1, -1, -1}, {1, 1, 1}};
    box.low[index_of(o.up)] = 0;
    box.high[index_of(o.up)] = 1.25;
    return box;
}

namespace {

Box bounds_of(const Options& o)
{
    const auto n = numbers(o.bounds);
    if (!n || n->size() != 6) throw UsageError("--bounds " + o.bounds + ": expected six numbers x0,y0,z0,x1,y1,z1");
    const Box box{{(*n)[0], (*n)[1], (*n)[2]}, {(*n)[3], (*n)[4], (*n)[5]}};
    const Vec3d sides = box.sides();
    const double least = std::min({sides[0], sides[1], sides[2]}), most = std::max({sides[0], sides[1], sides[2]});
    if (!(least > 0)) throw UsageError("--bounds " + o.bounds + ": expected x0 < x1, y0 < y1, z0 < z1");
    if (!(most <= 1e6 && least >= 1e-6 && most <= 1e4 * least))
        throw UsageError("--bounds " + o.bounds + ": expected sides in 1e-6..1e6, at most 1e4 times each other");
    return box;
}

int voxels(const Options& o, double n)
{
    if (n != std::floor(n) || n < 1 || n > 512)
        throw UsageError("--size " + o.size + ": expected N or NX,NY,NZ, whole numbers in 1..512");
    return int(n);
}

}  // namespace

Domain domain_of(const Options& o, const Box& otherwise)
{
    Domain domain{o.bounds.empty() ? otherwise : bounds_of(o), {}};
    const auto n = numbers(o.size);
    if (!n || (n->size() != 1 && n->size() != 3))
        throw UsageError("--size " + o.size + ": expected N or NX,NY,NZ, whole numbers in 1..512");
    if (n->size() == 3) {
        domain.size = {voxels(o, (*n)[0]), voxels(o, (*n)[1]), voxels(o, (*n)[2])};
        return domain;
    }
    const Vec3d sides = domain.box.sides();
    const double h = std::max({sides[0], sides[1], sides[2]}) / voxels(o, (*n)[0]);
    for (int d = 0; d < 3; ++d) {
        domain.size[d] = std::max(1, int(std::ceil(sides[d] / h - 1e-6)));
        domain.box.high[d] = domain.box.low[d] + domain.size[d] * h;
    }
    return domain;
}

}  // namespace vdbcloud::app
