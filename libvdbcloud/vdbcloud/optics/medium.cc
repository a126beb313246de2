#include "vdbcloud/optics/medium.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/refuse.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"

#include <cmath>

namespace vdbcloud {

namespace {

/// Throws unless every channel is in the range that files may have.
void check_channels(const char* key, const Vec3d& value)
{
    const schema::Range range = schema::meta_key(key)->range;
    for (int c = 0; c < 3; ++c)
        if (!range.holds(value[c])) refuse(key, value, range.text(3));
}

void check(const Medium& medium)
{
    check_channels(schema::sigma_t_per_density, medium.sigma_t_per_density);
    check_channels(schema::albedo, medium.albedo);
}

}  // namespace

bool Medium::grey() const
{
    return sigma_t_per_density[0] == sigma_t_per_density[1] && sigma_t_per_density[1] == sigma_t_per_density[2];
}

PhaseFunction read_phase(const MetaMap& from, const PhaseFunction& otherwise)
{
    const PhaseForm& form = phase_form(get_text(from, schema::phase, otherwise.name()));
    std::vector<double> parameters;
    for (size_t k = 0; k < form.parameters.size(); ++k) {
        const PhaseParameter& parameter = form.parameters[k];
        const bool same = &form == &otherwise.form();
        const double value = get_number(from, parameter.key(), same ? otherwise.parameters()[k] : parameter.otherwise);
        if (std::isnan(value))
            throw InputError("phase function " + std::string(form.name) + " without " + parameter.key() +
                             ": expected " + parameter.range());
        if (!parameter.allows(value)) refuse(meta_name(from, parameter.key()), value, parameter.range());
        parameters.push_back(value);
    }
    return PhaseFunction(form.name, parameters);
}

Medium read_medium(const MetaMap& from, const Medium& otherwise)
{
    Medium medium = otherwise;
    medium.sigma_t_per_density = get_vector(from, schema::sigma_t_per_density, otherwise.sigma_t_per_density);
    medium.albedo = get_vector(from, schema::albedo, otherwise.albedo);
    medium.phase = read_phase(from, otherwise.phase);
    check(medium);
    return medium;
}

void write_medium(MetaMap& to, const Medium& medium)
{
    check(medium);
    set_vector(to, schema::sigma_t_per_density, medium.sigma_t_per_density);
    set_vector(to, schema::albedo, medium.albedo);
    for (const PhaseForm& form : phase_table())
        for (const PhaseParameter& parameter : form.parameters) to.removeMeta(parameter.key());
    set_text(to, schema::phase, medium.phase.name());
    const auto& parameters = medium.phase.form().parameters;
    for (size_t k = 0; k < parameters.size(); ++k) set_number(to, parameters[k].key(), medium.phase.parameters()[k]);
}

}  // namespace vdbcloud
