#pragma once
// The perturbation series as grids in a file, from which an image at any albedo is made without another solve.
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/scatter/multiple_scattering.h"
#include "vdbcloud/scatter/series.h"

namespace vdbcloud {

struct SeriesReport {
    std::vector<double> norm;  ///< ||I_k||
    double ratio = 0;          ///< ||I_K|| / ||I_{K-1}||
    Vec3d estimate{0, 0, 0};   ///< ratio x beta, per channel: the sum converges below 1
    double least_albedo = 1;   ///< where the table ends
    int iterations = 0;
    bool converged = true;  ///< the solves
};

/// Grids series_phi_0.. (float, orthonormal basis), series_flux_0.. (vec3s, -D0 grad of each; where g' is not 0), and
/// with `raw` series_I_0.., the I_k themselves. The first bears as metadata the triangular map from basis to I_k, the
/// table of coefficients over albedo, and what the series belongs to.
///
/// Throws InputError where the channels differ in extinction, in the proportions of their lights, or in emission:
/// one series serves all three.
std::vector<GridBasePtr> series_p1(const FloatGrid& density, const Vec3SGrid* emission, const Medium&,
                                   const std::vector<Light>&, const ScatterOptions&, const SeriesOptions&, bool raw,
                                   SeriesReport&);

/// True if a file holds a series for this density, extinction and g, lit by these lights.
bool has_series(const GridFile&, const FloatGrid& density, const Medium&, const std::vector<Light>&);

/// phi and flux at medium.albedo from a file's series. `transmittance`: exp(-tau') towards each light in the scaled
/// medium OF THAT ALBEDO, float or vec3s, for the beams' part of the flux, F = -D grad phi + w0' g' / (1 - w0' g') E T'
/// s, shortened as limit_flux() does. Throws InputError where the albedo is outside the table.
ScatterFields relight(const GridFile&, const Medium& medium, const std::vector<Light>&,
                      const std::vector<GridBasePtr>& transmittance);

}  // namespace vdbcloud
