#include "vdbcloud/scatter/collided_grids.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/optics/spherical_harmonics.h"

namespace vdbcloud {

namespace {

void add_moments(const VoxelIndex& index, const std::array<Solution, 3>& solutions, const std::array<Share, 3>& shares,
                 int degree, const std::function<void(GridBase&)>& stamp, ScatterFields& fields)
{
    const bool shared = shares[1].of == 0 && shares[2].of == 0;
    if (shared) fields.moment_scale = {shares[0].scale, shares[1].scale, shares[2].scale};
    for (int c = 0; c < (shared ? 1 : 3); ++c)
        for (int l = 2; l <= degree; ++l)
            for (int m = -l; m <= l; ++m) {
                std::vector<float> moment = solutions[shares[c].of].moments[size_t(harmonic(l, m))];
                const double scale = shared ? 1 : shares[c].scale;
                for (float& value : moment) value = float(scale * value);
                const auto grid = index.to_grid(moment.data(), schema::moment_name(l, m, shared ? -1 : c));
                stamp(*grid);
                if (shared) set_vector(*grid, schema::channel_scale, fields.moment_scale);
                fields.moments[c].push_back(grid);
            }
    if (shared) fields.moments[1] = fields.moments[2] = fields.moments[0];
}

}  // namespace

ScatterFields collided_grids(const VoxelIndex& index, const std::array<Solution, 3>& solutions,
                             const std::array<Share, 3>& shares, int degree,
                             const std::function<void(GridBase&)>& stamp)
{
    ScatterFields fields;
    const auto phi = [&](int c) { return solutions[shares[c].of].phi.data(); };
    fields.phi =
        index.to_grid({phi(0), phi(1), phi(2)}, schema::phi, Vec3d(shares[0].scale, shares[1].scale, shares[2].scale));
    stamp(*fields.phi);
    for (int c = 0; c < 3; ++c) {
        const auto& flux = solutions[shares[c].of].flux;
        fields.flux[c] = index.to_grid({flux[0].data(), flux[1].data(), flux[2].data()}, schema::flux_name(c),
                                       Vec3d(shares[c].scale));
        fields.flux[c]->setVectorType(openvdb::VEC_CONTRAVARIANT_RELATIVE);
        stamp(*fields.flux[c]);
    }
    add_moments(index, solutions, shares, degree, stamp, fields);
    return fields;
}

}  // namespace vdbcloud
