#pragma once
// The effects that a scene can have beside a density: their names, and what a run spends on each.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace vdbcloud {

enum class Effect {
    Lights,
    Emission,
    Sky,
    Ground,
    Solids,
    Tint,
    Multiple,
    Colour,
    Anisotropy,
    Mixture,
    Periodic,
};

/// The word of an effect in options and reports.
struct EffectName {
    Effect effect;
    const char* name;
    const char* meaning;
    /// A run can leave the effect out. An effect without this is a property of the medium, which no run leaves out.
    bool optional;
};

/// All effects, in the order of the enumeration, in which programs list them.
const std::vector<EffectName>& effect_names();
inline constexpr size_t effect_count = size_t(Effect::Periodic) + 1;

/// What a run spends on one effect, measured. All members are 0 where the effect is off.
struct EffectCost {
    uint64_t entries = 0;  ///< calls of code that serves the effect, or values that kernels read for it
    uint64_t fields = 0;   ///< grids, arrays and maps that serve the effect alone
    double bytes = 0;      ///< of these fields
    double seconds = 0;    ///< of processor time of all threads, in code that serves the effect alone
    bool timed = false;    ///< false: no code serves the effect alone, and `seconds` means nothing
};

/// What a run spends on each effect. One thread adds to it.
class EffectCosts {
public:
    const EffectCost& operator[](Effect effect) const { return costs_[size_t(effect)]; }
    EffectCosts& operator+=(const EffectCosts&);

    void enter(Effect effect, double entries = 1) { costs_[size_t(effect)].entries += uint64_t(entries); }
    /// Adds fields that live until the end of the run.
    void hold(Effect effect, uint64_t fields, double bytes);

    /// Adds one entry, and the processor time of the process during its life. Timers of one effect do not nest.
    class Timer {
    public:
        Timer(EffectCosts&, Effect);
        ~Timer();
        Timer(const Timer&) = delete;
        Timer& operator=(const Timer&) = delete;

    private:
        EffectCost& cost_;
        double start_;
    };

private:
    std::array<EffectCost, effect_count> costs_;
};

}  // namespace vdbcloud
