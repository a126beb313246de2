#pragma once
// Anderson acceleration of a fixed-point iteration, with a limited history. Private to scatter/.
#include <cstddef>
#include <vector>

namespace vdbcloud {

/// Finds x = G(x) with fewer evaluations of G than x <- G(x), also where that plain iteration diverges.
///
/// With f_k = G(x_k) - x_k and differences D of one step to the next, the next state is
///
///     x_k+1 = G(x_k) - sum over j of c_j D g_j,    c the least squares of || f_k - sum over j of c_j D f_j ||
///
/// over the last `depth` differences. For affine G this is equivalent to GMRES with truncated history. Affine
/// constraints satisfied by every G(x_k) are preserved. A difference nearly in the span of newer differences is
/// skipped.
///
/// A state consists of `arrays` arrays of `length` values; further arrays are ignored. All values have equal weight in
/// the norm. Sums are in double precision and in a fixed order, so values do not depend on the number of threads.
/// Source: Anderson 1965; Walker & Ni 2011.
class Mixing {
public:
    using Arrays = std::vector<std::vector<float>>;

    Mixing(size_t length, size_t arrays, int depth);

    /// Frees the history. What after() returns does not depend on it.
    void forget();
    /// Stores x. Call before G is applied to x.
    void before(const Arrays& x);
    /// The residual that after() would return.
    double change(const Arrays& g) const;
    /// Stores G(x) and its difference to x. Returns the residual || G(x) - x || / || G(x) ||, 0 if both are 0.
    double after(const Arrays& g);
    /// Replaces G(x), as given to after(), by the next x.
    void next(Arrays& g) const;

    size_t bytes() const { return bytes(length_, arrays_, depth_); }
    static size_t bytes(size_t length, size_t arrays, int depth) { return 4 * length * arrays * size_t(2 * depth + 3); }

private:
    double product(const Arrays& a, const Arrays& b) const;
    void subtract(const Arrays& a, Arrays& from_b) const;  // b = a - b
    std::vector<double> coefficients() const;

    size_t length_, arrays_;
    int depth_;
    Arrays x_, f_, g_;             // of the current and the previous step
    std::vector<Arrays> df_, dg_;  // newest first
};

/// What sweeps of scattering of mean cosine `g` mix: the depth, and the number of arrays. phi alone for isotropic
/// scattering, else phi and the moments of degree 1. Higher moments follow within one or two sweeps.
inline int mixing_depth(double g) { return g == 0 ? 8 : 5; }
inline size_t mixed_arrays(double g) { return g == 0 ? 1 : 4; }

}  // namespace vdbcloud
