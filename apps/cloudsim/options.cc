// The options as declared: those of effects, constants and numerics come from the library's own descriptions of them.
#include "options.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/sim/effect.h"
#include "vdbcloud/sim/words.h"

#include <memory>

namespace vdbcloud::app {

namespace {

using sim::Parameters;

CLI::Validator allowed(const sim::Setting& setting)
{
    const auto check = [range = setting.range, unit = setting.unit](const std::string& text) {
        const auto value = number(text);
        return value && range.holds(*value)
                   ? std::string()
                   : "'" + text + "': expected a finite number, " + range.text() + (unit.empty() ? "" : " ") + unit;
    };
    return CLI::Validator(check, setting.range.text());
}

/// Declares options that change the parameters if they are given.
class Declaration {
public:
    Declaration(App& app, Options& o, const char* group) : app_(app), o_(o), group_(group) {}

    /// Any option of App's, kept by its name.
    Option keep(const std::string& name, const Option& option) const
    {
        option.group(group_);
        return o_.option[name] = option;
    }
    void settings(const std::vector<sim::Setting>& list) const
    {
        for (const sim::Setting& setting : list) bind(setting);
    }
    template<typename E>
    Option choice(const std::string& name, E& (*member)(Parameters&),
                  const std::vector<std::pair<std::string, E>>& choices, const char* help) const
    {
        auto given = std::make_shared<std::string>();
        std::vector<std::pair<std::string, std::string>> words;
        for (const auto& [word, value] : choices) words.emplace_back(word, word);
        o_.overrides.push_back([given, member, choices](Parameters& p) {
            for (const auto& [word, value] : choices)
                if (word == *given) member(p) = value;
        });
        return keep(name, app_.add_choice<std::string>("--" + name, *given, words, help)->default_str(""));
    }
    Option on_off(const std::string& name, bool& (*member)(Parameters&), const char* help) const
    {
        return choice<bool>(name, member, {{"on", true}, {"off", false}}, help);
    }

private:
    void bind(const sim::Setting& setting) const
    {
        const std::string option = "--" + setting.name;
        const std::string help = setting.help + (setting.unit.empty() ? "" : " [" + setting.unit + "]");
        switch (setting.kind) {
        case sim::Setting::Kind::Switch: on_off(setting.name, setting.flag, help.c_str()); break;
        case sim::Setting::Kind::Number: {
            auto given = std::make_shared<std::optional<double>>();
            o_.overrides.push_back([given, member = setting.value](Parameters& p) {
                if (*given) member(p) = **given;
            });
            keep(setting.name, app_.add_option(option, *given, help)->check(allowed(setting)));
            break;
        }
        case sim::Setting::Kind::Time: {
            auto given = std::make_shared<std::string>();
            o_.overrides.push_back([given, member = setting.value, option](Parameters& p) {
                if (!given->empty()) member(p) = *given == "never" ? sim::never : seconds_of(option, *given);
            });
            keep(setting.name, app_.add_option(option, *given, setting.help + ": 600s, 10min, 1h or never"));
            break;
        }
        }
    }

