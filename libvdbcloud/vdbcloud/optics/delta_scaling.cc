#include "vdbcloud/optics/delta_scaling.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/refuse.h"
#include "vdbcloud/core/shortest.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/scatter_schema.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/optics/medium.h"

#include <cmath>

namespace vdbcloud {

namespace {

DeltaScaling scaled_by(double f, const PhaseFunction& phase, int degree)
{
    DeltaScaling scaling;
    scaling.degree = degree;
    scaling.delta_f = f;
    scaling.moments.assign(1, 1.0);
    for (int l = 1; l <= degree; ++l) scaling.moments.push_back((phase.moment(l) - f) / (1 - f));
    return scaling;
}

void check(int degree)
{
    if (degree < 1) throw InputError("degree " + std::to_string(degree) + ": expected 1 or more");
}

/// Degree, f and moments follow from the phase function, which the metadata hold too: throws InputError where one of
/// them is another solution's.
void require_own(const MetaMap& from, int degree, double f, const std::vector<double>& moments)
{
    if (!has_meta(from, schema::sigma_t_per_density)) return;  // no medium
    constexpr double rounding = 1e-9;
    const PhaseFunction phase = read_medium(from).phase;
    const double own = delta_scaling(phase, degree).delta_f;
    if (f != 0 && !(std::abs(f - own) <= rounding))
        throw InputError(meta_name(from, schema::delta_f) + " = " + shortest(f) + ": expected 0 or " + shortest(own) +
                         ", the forward peak of " + phase.name() + " at degree " + std::to_string(degree) +
                         "; run p1solve again");
    const std::vector<double> expected = scaled_by(f, phase, degree).moments;
    for (size_t l = 0; l < moments.size(); ++l)
        if (!(std::abs(moments[l] - expected[l]) <= rounding))
            throw InputError(meta_name(from, schema::scaled_moments) + ": moment " + std::to_string(l) + " is " +
                             shortest(moments[l]) + ": expected " + shortest(expected[l]) + " for " + phase.name() +
                             "; run p1solve again");
}

}  // namespace

int DeltaScaling::last_degree() const
{
    int last = 0;
    for (int l = 1; l <= degree; ++l)
        if (moments[size_t(l)] != 0) last = l;
    return last;
}

DeltaScaling delta_scaling(const PhaseFunction& phase, int degree)
{
    check(degree);
    double f = phase.moment(degree + 1);
    for (int l = 0; l <= degree; ++l)
        if (!(f > 0 && f <= phase.moment(l))) f = 0;
    return scaled_by(f, phase, degree);
}

DeltaScaling no_scaling(const PhaseFunction& phase, int degree)
{
    check(degree);
    return scaled_by(0, phase, degree);
}

DeltaScaling largest_of(const std::vector<DeltaScaling>& scalings)
{
    DeltaScaling all = scalings.at(0);
    all.delta_f = 0;
    for (const DeltaScaling& scaling : scalings)
        for (size_t l = 0; l < all.moments.size(); ++l)
            if (std::abs(scaling.moments[l]) > std::abs(all.moments[l])) all.moments[l] = scaling.moments[l];
    return all;
}

void write_delta_scaling(MetaMap& to, const DeltaScaling& scaling)
{
    set_number(to, schema::degree, scaling.degree);
    set_number(to, schema::delta_f, scaling.delta_f);
    set_numbers(to, schema::scaled_moments, scaling.moments);
}

DeltaScaling read_delta_scaling(const MetaMap& from, const PhaseFunction& phase)
{
    const double degree = get_number(from, schema::degree, 1), f = get_number(from, schema::delta_f, 0);
    DeltaScaling scaling = scaled_by(f, phase, int(degree));
    if (!has_meta(from, schema::scaled_moments)) return scaling;
    for (const char* key : {schema::degree, schema::delta_f})
        if (!has_meta(from, key))
            throw InputError(meta_name(from, key) + " is missing beside '" + schema::scaled_moments +
                             "': expected a number; run p1solve again");
    std::vector<double> moments = get_numbers(from, schema::scaled_moments);
    bool possible = moments.size() == size_t(scaling.degree) + 1 && moments[0] == 1;
    for (double m : moments) possible = possible && std::abs(m) <= 1;
    if (!possible)
        refuse(meta_name(from, schema::scaled_moments), get_text(from, schema::scaled_moments, ""),
               "1 and " + std::to_string(scaling.degree) + " numbers in [-1, 1]");
    require_own(from, scaling.degree, f, moments);
    scaling.moments = std::move(moments);
    return scaling;
}

}  // namespace vdbcloud
