#pragma once
// The perturbation series in absorption: K + 1 solves with one conservative operator give phi at any albedo.
#include "vdbcloud/scatter/beam.h"

#include <string>
#include <vector>

namespace vdbcloud {

/// Relative residual of a series' solves, as the I_k are nearly parallel.
inline constexpr double series_tolerance = 1e-11;

struct SeriesOptions {
    int order = 8;              ///< K: I_0 .. I_K
    bool galerkin = false;      ///< the stable form; else partial sums
    double least_albedo = 0.8;  ///< lowest albedo of the table; partial sums: limited further by convergence
    int nodes = 33;
    SolveOptions solve;  ///< tolerance is series_tolerance at most
};

/// The expansion in beta = 1 - w0 of Kajiya & Von Herzen 1984, section 4: phi = sum beta^k I_k.
///
/// In P1, with the beams split off and f, the delta scaling, held fixed, order k has
///
///     div F_k = (1-f) sigma_t [a * u]_k - sigma_t phi_{k-1}
///     sigma_t (1-g) F_k + grad phi_k / 3 = (g-f) sigma_t (U_k - U_{k-1}) - g sigma_t F_{k-1}
///
/// u, U the beams' own series, E T0' (-f tau)^k / k! with T0' = exp(-(1-f) tau). I_{k-1} has a PLUS on the right side
/// of the paper's operator form: the printed minus gives the solution for w0 = 1 + beta.
///
/// The sum converges only for beta below the body's radius of convergence (for a slab about
/// pi^2 / (3 (1-g) (tau + 1.42/(1-g))^2)). A Galerkin solve on the span of the I_k does not diverge. Requires one
/// extinction per density and one albedo for all voxels.
struct AlbedoSeries {
    std::vector<std::vector<float>> basis;  ///< orthonormal in L2 over the voxels (sum of squares 1), per slot
    std::vector<double> map;                ///< I_k = sum_{j <= k} map[k * size + j] basis_j
    std::vector<double> norm;               ///< ||I_k||
    std::vector<double> albedo;             ///< nodes of the table, rising
    std::vector<double> table;              ///< coefficients of the basis, one row per node
    int iterations = 0;                     ///< total over all solves
    bool converged = true;

    size_t size() const { return basis.size(); }
    /// ||I_K|| / ||I_{K-1}||, an estimate of 1 / radius of convergence. Times beta: ratio of successive terms.
    double ratio() const { return norm.size() > 1 ? norm.back() / norm[norm.size() - 2] : 0; }
};

/// Sources: beams with depths in the true (unscaled) density and their irradiance; sky (as in add_sky()); emission.
struct SeriesSources {
    std::vector<std::pair<BeamDepths, double>> beams;
    std::array<double, 6> sky{};
    const std::vector<float>* emission = nullptr;
};

/// `medium` gives extinction, phase function and delta; its albedo is ignored. Throws InputError if it has a tint.
AlbedoSeries albedo_series(const VoxelIndex&, const std::vector<float>& density, const std::vector<ExposedVoxel>&,
                           const P1Medium& medium, const SeriesSources&, const SeriesOptions&);

/// Coefficients of the basis at albedo `at`, interpolated between the nodes of the table. Interpolation is barycentric
/// in the fourth root of 1 - w0, in which the coefficients are smooth. Throws InputError outside the table.
std::vector<double> series_coefficients(const std::vector<double>& albedo, const std::vector<double>& table, double at);

/// Partial sum of the series at one albedo, in coefficients of the basis.
std::vector<double> partial_sum(const AlbedoSeries&, double albedo);

}  // namespace vdbcloud
