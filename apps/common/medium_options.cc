#include "medium_options.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/optics/automatic_extinction.h"

#include <algorithm>
#include <cmath>

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

/// The end of an option's help: the value without the option. `otherwise` where no file gives one; may be empty.
std::string without_it(MediumSource source, const std::string& otherwise)
{
    if (source == MediumSource::None) return otherwise.empty() ? "" : "; without it " + otherwise;
    return "; without it the file's" + (otherwise.empty() ? "" : ", else " + otherwise);
}

void declare_parameter(App& app, const PhaseParameter& parameter, MediumOptions& o, MediumSource source,
                       const char* group)
{
    const double inside = parameter.open ? 1e-6 : 0;
    const std::string otherwise = without_it(source, std::isnan(parameter.otherwise) ? "" : brief(parameter.otherwise));
    auto& [value, option] = o.parameters[parameter.name];
    option = app.add_option(std::string("--") + parameter.name, value, parameter.meaning + otherwise)
                 ->check(within(parameter.low + inside, parameter.high - inside))
                 ->default_str("")
                 ->scene("medium")
                 ->group(group);
}

bool has(const PhaseForm& form, const std::string& parameter)
{
    for (const PhaseParameter& p : form.parameters)
        if (parameter == p.name) return true;
    return false;
}

/// The form asked for; without --phase the file's if it has the parameter that was given, else the first that has.
const PhaseForm& chosen_form(const MediumOptions& o, const PhaseForm& file)
{
    if (o.option.phase.given()) return phase_form(o.phase);
    for (const auto& [name, parameter] : o.parameters)
        if (parameter.option.given() && !has(file, name))
            for (const PhaseForm& form : phase_table())
                if (has(form, name)) return form;
    return file;
}

PhaseFunction chosen_phase(const MediumOptions& o, const PhaseFunction& file)
{
    const PhaseForm& form = chosen_form(o, file.form());
    for (const auto& [name, parameter] : o.parameters)
        if (parameter.option.given() && !has(form, name))
            throw UsageError(parameter.option.text() + ": the phase function " + form.name + " has no " + name);
    std::vector<double> parameters;
    for (size_t k = 0; k < form.parameters.size(); ++k) {
        const PhaseParameter& parameter = form.parameters[k];
        const auto& asked = o.parameters.at(parameter.name);
        double value = &form == &file.form() ? file.parameters()[k] : parameter.otherwise;
        if (asked.option.given()) value = asked.value;
        if (std::isnan(value))
            throw UsageError(std::string("--phase ") + form.name + ": expected " + asked.option.name() + ", " +
                             parameter.range());
        parameters.push_back(value);
    }
    return PhaseFunction(form.name, parameters);
}

/// `otherwise` with the coefficients that the user gave.
Medium with_given(const MediumOptions& o, Medium otherwise)
{
    if (o.option.extinction.given() && is_zero(o.extinction))
        throw UsageError("--extinction 0: expected a number above 0");
    if (o.option.extinction.given()) otherwise.sigma_t_per_density = o.extinction;
    if (o.option.albedo.given()) otherwise.albedo = o.albedo;
    otherwise.phase = chosen_phase(o, otherwise.phase);
    return otherwise;
}

/// Warns of an extinction at which nothing of the medium can be seen: it takes less than a thousandth of the light, or
/// light ends at its first voxels.
void tell_invisible(App& app, const FloatGrid& density, const Medium& medium)
{
    const Vec3d& sigma_t = medium.sigma_t_per_density;
    const double typical = typical_depth(density), most = std::max({sigma_t[0], sigma_t[1], sigma_t[2]}),
                 least = std::min({sigma_t[0], sigma_t[1], sigma_t[2]});
    const bool thin = most * typical<1e-3, thick = least * typical> 1e6;
    if (typical == 0 || !(thin || thick)) return;
    app.warnings()("extinction " + brief(sigma_t) + ": optical depth " + brief((thin ? most : least) * typical) +
                   " through the medium, so that " + (thin ? "next to nothing" : "only its outermost voxels") +
                   " can be seen; --extinction " + brief(automatic_extinction(density)) + " makes it 9");
}

}  // namespace

