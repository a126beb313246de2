#include "vdbcloud/optics/medium.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"

#include <cmath>
#include <sstream>

namespace vdbcloud {

namespace {

template<typename T>
[[noreturn]] void refuse(const char* key, const T& value, const char* expected)
{
    std::ostringstream what;
    what << key << " = " << value << ": expected " << expected;
    throw InputError(what.str());
}

/// Throws unless every channel is within [low, high]; NaN is not.
void check_channels(const char* key, const Vec3d& value, double low, double high, const char* expected)
{
    for (int c = 0; c < 3; ++c)
        if (!(value[c] >= low && value[c] <= high)) refuse(key, value, expected);
}

void check(const Medium& medium)
{
    check_channels(schema::sigma_t_per_density, medium.sigma_t_per_density, 0, 1e30, "finite numbers, 0 or above");
    check_channels(schema::albedo, medium.albedo, 0, 1, "numbers in [0, 1]");
    if (!(medium.g > -1 && medium.g < 1)) refuse(schema::g, medium.g, "a number in (-1, 1)");
}

}  // namespace

bool Medium::grey() const
{
    return sigma_t_per_density[0] == sigma_t_per_density[1] && sigma_t_per_density[1] == sigma_t_per_density[2];
}

const char* name(PhaseKind kind)
{
    switch (kind) {
    case PhaseKind::Isotropic: return "isotropic";
    case PhaseKind::Rayleigh: return "rayleigh";
    case PhaseKind::HenyeyGreenstein: return "henyey-greenstein";
    }
    return "unknown";
}

PhaseKind phase_kind(const std::string& text)
{
    for (const auto kind : {PhaseKind::Isotropic, PhaseKind::Rayleigh, PhaseKind::HenyeyGreenstein})
        if (text == name(kind)) return kind;
    throw InputError("phase function '" + printable(text) + "': expected isotropic, rayleigh or henyey-greenstein");
}

Medium read_medium(const MetaMap& from, const Medium& otherwise)
{
    Medium medium = otherwise;
    medium.sigma_t_per_density = get_vector(from, schema::sigma_t_per_density, otherwise.sigma_t_per_density);
    medium.albedo = get_vector(from, schema::albedo, otherwise.albedo);
    medium.g = get_number(from, schema::g, otherwise.g);
    medium.phase = phase_kind(get_text(from, schema::phase, name(otherwise.phase)));
    check(medium);
    return medium;
}

void write_medium(MetaMap& to, const Medium& medium)
{
    check(medium);
    set_vector(to, schema::sigma_t_per_density, medium.sigma_t_per_density);
    set_vector(to, schema::albedo, medium.albedo);
    set_number(to, schema::g, medium.g);
    set_text(to, schema::phase, name(medium.phase));
}

}  // namespace vdbcloud
