#include "options.h"

#include "vdbcloud/core/error.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace vdbcloud::app {

namespace {

// What the options make in place of a cloud; known once they are parsed.
std::function<bool()> makes_mountain(const Options& o)
{
    return [&o] { return o.mountain; };
}
std::function<bool()> adds_detail(const Options& o)
{
    return [&o] { return !o.detail_from.empty(); };
}

void declare_noise(App& app, Options& o)
{
    const auto group = "Noise";
    const auto detail = adds_detail(o);
    const auto of_shape = [&](const Option& option) { return option.not_with(detail, "--detail-from").group(group); };
    app.add_option("--seed", o.seed, "number of the cloud; another seed makes another cloud of the same kind")
        ->group(group);
    of_shape(app.add_option(
                 "--beta", o.beta,
                 "power of the noise falls as (wave number)^-beta; without it 4.2, for a mountain 3.5. Smaller is "
                 "rougher"))
        ->check(within(0, 12));
    of_shape(app.add_option(
                 "--outer", o.outer,
                 "wave number below which the spectrum is flat [waves per longest side]; without it 4, for a mountain "
                 "0"))
        ->check(nonnegative);
    of_shape(app.add_option("--low-cut", o.spectrum.low_cut,
                            "leave out waves below this wave number [waves per longest side]; removes large lumps"))
        ->check(within(0, 256));
    of_shape(app.add_option("--high-cut", o.spectrum.high_cut,
                            "leave out waves above this wave number [waves per longest side]; removes fine detail"))
        ->check(positive);
    of_shape(app.add_vec3("--stretch", o.spectrum.stretch,
                          "features are so many times longer along x,y,z; 1,3,1 makes streaks along y"))
        ->check(within(0.01, 100));
}

/// Returns --envelope-from.
Option declare_envelope(App& app, Options& o, const char* group)
{
    const auto mountain = makes_mountain(o);
    const auto mask = [&o] { return !o.envelope_from.empty(); };
    const auto cumulus = [&o] { return o.envelope == Region::Cumulus && o.envelope_from.empty(); };
    const auto detail = adds_detail(o);
    app.add_choice<Region>("--envelope", o.envelope,
                           {{"cumulus", Region::Cumulus},
                            {"sphere", Region::Sphere},
                            {"ellipsoid", Region::Ellipsoid},
                            {"slab", Region::Slab},
                            {"box", Region::Box}},
                           "body that the cloud fills; slab: a layer over the whole bounds")
        ->not_with(mountain, "--mountain")
        ->not_with(mask, "--envelope-from")
        ->not_with(detail, "--detail-from")
        ->group(group);
    const Option from = app.add_option("--envelope-from", o.envelope_from,
                                       "fill the fog or level set of this .vdb instead of a body; - for standard input")
                            ->reads_files()
                            ->not_with(mountain, "--mountain")
                            ->not_with(detail, "--detail-from")
                            ->type_name("FILE")
                            ->group(group);
    app.add_option("--envelope-grid", o.mask_grid,
                   "grid of the --envelope-from file, NAME or NAME[k]; without it the density, else a level set")
        ->needs(from)
        ->group(group);
    const auto shapes_cumulus = [&](const Option& option) {
        return option.not_with(mountain, "--mountain")
            .not_with(detail, "--detail-from")
            .only_with(cumulus, "--envelope cumulus")
            .group(group);
    };
    shapes_cumulus(app.add_option("--towers", o.cumulus.towers, "number of rising columns of a cumulus"))
        ->check(within(1, 64));
    shapes_cumulus(app.add_option("--height", o.cumulus.height,
                                  "height of the tallest tower over the broader side of the footprint"))
        ->check(positive);
    shapes_cumulus(app.add_option("--generations", o.cumulus.generations,
                                  "levels of bulges upon bulges of a cumulus; each adds finer ones"))
        ->check(within(1, 4));
    return from;
}

/// Returns --envelope-from.
Option declare_shape(App& app, Options& o)
{
    const auto group = "Shape; lengths are fractions of the longest side";
    const auto mountain = makes_mountain(o);
    const Option from = declare_envelope(app, o, group);
    const auto detail = adds_detail(o);
    const auto of_cloud = [&](const Option& option) {
        return option.not_with(mountain, "--mountain").not_with(detail, "--detail-from").group(group);
    };
    of_cloud(app.add_option("--coverage", o.shape.coverage,
                            "fraction of the envelope that holds cloud; the noise decides where. Use it for broken "
                            "decks"))
        ->check(within(0, 1));
    of_cloud(app.add_option("--edge", o.shape.edge,
                            "width over which density rises from 0 to 1; larger is softer, at least 1.5 voxels"))
        ->check(within(0, 1));
    of_cloud(app.add_option("--roughness", o.shape.roughness,
                            "distance by which noise moves the surface, one standard deviation"))
        ->check(within(0, 10));
    of_cloud(app.add_option("--warp", o.shape.warp,
                            "distance by which noise displaces the envelope, one standard deviation; makes wisps"))
        ->check(within(0, 1));
    of_cloud(app.add_option("--billow", o.shape.billow,
                            "0: plain noise; 1: folded noise, round outwards and creased inwards"))
        ->only_with([&o] { return o.shape.roughness > 0; }, "--roughness above 0")
        ->check(within(0, 1));
    return from;
}

void declare_mountain(App& app, Options& o)
{
    const auto group = "Mountain";
    const auto mountain = makes_mountain(o);
    const auto of_mountain = [&](const Option& option) {
        return option.only_with(mountain, "--mountain").group(group);
    };
    app.add_flag("--mountain", o.mountain, "make a mountain, a level set named 'solid', instead of a cloud")
        ->not_with(adds_detail(o), "--detail-from")
        ->group(group);
    of_mountain(app.add_option("--relief", o.relief.relief,
                               "height from the lowest to the highest point over the longest horizontal side"))
        ->check(positive);
    of_mountain(app.add_option("--ridges", o.relief.ridges, "0: rolling land; 1: sharp ridges"))->check(within(0, 1));
    of_mountain(app.add_option("--peak", o.relief.peak,
                               "0: land as high at the edges as in the middle; 1: one mountain in the middle"))
        ->check(within(0, 1));
    of_mountain(app.add_option("--band", o.relief.half_width, "half the width of the level set's narrow band [voxels]"))
        ->check(within(1.5, 16));
}

/// Returns --detail-from.
Option declare_detail(App& app, Options& o)
{
    const auto group = "Detail for a simulation";
    const Option from =
        app.add_option("--detail-from", o.detail_from,
                       "give the density of this .vdb detail below its voxels: noise that moves with the grid vel, "
                       "and keeps the water of each voxel; - for standard input. Its other grids are passed on")
            ->reads_files()
            ->type_name("FILE")
            ->group(group);
    const auto of_detail = [&](const Option& option) { return option.needs(from).group(group); };
    of_detail(
        app.add_option("--detail-factor", o.detail.factor, "voxels along an edge of each voxel of the simulation"))
        ->check(within(2, 8));
    of_detail(app.add_option("--detail-amount", o.detail.amount,
                             "standard deviation of the logarithm of density where matter ends; less in even matter"))
        ->check(within(0, 3));
    of_detail(app.add_option("--detail-period", o.detail.period,
                             "seconds that a pattern of the noise lives; as long as the flow takes to distort a voxel"))
        ->check(within(1e-3, 1e9));
    o.detail_time = of_detail(app.add_option("--detail-time", o.detail.time,
                                             "time of the frame [s]; without it that of cloudsim, else 0"))
                        ->check(within(-1e9, 1e9))
                        ->default_str("");
    return from;
}

}  // namespace

