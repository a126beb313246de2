#pragma once
// An effect of the air as data: what it is called, what users can set, what it needs, and the terms that it adds. Each
// effect is one file of effects/ and one entry of the table in parameters.h.
#include "vdbcloud/sim/parameters.h"

#include <limits>
#include <string>
#include <vector>

namespace vdbcloud::sim {

template<typename T>
struct Air;

/// The end of a range that has none.
inline constexpr double any_finite = std::numeric_limits<double>::max();

/// Values that a number may have: [low, high], or (low, high] if `open`. Infinity only if an end is infinite.
struct Range {
    double low, high;
    bool open = false;

    bool holds(double value) const { return (open ? value > low : value >= low) && value <= high; }
    /// "0..1000", "above 0", "0 or above"
    std::string text() const;
};
constexpr Range from_zero(double most) { return {0, most}; }
constexpr Range above_zero(double most) { return {0, most, true}; }
constexpr Range magnitude(double most) { return {-most, most}; }

/// One value of Parameters that users set. Programs make an option of it; checks, checkpoints and metadata name it.
/// Its default is the member's initial value, unless a preset has another.
struct Setting {
    enum class Kind {
        Switch,  ///< on or off
        Number,
        Time,  ///< [s]; `never` is infinity
    };
    using Flag = bool& (*)(Parameters&);
    using Value = double& (*)(Parameters&);

    Kind kind;
    std::string name;  ///< "sponge-depth", as the option --sponge-depth
    std::string help;  ///< one sentence, without unit and range
    std::string unit;  ///< "1/s"; empty: none
    Range range{0, 1};
    Flag flag = nullptr;    ///< of a switch
    Value value = nullptr;  ///< of a number or a time

    /// A switch.
    Setting(const char* named, const char* does, Flag member)
        : kind(Kind::Switch), name(named), help(does), flag(member)
    {
    }
    /// A number.
    Setting(const char* named, const char* does, const char* in, Range allowed, Value member)
        : kind(Kind::Number), name(named), help(does), unit(in), range(allowed), value(member)
    {
    }
    static Setting time(const char* named, const char* does, Range allowed, Value member)
    {
        Setting s(named, does, "s", allowed, member);
        s.kind = Kind::Time;
        return s;
    }

    /// "sponge_depth": the name in checkpoints and in the metadata of frames.
    std::string key() const;
    bool on(const Parameters&) const;        ///< of a switch
    double number(const Parameters&) const;  ///< of a number or a time
    /// Throws InputError "sponge depth = 2: expected ..." for a value outside of its range.
    void check(const Parameters&) const;
};

/// Adds the terms of an effect to the air, in both precisions.
struct Terms {
    void (*in_float)(Air<float>&) = nullptr;
    void (*in_double)(Air<double>&) = nullptr;

    void add(Air<float>& air) const
    {
        if (in_float) in_float(air);
    }
    void add(Air<double>& air) const
    {
        if (in_double) in_double(air);
    }
};

struct Effect {
    std::string name;
    std::string needs;  ///< fields and work where it is on, in words; may be empty
    /// The first `switches` turn the effect on. The others change nothing where it is off.
    std::vector<Setting> settings;
    bool (*on)(const Parameters&);
    /// What no range of a single setting says. Throws InputError. May be null.
    void (*check)(const Parameters&) = nullptr;
    /// Arrays of one value a cell that the effect allocates where it is on. May be null: none.
    int (*fields)(const Parameters&) = nullptr;
    Terms terms{};
    size_t switches = 1;
    /// Where no setting turns the effect on: what does, "sides open".
    std::string turned_on_by{};
    /// An explicit step times this rate [1/s] must stay below 1 where the effect is on. May be null: no limit.
    double (*fastest_rate)(const Parameters&) = nullptr;
    /// The state of the air does not depend on the settings, so that they can change between two steps.
    bool can_change = false;
};

/// An effect that forces or damps the air and has no state: its settings can change between two steps.
Effect changeable(Effect);

/// Potential temperatures that air can have [K]: of soundings, bubbles and first states alike.
inline constexpr Range allowed_theta{100, 2000};
/// The largest speed [m/s] of soundings and first states. The equations have no sound.
inline constexpr double allowed_speed = 500;

/// All effects, in the order in which their terms are added.
const std::vector<Effect>& effects();

/// What can be set beside the effects, in groups as programs list them.
const std::vector<Setting>& constant_settings();
const std::vector<Setting>& noise_settings();
const std::vector<Setting>& numeric_settings();

}  // namespace vdbcloud::sim
