#pragma once
// Which effects a run has in play, and why: the one place that decides it, from the scene and the input.
#include "vdbcloud/core/effects.h"
#include "vdbcloud/optics/medium.h"
#include "vdbcloud/scene/light.h"
#include "vdbcloud/scene/sky.h"
#include "vdbcloud/scene/solid.h"

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace vdbcloud {

/// What a run computes.
enum class EffectStage {
    Light,    ///< transmittance grids
    Scatter,  ///< multiple scattering
    Picture   ///< a picture
};

/// Which effects take part.
struct EffectsAsked {
    enum class Mode {
        Auto,  ///< what adds light
        All,   ///< what is there, whether it adds light or not; and no channel shares the computation of another
        List   ///< of the optional effects those of `list`, as Auto
    };
    Mode mode = Mode::Auto;
    std::array<bool, effect_count> list{};
};

/// False where a list leaves the effect out.
bool is_asked(const EffectsAsked&, Effect);

/// One medium of a scene.
struct MediumFacts {
    const FloatGrid* density = nullptr;  ///< never null; may be empty
    Medium medium;
    const Vec3SGrid* tint = nullptr;      ///< Cd; may be null
    const Vec3SGrid* emission = nullptr;  ///< may be null
    double delta_f = 0;                   ///< of the scaled medium of a picture
};

/// An estimate of the share of scattered light that multiple scattering brings (scatter/expected_share.h).
struct ShareFound {
    double share = 0, error = 0;  ///< `error`: standard error
};

/// All that the decision looks at.
struct EffectFacts {
    EffectStage stage = EffectStage::Light;
    std::vector<MediumFacts> media;
    std::vector<Light> lights;
    std::vector<bool> hidden;  ///< of each light: its transmittance is 0 everywhere; empty: not known
    bool lights_shown =
        false;  ///< the picture has a layer for each light, so that lights without power are in play, too
    Sky sky;    ///< that lights the medium or solids; black: none
    std::optional<double> ground_albedo;
    std::vector<Solid> solids;
    bool walls = false;  ///< multiple scattering is that of sweeps, to which solids send light
    std::array<bool, 3> periodic{false, false, false};

    // Multiple scattering.
    double accuracy = 0.02;  ///< it is left out where its share of scattered light is below this
    std::string needed_by;   ///< what asks for it whatever its share; empty: nothing
    bool brought = false;    ///< the input of the picture has it
    bool computed = true;    ///< the stage computes it where the input does not have it
    /// Estimates the share. Called where the decision depends on it; null: not known, so that the effect is on.
    std::function<ShareFound()> share;
};

struct EffectState {
    bool on = false;
    bool left_out = false;  ///< the scene has it, and a request leaves it out or it adds less than `accuracy`
    std::string why;        ///< one clause for people, without names of options
};

/// Decides. The criterion of each effect, where the scene has it:
///
///     lights      a light is in play whose strength is above 0 in a channel, and that reaches a voxel
///     emission    a value of the grid differs from 0
///     sky         the radiance differs from 0
///     ground      always: it hides what is behind
///     solids      always: a solid outside of the picture casts a shadow into it
///     tint        a value of Cd differs from 1
///     multiple    sky, ground, emission that the medium scatters, or light of solids are in play, or the share of scattered light that
///                 the first scattering of lights is not may be `accuracy` or more: share + 2 standard errors
///     colour      Light: extinctions differ. Scatter: coefficients, Cd or emission differ, or lights are not
///                 proportional, or solids that send light are coloured. Picture: extinctions differ in the medium that is shown
///     anisotropy  a moment of the phase function of degree 1 to 7 is not 0
///     mixture     there is more than one medium
///     periodic    the medium repeats along an axis
class Effects {
public:
    Effects() = default;
    Effects(const EffectFacts&, const EffectsAsked&);

    const EffectState& operator[](Effect effect) const { return states_[size_t(effect)]; }
    bool on(Effect effect) const { return states_[size_t(effect)].on; }
    /// Of each light: it is in play.
    const std::vector<bool>& lights() const { return lights_; }
    /// Of those that `lights()` says, in order.
    std::vector<Light> lights_in_play(const std::vector<Light>&) const;
    /// The share of multiple scattering, where the decision needed it.
    const std::optional<ShareFound>& share() const { return share_; }
    /// No kernel for special cases, and no channel that shares the computation of another.
    bool forced() const { return forced_; }

private:
    EffectState decide_multiple(const EffectFacts&, const EffectsAsked&);

    std::array<EffectState, effect_count> states_;
    std::vector<bool> lights_;
    std::optional<ShareFound> share_;
    bool forced_ = false;
};

/// "84 %", "0.31 %", "below 0.1 %": a share of light for people.
std::string share_text(double share);

}  // namespace vdbcloud
