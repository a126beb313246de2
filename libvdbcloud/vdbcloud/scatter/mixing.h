#pragma once
// Anderson acceleration: a fixed-point iteration that remembers its last few steps.
#include <cstddef>
#include <vector>

namespace vdbcloud {

/// Finds x = G(x) in fewer evaluations of G, and also where x <- G(x) grows.
///
/// With f_k = G(x_k) - x_k and differences D of one step to the next, the next state is
///
///     x_k+1 = G(x_k) - sum over j of c_j D g_j,    c the least squares of || f_k - sum over j of c_j D f_j ||
///
/// over the last `depth` differences. For affine G that is GMRES that forgets. What is affine in the state and holds
/// for each G(x_k) holds for x_k+1. Differences nearly in the span of newer ones are left out.
///
/// A state is the first `arrays` of some arrays of `length` values, which all count alike in the norm. Sums are in
/// double precision and in a fixed order, so that values do not depend on the number of threads. Source: Anderson 1965;
/// Walker & Ni 2011.
class Mixing {
public:
    using Arrays = std::vector<std::vector<float>>;

    Mixing(size_t length, size_t arrays, int depth);

    /// Notes x before G is applied to it.
    void before(const Arrays& x);
    /// Takes G(x). Returns the residual || G(x) - x || / || G(x) ||, 0 if both are 0.
    double after(const Arrays& g);
    /// Puts the next x in the place of what after() was given.
    void next(Arrays& g) const;

    size_t bytes() const { return bytes(length_, arrays_, depth_); }
    static size_t bytes(size_t length, size_t arrays, int depth) { return 4 * length * arrays * size_t(2 * depth + 3); }

private:
    double product(const Arrays& a, const Arrays& b) const;
    void subtract(const Arrays& a, Arrays& from_b) const;  // b = a - b
    std::vector<double> coefficients() const;

    size_t length_, arrays_;
    int depth_;
    Arrays x_, f_, g_;             // of this step, and of the one before
    std::vector<Arrays> df_, dg_;  // the newest first
};

}  // namespace vdbcloud
