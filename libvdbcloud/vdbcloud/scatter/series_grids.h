#pragma once
// Stores the perturbation series as grids, from which render makes images at any albedo without another solve.
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/grid/sources.h"
#include "vdbcloud/scatter/multiple_scattering.h"
#include "vdbcloud/scatter/scatter_plan.h"
#include "vdbcloud/scatter/series.h"

namespace vdbcloud {

struct SeriesReport {
    std::vector<double> norm;  ///< ||I_k||
    double ratio = 0;          ///< ||I_K|| / ||I_{K-1}||
    Vec3d estimate{0, 0, 0};   ///< ratio x beta, per channel; the sum converges if below 1
    double least_albedo = 1;   ///< lowest albedo of the table
    int iterations = 0;
    bool converged = true;  ///< all solves
    Workload work;          ///< events of data/unit_costs.txt
};

/// Makes grids series_phi_0.. (float, orthonormal basis). With `raw` also series_I_0.., the I_k themselves. Metadata of
/// series_phi_0: the triangular map from basis to I_k, the table of coefficients over albedo, and the density, medium
/// and lights of the series.
///
/// One series serves all three channels. Throws InputError if the channels differ in extinction, in the proportions of
/// their lights, or in emission.
std::vector<GridBasePtr> series_p1(const FloatGrid& density, const Vec3SGrid* emission, const Medium&,
                                   const std::vector<Light>&, const ScatterOptions&, const SeriesOptions&, bool raw,
                                   SeriesReport&);

/// What series_p1() would do and hold, without doing so; ScatterPlan::voxels and directions stay 0. Exact but for the
/// number of the solver's iterations, and for orders that add nothing, which a run leaves out.
ScatterPlan series_plan(const FloatGrid& density, const Medium&, const std::vector<Light>&, const ScatterOptions&,
                        const SeriesOptions&, bool raw);

/// True if a file holds a series made from these grids, for this extinction and g, lit by these lights.
bool has_series(const GridFile&, const Sources&, const Medium&, const std::vector<Light>&);

/// The light at medium.albedo from a file's series of these grids: phi is the sum, and flux follows from it
/// (p1_light()). Sky, delta scaling and periods are the file's; of `options` rays_per_voxel and disc_samples count. The
/// report's residual and error estimate are those at this albedo, truncation included. Throws InputError if the albedo
/// is outside the table.
CollidedLight relight(const GridFile&, const FloatGrid& density, const Vec3SGrid* emission, const Medium& medium,
                      const std::vector<Light>&, ScatterOptions options, ScatterReport&);

}  // namespace vdbcloud