    App& app_;
    Options& o_;
    const char* group_;
};

#define VDBCLOUD_MEMBER(path) [](Parameters& p) -> decltype(auto) { return (p.path); }

void declare_output(App& app, Options& o)
{
    const Declaration output(app, o, "Time and output");
    output.keep("minutes",
                app.add_option("--minutes", o.minutes, "simulated time [min]; else the preset's")->check(nonnegative));
    output.keep("every", app.add_option("--every", o.every, "time between frames, 10s or 0.5min; else the preset's"));
    output.keep(
        "up",
        app.add_choice<UpAxis>("--up", o.up, up_axis_choices(), "axis that points up in the files")->scene("medium"));
    output.keep("grids", app.add_option("--grids", o.grids,
                                        "grids to write, between commas: density,temperature,qt,vel,rain,dye,flame; "
                                        "else all that the run has"));
    output.keep("unpruned", app.add_flag("--unpruned", o.unpruned,
                                         "every voxel of every grid is active, also where there is no cloud"));
    output.keep("effective-radius", app.add_option("--effective-radius", o.effective_radius,
                                                   "radius of droplets, from which the extinction follows [m]")
                                        ->check(positive));
    output.keep("smoke-extinction",
                app.add_option("--smoke-extinction", o.smoke_extinction,
                               "sigma_t of dye 1 in a run without moisture [1/m]; else the preset's")
                    ->check(positive));
    output.keep("first-frame",
                app.add_option("--first-frame", o.first_frame, "number of the first frame")->check(nonnegative));
    output.keep("log", app.add_option("--log", o.log, "writes a JSON line a frame to FILE, or - for standard output")
                           ->configurable(false)
                           ->writes_file(FileKind::Other));
    output.keep("series", app.add_option("--series", o.series,
                                         "writes cloud cover, water paths, cloud base and top, w, kinetic energy and "
                                         "surface fluxes of each frame as a line of the table FILE (.csv)")
                              ->configurable(false)
                              ->writes_file(FileKind::Other));
    output.keep("profiles", app.add_option("--profiles", o.profiles,
                                           "writes means, cloud fraction, variances and fluxes of each level, averaged "
                                           "over frames, to the table FILE (.csv)")
                                ->configurable(false)
                                ->writes_file(FileKind::Other));
    output.keep("average", app.add_option("--average", o.average,
                                          "period of which --profiles writes means, 30min or 1h; else the whole run")
                               ->needs(o.option.at("profiles")));
    output.keep("netcdf", app.add_option("--netcdf", o.netcdf,
                                         "at the end writes the tables of --series and --profiles to FILE as netCDF, "
                                         "with the lines of earlier parts of the run")
                              ->configurable(false)
                              ->rewrites_file(FileKind::Other));
    output.keep("checkpoint", app.add_option("--checkpoint", o.checkpoint, "keeps the whole state in FILE")
                                  ->configurable(false)
                                  ->rewrites_file(FileKind::Other));
    output.keep("checkpoint-every",
                app.add_option("--checkpoint-every", o.checkpoint_every, "frames between checkpoints")
                    ->check(positive)
                    ->configurable(false)
                    ->needs(o.option.at("checkpoint")));
    output.keep("resume", app.add_option("--resume", o.resume,
                                         "continues from the checkpoint in FILE; starts anew if there is none")
                              ->configurable(false)
                              ->reads_files());
    output.keep("change", app.add_flag("--change", o.change,
                                       "takes forcing, --every and --grids that differ from those of the checkpoint "
                                       "from there on, and notes it in the frames; else such a run is refused")
                              ->configurable(false)
                              ->needs(o.option.at("resume")));
    output.keep("strict", app.add_flag("--strict", o.strict, "ends with status 3 when a budget leaves its tolerance"));
}

void declare_box(App& app, Options& o)
{
    const Declaration box(app, o, "Box");
    box.keep("cells", app.add_option("--cells", o.cells,
                                     "cells of the preset's box: N along its longest axis, or NX,NY,NZ with z up; "
                                     "1 for a slice"));
    box.keep("spacing", app.add_option("--spacing", o.spacing, "size of a cell, H or DX,DY,DZ [m]; changes the box"));
    box.keep("sides", app.add_option("--sides", o.sides, "periodic, wall or open; once, or X,Y for both axes"));
}

void declare_effects(App& app, Options& o)
{
    const Declaration effect(app, o, "Effects: what is off costs nothing");
    for (const sim::Effect& e : sim::effects()) effect.settings(e.settings);
}

void declare_air(App& app, Options& o)
{
    const Declaration air(app, o, "Air and forcing");
    air.keep("sounding", app.add_option("--sounding", o.sounding,
                                        "the air at the start: a table (see data/soundings), or a preset's name; else "
                                        "the preset's")
                             ->reads_files());
    air.keep("forcing", app.add_option("--forcing", o.forcing,
                                       "large-scale forcing by height: a table (see data/forcings), bomex, rico or "
                                       "none; else the preset's")
                            ->reads_files());
    air.keep("wind", app.add_option("--wind", o.wind, "wind U,V added to the sounding's [m/s]"));
    air.keep("frame-velocity",
             app.add_option("--frame-velocity", o.frame_velocity,
                            "velocity U,V of the box over the ground [m/s], or 'wind' for the sounding's mean: floor "
                            "and sources stay on the ground, files have the box where it is"));
    air.keep("shear", app.add_option("--shear", o.shear, "change of that wind with height, U,V [1/s]"));
    air.keep("floor-map", app.add_option("--floor-map", o.floor_map,
                                         "an image or .vdb that multiplies --heat-flux and --moisture-flux")
                              ->reads_files());
    air.keep("patch", app.add_option("--patch", o.patches,
                                     "x,y,radius,heat,moisture[,dye[,fuel]]: a round patch of floor in place of the "
                                     "preset's, positions from the box's corner [m]; repeat for more"));
    air.keep(
        "source",
        app.add_option("--source", o.sources,
                       "what gives to the air or takes from it; repeat for another. A shape in the world of the "
                       "files [m]: 'sphere; at=x,y,z; radius=R', 'box; from=x,y,z; to=x,y,z', or a .vdb: a level "
                       "set, or a fog volume whose values are factors (grid=NAME; numbered files: every=TIME). Then "
                       "rates heat=K/s, water=1/s, dye=1/s, fuel=1/s, below 0 for a sink; or velocity=x,y,z or "
                       "temperature=K with rate=1/s, to which air returns; and start=TIME, end=TIME, ramp=TIME")
            .type_name("SOURCE"));
    air.keep("collider",
             app.add_option("--collider", o.colliders,
                            "a body that air flows around; repeat for another. In the world of the files [m]: 'sphere; "
                            "at=x,y,z; radius=R', 'box; from=x,y,z; to=x,y,z', 'plane; at=x,y,z; up=x,y,z', or a .vdb "
                            "with a level set, such as fractalgen --mountain writes")
                 .type_name("BODY"));
    air.keep("bubble", app.add_option("--bubble", o.bubbles,
                                      "x,y,z,radius,height,kelvin,water[,dye]: a round place in the first air in "
                                      "place of the preset's; repeat for more"));
    air.keep("no-forcing", app.add_flag("--no-forcing", o.no_forcing,
                                        "leaves out patches, bubbles, sources, fluxes, surface and large-scale "
                                        "forcing of the preset"));
    air.settings(sim::noise_settings());
    air.keep("seed", app.add_option("--seed", o.seed, "seed of the noise, a whole number; else the preset's"));
    air.keep("init", app.add_option("--init", o.init,
                                    "starts from the grids temperature, qt, vel of this .vdb where they are active")
                         ->reads_files());
}

void declare_constants(App& app, Options& o)
{
    const Declaration constants(app, o, "Constants");
    constants.choice<sim::SaturationBy>("saturation", VDBCLOUD_MEMBER(moist.by), sim::saturation_words.choices(),
                                        "saturation of vapour: by height, A exp(-z/H), or by temperature and pressure");
    constants.settings(sim::constant_settings());
}

void declare_numerics(App& app, Options& o)
{
    const Declaration numerics(app, o, "Accuracy");
    const auto huge = [&o] { return o.huge_dt; };
    auto time_schemes = sim::time_scheme_words.choices();
    time_schemes.pop_back();  // huge steps are a flag of their own
    numerics.keep("accuracy",
                  app.add_choice<sim::Accuracy>(
                      "--accuracy", o.accuracy,
                      {{"small", sim::Accuracy::Small},
                       {"default", sim::Accuracy::Default},
                       {"accurate", sim::Accuracy::Accurate}},
                      "a choice of the following. small: half of the memory, of lower order, no time saved"));
    numerics.choice<sim::Precision>("precision", VDBCLOUD_MEMBER(precision), sim::precision_words.choices(),
                                    "precision of the fields");
    numerics.choice<sim::TimeScheme>("time-scheme", VDBCLOUD_MEMBER(time_scheme), time_schemes,
                                     "order in time: 1, 2, 3");
    numerics.choice<sim::ScalarScheme>("scalars", VDBCLOUD_MEMBER(scalar_scheme), sim::scalar_scheme_words.choices(),
                                       "transport of heat, water and dye: order 1, 3, 5 without new extrema; 5 with");
    numerics.choice<sim::MomentumScheme>("momentum-scheme", VDBCLOUD_MEMBER(momentum_scheme),
                                         sim::momentum_scheme_words.choices(), "transport of momentum: order 1 or 5");
    numerics.settings(sim::numeric_settings());
    for (const char* name : {"time-scheme", "scalars", "momentum-scheme", "cfl", "dt-max"})
        o.option.at(name).not_with(huge, "--huge-dt");
    numerics.keep("huge-dt", app.add_flag("--huge-dt", o.huge_dt,
                                          "semi-Lagrangian steps of --dt, or of a frame, whatever their length: "
                                          "stable, but nothing is conserved"));
    numerics.on_off("maccormack", VDBCLOUD_MEMBER(maccormack), "second order in space, for twice the time")
        ->only_with(huge, "--huge-dt");
    numerics.on_off("fix-budget", VDBCLOUD_MEMBER(fix_budget), "gives lost heat, water and dye back to all cells")
        ->only_with(huge, "--huge-dt");
}

}  // namespace

void declare(App& app, Options& o)
{
    app.writes_grids();
    o.option["output"] = app.add_option("-o,--output", o.output,
                                        "numbered frames, as out/cloud.%04d.vdb; or one file, or -, for the last alone")
                             ->required()
                             ->writes_frames(FileKind::Grids);
    app.add_option("--preset", o.preset,
                   "cumulus, congestus, stratocumulus, fog, smoke, fire, bomex, rico, or paper (10 x 10 x 20 cells, "
                   "forward differences, saturation by height)");
    declare_output(app, o);
    declare_box(app, o);
    declare_effects(app, o);
    declare_air(app, o);
    declare_constants(app, o);
    declare_numerics(app, o);
    app.reads_grids({o.option.at("init"), o.option.at("floor-map"), o.option.at("source"), o.option.at("collider")});
    app.examples(
        {{"a small cumulus of ten minutes, a frame each minute, and the picture of the last",
          "cloudsim --cells 32 --minutes 10 --every 1min -o cumulus.%02d.vdb && render cumulus.10.vdb "
          "--resolution 128 -o cumulus.png"},
         {"the simulation of the paper, its last frame alone", "cloudsim --preset paper --minutes 5 -o paper.vdb"},
         {"a run that continues after an interruption",
          "cloudsim --cells 32 --minutes 4 --every 1min --checkpoint run.state --resume run.state -o "
          "again.%02d.vdb"}});
}

}  // namespace vdbcloud::app