void declare(App& app, Options& o)
{
    const auto detail = adds_detail(o);
    app.writes_grids();
    app.takes_frames(/*several_inputs=*/false);
    const Option input =
        app.add_option("input", o.input, ".vdb to add the grid to, or - for standard input; without it a new file")
            .not_with(detail, "--detail-from")
            .reads_files();
    app.add_option("-o,--output", o.output, ".vdb to write, or - for standard output")
        ->required()
        ->rewrites_file(FileKind::Grids);
    declare_noise(app, o);
    const Option from = declare_shape(app, o);
    app.reads_grids({input, from, declare_detail(app, o)});

    const auto space = "Space";
    app.add_option(
           "--size", o.size,
           "voxels along the longest side, or NX,NY,NZ; 1 to 512 each. Time and memory grow with the third power")
        ->not_with(detail, "--detail-from")
        ->group(space);
    app.add_option("--bounds", o.bounds,
                   "domain x0,y0,z0,x1,y1,z1 [world units]; without it 2 x 1.25 x 2, standing on the origin")
        ->not_with(detail, "--detail-from")
        ->group(space);
    app.add_choice<std::optional<UpAxis>>("--up", o.up_asked, up_axis_choices<std::optional<UpAxis>>(),
                                          "axis that points up; z for Blender, y for Houdini; without it that of the "
                                          "input or of --envelope-from, else y")
        ->default_str("")
        ->not_with(detail, "--detail-from")
        ->scene("medium")
        ->group(space);

    declare_mountain(app, o);
    declare_medium(app, o.medium, MediumSource::None);
    for (const Option& option : options_of(o.medium))
        option.not_with(makes_mountain(o), "--mountain").not_with(detail, "--detail-from");

    app.examples(
        {{"a cumulus cloud of a few seconds, and its picture",
          "fractalgen --size 96 -o cloud.vdb && render cloud.vdb --resolution 128 -o cloud.png"},
         {"a broken deck, four times as broad as high",
          "fractalgen --envelope slab --coverage 0.4 --size 96 --bounds -2,0,-2,2,1,2 -o deck.vdb"},
         {"a mountain beside the cloud, in one file", "fractalgen cloud.vdb --mountain --size 96 -o both.vdb"}});
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
    if (!(most <= 1e6 && most <= 1e4 * least))
        throw UsageError("--bounds " + o.bounds + ": expected sides of at most 1e6, at most 1e4 times each other");
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
