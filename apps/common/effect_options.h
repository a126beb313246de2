#pragma once
// --effects, --accuracy-error and --explain: which effects a run has in play, why, and what each of them cost.
#include "app.h"

#include "vdbcloud/effects/effects.h"

#include <string>

namespace vdbcloud::app {

struct EffectOptions {
    std::string effects = "auto";       ///< auto, all, or names with commas between
    std::string accuracy_error = "2%";  ///< of programs that compute multiple scattering
    bool explain = false;
    Option error_option;  ///< of programs that have it
};

/// --effects and --explain. Keeps references to `o`.
void declare_effects(App&, EffectOptions& o);
/// --accuracy-error, of a program that computes multiple scattering where it matters.
Option declare_accuracy_error(App&, EffectOptions& o);

EffectsAsked effects_asked(const EffectOptions&);
/// The error that leaving out an effect may make, as a share of the light.
double accuracy_error(const EffectOptions&);

/// Reports the effects as "effects", and prints a line for each with --explain. Call before the work.
void tell_effects(App&, const EffectOptions&, const Effects&);
/// Adds to the report what the effects cost, and prints a line for each that is on with --explain. Call after the work.
void tell_costs(App&, const EffectOptions&, const Effects&, const EffectCosts&);

/// The optional effects that the scene has and the run leaves out, with the reason: "multiple (left out on request)",
/// with semicolons between; empty for none. For the metadata of pictures.
std::string left_out(const Effects&);

}  // namespace vdbcloud::app