void declare_medium(App& app, MediumOptions& o, MediumSource source)
{
    const bool file = source == MediumSource::File;
    const char* group = file ? "Medium" : "Medium, written into the density for later programs";
    // No default is shown or printed for what a file may give: a printed configuration must not overrule the
    // file.
    o.option.extinction = app.add_rgb("--extinction", o.extinction,
                                      "sigma_t at density 1 [1/world unit], one number or r,g,b" +
                                          without_it(source, file ? "automatic" : "later programs choose one"))
                              ->check(nonnegative)
                              ->default_str("")
                              ->scene("medium")
                              ->group(group);
    o.option.albedo =
        app.add_rgb("--albedo", o.albedo,
                    "share of extinguished light that is scattered, one number or r,g,b" +
                        without_it(source, file ? "1, or that of soot, 0.25, where the medium burns" : "1"))
            ->check(within(0, 1))
            ->default_str("")
            ->scene("medium")
            ->group(group);
    std::vector<std::pair<std::string, std::string>> names;
    std::string meanings;
    for (const PhaseForm& form : phase_table()) {
        names.emplace_back(form.name, form.name);
        meanings += std::string("; ") + form.name + ": " + form.meaning;
    }
    o.option.phase = app.add_choice<std::string>("--phase", o.phase, names,
                                                 "phase function" + without_it(source, "henyey-greenstein") + meanings)
                         ->default_str("")
                         ->scene("medium")
                         ->group(group);
    for (const PhaseForm& form : phase_table())
        for (const PhaseParameter& parameter : form.parameters) declare_parameter(app, parameter, o, source, group);
    if (file) declare_fire(app, o.fire, group);
}

std::vector<Option> options_of(const MediumOptions& o)
{
    std::vector<Option> all{o.option.extinction, o.option.albedo, o.option.phase};
    for (const auto& [name, parameter] : o.parameters) all.push_back(parameter.option);
    return all;
}

Medium chosen_medium(App& app, const MediumOptions& o, FloatGrid& density, bool burns)
{
    Medium otherwise;
    if (burns) otherwise.albedo = Vec3d(soot_albedo);
    if (burns && !o.option.albedo.given() && !has_meta(density, schema::albedo))
        app.say("albedo " + brief(soot_albedo) + ", that of soot, for the medium burns");
    Medium medium = with_given(o, read_medium(density, otherwise));
    std::string origin = get_text(density, schema::sigma_t_origin, "given");
    if (o.option.extinction.given()) origin = "given";
    if (is_zero(medium.sigma_t_per_density)) {
        medium.sigma_t_per_density = Vec3d(automatic_extinction(density));
        origin = "automatic";
        app.say("extinction " + brief(medium.sigma_t_per_density[0]) +
                " per world unit at density 1, chosen automatically");
    }
    if (origin != "automatic") tell_invisible(app, density, medium);
    write_medium(density, medium);
    set_text(density, schema::sigma_t_origin, origin);
    return medium;
}

void write_given_medium(const MediumOptions& o, MetaMap& to)
{
    const std::vector<Option> options = options_of(o);
    if (std::none_of(options.begin(), options.end(), [](const Option& option) { return option.given(); })) return;
    write_medium(to, with_given(o, {}));
    if (o.option.extinction.given())
        set_text(to, schema::sigma_t_origin, "given");
    else
        to.removeMeta(schema::sigma_t_per_density);
    if (!o.option.albedo.given()) to.removeMeta(schema::albedo);  // that of soot, if it burns
}

void require_same_medium(const std::string& what, const MetaMap& made_with, const Medium& medium)
{
    const Vec3d sigma_t = get_vector(made_with, schema::sigma_t_per_density, medium.sigma_t_per_density);
    const Vec3d albedo = get_vector(made_with, schema::albedo, medium.albedo);
    const PhaseFunction phase = read_phase(made_with, medium.phase);
    if (!close(sigma_t, medium.sigma_t_per_density))
        contradict(what, "extinction", shortest(sigma_t), shortest(medium.sigma_t_per_density));
    if (!close(albedo, medium.albedo)) contradict(what, "albedo", shortest(albedo), shortest(medium.albedo));
    if (phase != medium.phase) contradict(what, "phase function", phase.text(), medium.phase.text());
}

bool same_extinction(const MetaMap& made_with, const Medium& medium)
{
    return has_meta(made_with, schema::sigma_t_per_density) &&
           close(get_vector(made_with, schema::sigma_t_per_density, Vec3d(0.0)), medium.sigma_t_per_density);
}

}  // namespace vdbcloud::app
