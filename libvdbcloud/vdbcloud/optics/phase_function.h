#pragma once
// Phase functions: the distribution of scattered light over directions, and the table of available phase functions.
#include "vdbcloud/core/fwd.h"

#include <string>
#include <vector>

namespace vdbcloud {

/// A parameter of a phase function. A program's option for this parameter is "--" and the name.
struct PhaseParameter {
    const char* name;
    const char* meaning;  ///< for help texts
    double low, high;
    bool open;         ///< low and high are excluded
    double otherwise;  ///< default; NaN: no default, a value is required

    bool allows(double value) const;
    std::string range() const;  ///< "a number in (-1, 1)"
    std::string key() const;    ///< metadata key: "vdbcloud:g"
};

/// One lobe of a phase function, in Draine's form, c = cos_theta:
///
///     weight (1 - g^2) / (4 pi (1 + g^2 - 2 g c)^(3/2)) (1 + alpha c^2) / (1 + alpha (1 + 2 g^2) / 3)
///
/// alpha = 0 is Henyey-Greenstein, g = 0 and alpha = 1 Rayleigh, g = 0 and alpha = 0 isotropic scattering.
/// Source: Draine 2003, "Scattering by interstellar dust grains. I", equation 4.
struct PhaseLobe {
    double weight = 1, g = 0, alpha = 0;

    double value(double cos_theta) const;  ///< [1/sr], weight included
    double moment(int l) const;            ///< Legendre moment, weight included
    double sample(double u) const;         ///< cos_theta at which the lobe's cumulative distribution is u
};

/// One row of the table, which defines a phase function for the library and the programs. To add a phase function, add
/// a row in phase_table.cc.
struct PhaseForm {
    const char* name;     ///< in metadata and as a word of --phase
    const char* meaning;  ///< for help texts
    std::vector<PhaseParameter> parameters;
    /// The weights sum to 1.
    std::vector<PhaseLobe> (*lobes)(const std::vector<double>& parameters);
};

const std::vector<PhaseForm>& phase_table();
/// Throws InputError that lists the valid names.
const PhaseForm& phase_form(const std::string& name);

/// p(cos_theta) [1/sr], normalised: its integral over the sphere is 1.
///
/// Directions point along propagation and cos_theta = dot(w_in, w_out), so forward scattering is +1. Texts in
/// which both vectors point away from the scatterer write + 2 g cos instead of - 2 g cos.
///
/// A value type: copy it freely, share it between threads.
/// Source: Kajiya & Von Herzen 1984, section 2 (phase functions); Henyey & Greenstein 1941.
class PhaseFunction {
public:
    /// Isotropic.
    PhaseFunction() : PhaseFunction("isotropic") {}
    /// A row of the table, with parameters in the row's order. Missing parameters have their defaults. Throws
    /// InputError for an unknown name, a parameter out of range, too many parameters, or a missing parameter without
    /// default.
    explicit PhaseFunction(const std::string& name, std::vector<double> parameters = {});
    static PhaseFunction henyey_greenstein(double g) { return PhaseFunction("henyey-greenstein", {g}); }

    const char* name() const { return form_->name; }
    const PhaseForm& form() const { return *form_; }
    const std::vector<double>& parameters() const { return parameters_; }
    /// "henyey-greenstein, g 0.85"
    std::string text() const;

    double operator()(double cos_theta) const;

    /// Samples an outgoing direction (unit) for an incoming direction (unit). For u, v uniform in [0, 1) its density
    /// over the sphere is operator(). The cumulative distribution is inverted in closed form or by bracketed Newton
    /// steps.
    Vec3d sample(const Vec3d& incoming, double u, double v) const;

    /// The l-th Legendre moment, 2 pi int_-1^1 p(c) P_l(c) dc, l >= 0, in closed form: 1, then the mean cosine, ...
    /// (Henyey-Greenstein: g^l; Rayleigh: 1, 0, 1/10, 0, ...). The moment is the eigenvalue of the scattering
    /// operator on harmonics of degree l.
    double moment(int l) const;
    double mean_cosine() const { return moment(1); }
    /// A degree L such that |m_l| < `size` for all l >= L, at most 1e9; 0 < size < 1.
    int degree_below(double size) const;

    /// True for the same form and parameters equal to 1e-9 relative, as parameters may be converted to text and back.
    bool operator==(const PhaseFunction&) const;
    bool operator!=(const PhaseFunction& other) const { return !(*this == other); }

private:
    const PhaseForm* form_;
    std::vector<double> parameters_;
    std::vector<PhaseLobe> lobes_;
};

}  // namespace vdbcloud
