#pragma once
// Reference solution of transport in a homogeneous plane-parallel slab, by adding and doubling.
#include <cstddef>
#include <vector>

namespace vdbcloud::test {

/// A slab of optical depth `tau` and albedo w0, lit at depth 0 by a beam. The phase function is given by
/// Henyey-Greenstein g or by Legendre moments. The beam has irradiance 1 (perpendicular to itself) and cosine mu0 to
/// the inward normal. All results are azimuthal means of collided radiance.
///
/// Discrete ordinates: `n` half-range Gauss points a hemisphere, and mu0 and `view` as points of weight zero. Thin
/// layers of optical depth below 1e-12 scatter once; they are doubled and added. Shares no code with the library.
/// Source: van de Hulst 1963; Hansen & Travis 1974, section 3.
class SlabExact {
    using size_t = std::size_t;

public:
    struct Options {
        double tau = 1, w0 = 1, g = 0, mu0 = 1;
        std::vector<double> view;  ///< cosines in (0, 1] of the view directions of emergent radiance
        int n = 24;
        /// m_0, m_1, ... of the phase function; moments after the last are 0. Empty: g^l. The quadrature uses the
        /// first 2 n moments.
        std::vector<double> moments{};
    };
    explicit SlabExact(const Options&);

    double reflected() const;    ///< diffuse flux that leaves at depth 0, for incident flux mu0
    double transmitted() const;  ///< diffuse flux that leaves at depth tau
    /// Radiance that leaves at depth 0 / tau along the k-th view cosine.
    double emergent_top(int k) const { return up_top_[size_t(n_ + 1 + k)]; }
    double emergent_bottom(int k) const { return down_bottom_[size_t(n_ + 1 + k)]; }
    /// Collided fluence and downward flux at a depth 0..tau.
    struct Inside {
        double phi, flux;
    };
    Inside at(double depth) const;
    /// Diffuse transmittance for isotropic radiance 1 / pi (incident flux 1), the unscattered part included.
    double transmitted_of_isotropic() const;
    /// Reflectance for the same light.
    double reflected_of_isotropic() const;

private:
    using Matrix = std::vector<double>;  // size_ x size_
    struct Layer {
        double tau;
        Matrix r, t;
    };
    Layer doubled_to(double tau) const;
    Layer add(const Layer& upper, const Layer& lower) const;
    Matrix product(const Matrix& a, const Matrix& b) const;
    /// S = (1 - Ra Rb)^-1 Ra Rb: light reflected any number of times between two layers. A series of squares, which
    /// converges at any optical depth, because the largest eigenvalue of Ra Rb is below 1.
    Matrix reflections(const Layer& upper, const Layer& lower) const;

    Options o_;
    int n_, size_;
    std::vector<double> mu_, w_;
    Matrix forward_, backward_;  // azimuthal mean of the phase function, of mean 1
    std::vector<double> up_top_, down_bottom_;
};

}  // namespace vdbcloud::test
