#pragma once
// The perturbation series in absorption: one conservative operator, K + 1 solves, and then any albedo.
#include "vdbcloud/scatter/beam.h"

#include <string>
#include <vector>

namespace vdbcloud {

struct SeriesOptions {
    int order = 8;              ///< K: I_0 .. I_K
    bool galerkin = false;      ///< the stable form; else partial sums
    double least_albedo = 0.8;  ///< the table reaches from here to 1 (partial sums: as far as they converge)
    int nodes = 33;
    SolveOptions solve;  ///< its tolerance is tightened to 1e-11: the I_k are nearly parallel
};

/// The expansion in beta = 1 - w0 of Kajiya & Von Herzen 1984, section 4: phi = sum beta^k I_k.
///
/// In P1, with the beams split off and f, the delta scaling, held fixed, order k has
///
///     div F_k = (1-f) sigma_t [a * u]_k - sigma_t phi_{k-1}
///     sigma_t (1-g) F_k + grad phi_k / 3 = (g-f) sigma_t (U_k - U_{k-1}) - g sigma_t F_{k-1}
///
/// u, U the beams' own series, E T0' (-f tau)^k / k! with T0' = exp(-(1-f) tau). PLUS I_{k-1} on the right side of the
/// paper's operator form: the printed minus gives the solution for w0 = 1 + beta. It converges only for beta below the
/// body's radius (for a slab about pi^2 / (3 (1-g) (tau + 1.42/(1-g))^2)); a Galerkin solve on the span of the same I_k
/// does not diverge. One extinction and one albedo for all voxels.
struct AlbedoSeries {
    std::vector<std::vector<float>> basis;  ///< orthonormal in L2 over the voxels (sum of squares 1), per slot
    std::vector<std::array<std::vector<float>, 3>>
        flux;                    ///< -D0 grad of each, cell means along index axes; empty for g' = 0
    std::vector<double> map;     ///< I_k = sum_{j <= k} map[k * size + j] basis_j
    std::vector<double> norm;    ///< ||I_k||
    std::vector<double> albedo;  ///< nodes of the table, rising
    std::vector<double> table;   ///< coefficients of the basis, one row a node
    int iterations = 0;          ///< of all solves
    bool converged = true;

    size_t size() const { return basis.size(); }
    /// ||I_K|| / ||I_{K-1}||: times beta, what each further order is of the one before; 1 / radius.
    double ratio() const { return norm.size() > 1 ? norm.back() / norm[norm.size() - 2] : 0; }
};

/// Lights with the depths of their beams in the true (unscaled) density, and their irradiance; sky (add_sky); emission.
struct SeriesSources {
    std::vector<std::pair<BeamDepths, double>> beams;
    std::array<double, 6> sky{};
    const std::vector<float>* emission = nullptr;
};

/// `medium` gives extinction, phase function and delta; its albedo is not looked at. Throws InputError with a tint.
AlbedoSeries albedo_series(const VoxelIndex&, const std::vector<float>& density, const std::vector<ExposedVoxel>&,
                           const P1Medium& medium, const SeriesSources&, const SeriesOptions&);

/// Coefficients of the basis at any albedo within the table, by interpolation between its nodes (barycentric in the
/// fourth root of 1 - w0, in which they are smooth). Throws InputError outside the table.
std::vector<double> series_coefficients(const std::vector<double>& albedo, const std::vector<double>& table, double at);

/// Partial sum of the series at one albedo, in coefficients of the basis.
std::vector<double> partial_sum(const AlbedoSeries&, double albedo);

}  // namespace vdbcloud
