#include "medium_options.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/optics/automatic_extinction.h"

namespace vdbcloud::app {

namespace {

bool is_zero(const Vec3d& v) { return v[0] == 0 && v[1] == 0 && v[2] == 0; }

/// The same to rounding: what went through text, or was computed in another order, is no contradiction.
bool close(double a, double b) { return std::abs(a - b) <= 1e-9 * std::max(std::abs(a), std::abs(b)); }
bool close(const Vec3d& a, const Vec3d& b) { return close(a[0], b[0]) && close(a[1], b[1]) && close(a[2], b[2]); }

[[noreturn]] void contradict(const std::string& what, const char* key, const std::string& theirs,
                             const std::string& ours)
{
    throw UsageError(what + " was computed with " + key + " = " + theirs + ", and " + ours +
                     " is asked for: run the stage that made it again");
}

}  // namespace

void declare_medium(App& app, MediumOptions& o)
{
    const char* group = "Medium";
    // No default is shown or printed for what a file may give: a printed configuration must not overrule the
    // file.
    o.option.extinction =
        app.add_rgb("--extinction", o.extinction,
                    "sigma_t at density 1 [1/world unit], one number or r,g,b; without it the file's, else automatic")
            ->check(nonnegative)
            ->default_str("")
            ->group(group);
    o.option.albedo = app.add_rgb("--albedo", o.rest.albedo,
                                  "share of extinguished light that is scattered; without it the file's, else 1")
                          ->check(within(0, 1))
                          ->default_str("")
                          ->group(group);
    o.option.g = app.add_option("--g", o.rest.g, "mean cosine of Henyey-Greenstein; without it the file's, else 0")
                     ->check(within(-0.999999, 0.999999))
                     ->default_str("")
                     ->group(group);
    o.option.phase = app.add_choice<PhaseKind>("--phase", o.rest.phase,
                                               {{name(PhaseKind::Isotropic), PhaseKind::Isotropic},
                                                {name(PhaseKind::Rayleigh), PhaseKind::Rayleigh},
                                                {name(PhaseKind::HenyeyGreenstein), PhaseKind::HenyeyGreenstein}},
                                               "phase function; without it the file's, else henyey-greenstein")
                         ->default_str("")
                         ->group(group);
}

Medium chosen_medium(App& app, const MediumOptions& o, FloatGrid& density)
{
    Medium medium = read_medium(density, o.rest);
    if (o.option.albedo.given()) medium.albedo = o.rest.albedo;
    if (o.option.phase.given()) medium.phase = o.rest.phase;
    if (o.option.g.given()) {
        if (o.option.phase.given() && o.rest.phase != PhaseKind::HenyeyGreenstein && o.rest.g != 0)
            throw UsageError(std::string("--g ") + shortest(o.rest.g) + ": the phase function " + name(o.rest.phase) +
                             " has none");
        if (!o.option.phase.given()) medium.phase = PhaseKind::HenyeyGreenstein;
        medium.g = o.rest.g;
    }
    if (o.option.extinction.given() && is_zero(o.extinction))
        throw UsageError("--extinction 0: expected a number above 0");
    std::string origin = get_text(density, schema::sigma_t_origin, "given");
    if (!is_zero(o.extinction)) {
        medium.sigma_t_per_density = o.extinction;
        origin = "given";
    }
    if (is_zero(medium.sigma_t_per_density)) {
        medium.sigma_t_per_density = Vec3d(automatic_extinction(density));
        origin = "automatic";
        app.say("extinction " + brief(medium.sigma_t_per_density[0]) +
                " per world unit at density 1, chosen automatically");
    }
    write_medium(density, medium);
    set_text(density, schema::sigma_t_origin, origin);
    return medium;
}

void require_same_medium(const std::string& what, const MetaMap& made_with, const Medium& medium)
{
    const Vec3d sigma_t = get_vector(made_with, schema::sigma_t_per_density, medium.sigma_t_per_density);
    const Vec3d albedo = get_vector(made_with, schema::albedo, medium.albedo);
    const double g = get_number(made_with, schema::g, medium.g);
    const std::string phase = get_text(made_with, schema::phase, name(medium.phase));
    if (!close(sigma_t, medium.sigma_t_per_density))
        contradict(what, "extinction", shortest(sigma_t), shortest(medium.sigma_t_per_density));
    if (!close(albedo, medium.albedo)) contradict(what, "albedo", shortest(albedo), shortest(medium.albedo));
    if (!close(g, medium.g)) contradict(what, "g", shortest(g), shortest(medium.g));
    if (phase != name(medium.phase)) contradict(what, "phase function", printable(phase), name(medium.phase));
}

bool same_extinction(const MetaMap& made_with, const Medium& medium)
{
    return has_meta(made_with, schema::sigma_t_per_density) &&
           close(get_vector(made_with, schema::sigma_t_per_density, Vec3d(0.0)), medium.sigma_t_per_density);
}

}  // namespace vdbcloud::app
