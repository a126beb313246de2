#pragma once
// Sets of directions and weights for integrals over the sphere: the quadratures of the transport sweeps.
#include "vdbcloud/core/fwd.h"

#include <string>
#include <vector>

namespace vdbcloud {

enum class OrdinateKind {
    Product,        ///< azimuths x half-range Gauss in the polar cosine
    LevelSymmetric  ///< invariant under all 48 symmetries of the cube
};

const char* name(OrdinateKind);
OrdinateKind ordinate_kind(const std::string& name);  ///< Throws InputError with the names that there are.

/// Directions s_m (unit) and weights w_m > 0 (their sum is 4 pi): int f dOmega ~ sum w_m f(s_m).
struct Ordinates {
    OrdinateKind kind = OrdinateKind::Product;
    std::vector<Vec3d> direction;
    std::vector<double> weight;
    /// Integrals of Y_lm Y_l'm' are exact up to this degree of both, so that moments up to it are those of what is
    /// swept.
    int degree = 0;

    size_t count() const { return direction.size(); }
};

/// The smallest set with at least `count` directions that carries moments of `degree`.
///
/// Product: P points of Gauss-Legendre on mu in (0, 1), the same mirrored on (-1, 0), times A azimuths, half a step off
/// the axes; A = 2 P or 4 P, a multiple of 4, so 8, 16, 32, 64, 72, 128, 144, 200, 256, 288, ... directions. It carries
/// degree min(P, A/2) - 1 and is invariant under 16 of the cube's symmetries. A half-range rule knows that radiance at
/// a boundary is two functions, one for each side: in slabs it errs a third of what a full-range rule of the same count
/// does. `polar` is the index axis that mu is measured from. For a medium that is `layered` across it, where radiance
/// changes far more with mu than with azimuth, 4 P azimuths become 2 P with twice the polar points (from 128 directions
/// on): the same count and degree.
///
/// Level-symmetric: S_N sets with N(N+2) directions, N = 2 to 12; they carry degree 1, 2, 3, 4, 5, 5.
///
/// Throws InputError if count < 1, if degree is not 0..7, if `polar` is no axis, or if no set is large enough (Product
/// ends at 8192 directions), saying what there is. Source: Carlson & Lathrop 1968 (level-symmetric sets); Sykes 1951
/// (half-range Gauss).
Ordinates ordinates(OrdinateKind kind, int count, int degree, int polar = 1, bool layered = false);

/// Nodes on (-1, 1) and weights (their sum is 2) of the n-point Gauss-Legendre rule, n >= 1.
void gauss_legendre(int n, std::vector<double>& node, std::vector<double>& weight);

}  // namespace vdbcloud
