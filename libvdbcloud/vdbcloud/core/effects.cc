#include "vdbcloud/core/effects.h"

#include <time.h>

namespace vdbcloud {

namespace {

double processor_seconds()
{
    timespec now = {};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

}  // namespace

const std::vector<EffectName>& effect_names()
{
    static const std::vector<EffectName> all = {
        {Effect::Lights, "lights", "suns, lamps and spots", true},
        {Effect::Emission, "emission", "the medium glows: a grid emission", true},
        {Effect::Sky, "sky", "the sky as a light", true},
        {Effect::Ground, "ground", "a ground beneath the medium", true},
        {Effect::Solids, "solids", "opaque bodies", true},
        {Effect::Tint, "tint", "a factor of the albedo for each voxel: a grid Cd", true},
        {Effect::Multiple, "multiple", "light that is scattered more than once", true},
        {Effect::Colour, "colour", "r, g and b need computations of their own", false},
        {Effect::Anisotropy, "anisotropy", "the medium scatters more light into some directions", false},
        {Effect::Mixture, "mixture", "several media", false},
        {Effect::Periodic, "periodic", "the medium repeats without end", false},
    };
    return all;
}

EffectCosts& EffectCosts::operator+=(const EffectCosts& other)
{
    for (size_t k = 0; k < effect_count; ++k) {
        const EffectCost& add = other.costs_[k];
        EffectCost& to = costs_[k];
        to.entries += add.entries;
        to.fields += add.fields;
        to.bytes += add.bytes;
        to.seconds += add.seconds;
        to.timed = to.timed || add.timed;
    }
    return *this;
}

void EffectCosts::hold(Effect effect, uint64_t fields, double bytes)
{
    costs_[size_t(effect)].fields += fields;
    costs_[size_t(effect)].bytes += bytes;
}

EffectCosts::Timer::Timer(EffectCosts& costs, Effect effect)
    : cost_(costs.costs_[size_t(effect)]), start_(processor_seconds())
{
    ++cost_.entries;
    cost_.timed = true;
}

EffectCosts::Timer::~Timer() { cost_.seconds += processor_seconds() - start_; }

}  // namespace vdbcloud
