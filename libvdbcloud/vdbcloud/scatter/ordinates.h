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
OrdinateKind ordinate_kind(const std::string& name);  ///< Throws InputError that lists the valid names.

/// Directions s_m (unit) and weights w_m > 0 (their sum is 4 pi): int f dOmega ~ sum w_m f(s_m).
struct Ordinates {
    OrdinateKind kind = OrdinateKind::Product;
    std::vector<Vec3d> direction;
    std::vector<double> weight;
    /// Integrals of Y_lm Y_l'm' are exact for l, l' up to this degree, so moments up to this degree are exact.
    int degree = 0;

    size_t count() const { return direction.size(); }
};

/// The smallest set with at least `count` directions whose Ordinates::degree is at least `degree`.
///
/// Product: P Gauss-Legendre points on mu in (0, 1) and their mirror images on (-1, 0), times A azimuths, offset from
/// the axes by half a step. A = 2 P or 4 P, a multiple of 4: 8, 16, 32, 64, 72, 128, 144, 200, 256, 288, ...
/// directions. The set's degree is min(P, A/2) - 1. The set is invariant under 16 of the cube's symmetries. Radiance at
/// a boundary is discontinuous at mu = 0, which a half-range rule respects: in slabs its error is a third of the error
/// of a full-range rule with as many directions.
///
/// `polar` is the index axis from which mu is measured. Set `layered` for a medium layered across this axis, in which
/// radiance varies far more with mu than with azimuth. From 128 directions on, 4 P azimuths then become 2 P azimuths
/// with twice the polar points; count and degree stay equal.
///
/// Level-symmetric: S_N sets with N(N+2) directions, N = 2 to 12, of degree 1, 2, 3, 4, 5, 5.
///
/// Throws InputError if count < 1, if degree is outside 0..7, if `polar` is not an axis, or if no set is large enough
/// (the largest product set has 8192 directions). The message lists the sets that exist. Source: Carlson & Lathrop 1968
/// (level-symmetric sets); Sykes 1951 (half-range Gauss).
Ordinates ordinates(OrdinateKind kind, int count, int degree, int polar = 1, bool layered = false);

/// Nodes on (-1, 1) and weights (their sum is 2) of the n-point Gauss-Legendre rule, n >= 1.
void gauss_legendre(int n, std::vector<double>& node, std::vector<double>& weight);

}  // namespace vdbcloud
