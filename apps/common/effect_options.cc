#include "effect_options.h"

#include "nearest.h"

#include "vdbcloud/core/error.h"

#include <algorithm>
#include <cstdio>
#include <optional>

namespace vdbcloud::app {

namespace {

/// The optional effects, as --effects takes them.
std::vector<std::string> optional_names()
{
    std::vector<std::string> names;
    for (const EffectName& effect : effect_names())
        if (effect.optional) names.push_back(effect.name);
    return names;
}

std::string joined(const std::vector<std::string>& words)
{
    std::string all;
    for (const std::string& word : words) all += (all.empty() ? "" : ", ") + word;
    return all;
}

/// Empty for the name of an optional effect, else what is wrong with it.
std::string fault_of(const std::string& name)
{
    for (const EffectName& effect : effect_names())
        if (name == effect.name)
            return effect.optional
                       ? ""
                       : "'" + name + "' is a property of the medium, which no run leaves out: expected some of " +
                             joined(optional_names());
    const std::string best = nearest(name, optional_names());
    return "'" + printable(name) + "': " +
           (best.empty() ? "expected auto, all, or some of " + joined(optional_names())
                         : "did you mean '" + best + "'?");
}

std::string fault_of_list(const std::string& text)
{
    if (text == "auto" || text == "all") return "";
    for (const std::string& name : split(text, ','))
        if (const std::string fault = fault_of(name); !fault.empty()) return fault;
    return "";
}

/// "2%" or "0.02".
std::optional<double> read_share(std::string text)
{
    const bool in_percent = !text.empty() && text.back() == '%';
    if (in_percent) text.pop_back();
    const auto x = number(text);
    if (!x || !(*x >= 0)) return std::nullopt;
    const double share = in_percent ? *x / 100 : *x;
    return share < 1 ? std::optional(share) : std::nullopt;
}

std::string padded(const std::string& name)
{
    size_t width = 0;
    for (const EffectName& effect : effect_names()) width = std::max(width, std::string(effect.name).size());
    return name + std::string(width - name.size(), ' ');
}

std::string amount(double bytes)
{
    char text[48];
    std::snprintf(text, sizeof text,
                  bytes >= 1e6   ? "%.1f MB"
                  : bytes >= 1e3 ? "%.1f kB"
                                 : "%.0f bytes",
                  bytes / (bytes >= 1e6   ? 1e6
                           : bytes >= 1e3 ? 1e3
                                          : 1));
    return text;
}

std::string cost_text(const EffectCost& cost)
{
    char seconds[48] = "no code of its own";
    if (cost.timed) std::snprintf(seconds, sizeof seconds, "%.3f s", cost.seconds);
    return std::string(seconds) + ", " + amount(cost.bytes) + " in " + std::to_string(cost.fields) +
           (cost.fields == 1 ? " field" : " fields");
}

}  // namespace

void declare_effects(App& app, EffectOptions& o)
{
    const char* group = "Effects";
    app.add_option(
           "--effects", o.effects,
           "which effects take part. auto: those that add light; all: all that the scene has, even where they add "
           "nothing, and r, g and b each by themselves, for checks; or exactly these of " +
               joined(optional_names()) + ", with commas between. Give all programs of a chain the same list")
        ->check(CLI::Validator([](const std::string& text) { return fault_of_list(text); }, ""))
        ->type_name("auto|all|LIST")
        ->scene("accuracy")
        ->group(group);
    app.add_flag(
           "--explain", o.explain,
           "print each effect, whether it is on and why, and after the run the processor time and the memory that "
           "it took")
        ->not_with([&app] { return app.get_option("--quiet")->count() > 0; }, "--quiet")
        ->configurable(false)
        ->group(group);
}

Option declare_accuracy_error(App& app, EffectOptions& o)
{
    o.error_option =
        app.add_option(
               "--accuracy-error", o.accuracy_error,
               "multiple scattering is left out where it brings less than this share of the scattered light: 2% "
               "or 0.02; 0: it is computed wherever the medium scatters")
            ->check(CLI::Validator(
                [](const std::string& text) {
                    return read_share(text) ? std::string()
                                            : "'" + printable(text) + "': expected a share below 1, such as 2% or 0.02";
                },
                ""))
            ->type_name("SHARE")
            ->not_with([&o] { return o.effects != "auto" && effects_asked(o).mode == EffectsAsked::Mode::All; },
                       "--effects all")
            ->scene("accuracy", "error")
            ->group("Effects");
    return o.error_option;
}

EffectsAsked effects_asked(const EffectOptions& o)
{
    EffectsAsked asked;
    if (o.effects == "auto") return asked;
    asked.mode = o.effects == "all" ? EffectsAsked::Mode::All : EffectsAsked::Mode::List;
    for (const std::string& name : split(o.effects, ','))
        for (const EffectName& effect : effect_names())
            if (name == effect.name) asked.list[size_t(effect.effect)] = true;
    return asked;
}

double accuracy_error(const EffectOptions& o) { return read_share(o.accuracy_error).value(); }

void tell_effects(App& app, const EffectOptions& o, const Effects& effects)
{
    auto& report = app.report()["effects"];
    if (o.explain) app.say("effects:");
    for (const EffectName& effect : effect_names()) {
        const EffectState& state = effects[effect.effect];
        report[effect.name] = {{"on", state.on}, {"why", state.why}};
        if (o.explain) app.say("  " + padded(effect.name) + (state.on ? "  on   " : "  off  ") + state.why);
    }
    if (const auto& found = effects.share())
        report["multiple"].update({{"share", found->share}, {"share_error", found->error}});
}

void tell_costs(App& app, const EffectOptions& o, const Effects& effects, const EffectCosts& costs)
{
    auto& report = app.report()["effects"];
    if (o.explain) app.say("processor time in code of an effect alone, and memory of fields of an effect alone:");
    for (const EffectName& effect : effect_names()) {
        const EffectCost& cost = costs[effect.effect];
        auto& entry = report[effect.name];
        entry.update({{"entries", cost.entries}, {"fields", cost.fields}, {"bytes", cost.bytes}});
        if (cost.timed) entry["cpu_seconds"] = cost.seconds;
        if (o.explain && effects.on(effect.effect)) app.say("  " + padded(effect.name) + "  " + cost_text(cost));
    }
}

std::string left_out(const Effects& effects)
{
    std::string all;
    for (const EffectName& effect : effect_names())
        if (const EffectState& state = effects[effect.effect]; state.left_out)
            all += (all.empty() ? "" : "; ") + std::string(effect.name) + " (" + state.why + ")";
    return all;
}

}  // namespace vdbcloud::app
