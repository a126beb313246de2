// The table of phase functions. A new phase function needs a row here and cases in tests/optics/phase_function_test.cc.
#include "vdbcloud/core/error.h"
#include "vdbcloud/optics/phase_function.h"

#include <cmath>
#include <limits>

namespace vdbcloud {

namespace {

using Lobes = std::vector<PhaseLobe>;
using Numbers = std::vector<double>;

constexpr double needed = std::numeric_limits<double>::quiet_NaN();

/// Mie scattering of visible light by water droplets of diameter d [micrometre], 5 to 50: a Henyey-Greenstein peak and
/// a Draine lobe.
/// Source: Jendersie & d'Eon 2023, "An Approximate Mie Scattering Function for Fog and Cloud Rendering", equations 4 to
/// 7.
Lobes droplet_lobes(double d)
{
    const double peak = std::exp(-0.0990567 / (d - 1.67154)), g = std::exp(-2.20679 / (d + 3.91029) - 0.428934),
                 alpha = std::exp(3.62489 - 8.29288 / (d + 5.52825)),
                 weight = std::exp(-0.599085 / (d - 0.641583) - 0.665888);
    return {{1 - weight, peak, 0}, {weight, g, alpha}};
}

}  // namespace

const std::vector<PhaseForm>& phase_table()
{
    static const std::vector<PhaseForm> table{
        {"isotropic",
         "the same in all directions",
         {},
         [](const Numbers&) {
             return Lobes{{1, 0, 0}};
         }},
        {"rayleigh",
         "air, and particles far smaller than the wavelength",
         {},
         [](const Numbers&) {
             return Lobes{{1, 0, 1}};
         }},
        {"henyey-greenstein",
         "one lobe of mean cosine g",
         {{"g", "mean cosine of Henyey-Greenstein", -1, 1, true, 0}},
         [](const Numbers& p) {
             return Lobes{{1, p[0], 0}};
         }},
        {"double-henyey-greenstein",
         "two lobes, for example one forward and one backward",
         {{"g1", "mean cosine of the first lobe of double Henyey-Greenstein", -1, 1, true, needed},
          {"g2", "mean cosine of the second lobe of double Henyey-Greenstein", -1, 1, true, needed},
          {"g1-weight", "weight of the first lobe of double Henyey-Greenstein", 0, 1, false, needed}},
         [](const Numbers& p) {
             return Lobes{{p[2], p[0], 0}, {1 - p[2], p[1], 0}};
         }},
        {"hg-draine",
         "water droplets of fog and cloud",
         {{"droplet-diameter", "diameter of the droplets of hg-draine [micrometre]", 5, 50, false, needed}},
         [](const Numbers& p) { return droplet_lobes(p[0]); }}};
    return table;
}

const PhaseForm& phase_form(const std::string& name)
{
    std::string names;
    for (const PhaseForm& form : phase_table()) {
        if (name == form.name) return form;
        names += (names.empty() ? "" : ", ") + std::string(form.name);
    }
    throw InputError("phase function '" + printable(name) + "': expected one of " + names);
}

}  // namespace vdbcloud
