#pragma once
// The words of this module's enumerations: for options, checkpoints and plans alike.
#include "vdbcloud/core/words.h"
#include "vdbcloud/sim/parameters.h"

namespace vdbcloud::sim {

inline constexpr auto side_words =
    words<Side>("side", {{Side::Periodic, "periodic"}, {Side::Wall, "wall"}, {Side::Open, "open"}});
inline constexpr auto precision_words =
    words<Precision>("precision", {{Precision::Float, "float"}, {Precision::Double, "double"}});
inline constexpr auto saturation_words =
    words<SaturationBy>("saturation", {{SaturationBy::Height, "height"}, {SaturationBy::Temperature, "temperature"}});
inline constexpr auto time_scheme_words = words<TimeScheme>(
    "time scheme",
    {{TimeScheme::Euler, "euler"}, {TimeScheme::Rk2, "rk2"}, {TimeScheme::Rk3, "rk3"}, {TimeScheme::HugeStep, "huge"}});
inline constexpr auto scalar_scheme_words = words<ScalarScheme>("scalar scheme", {{ScalarScheme::Upwind, "upwind"},
                                                                                  {ScalarScheme::Koren, "koren"},
                                                                                  {ScalarScheme::Limited5, "limited5"},
                                                                                  {ScalarScheme::Plain5, "plain5"}});
inline constexpr auto momentum_scheme_words = words<MomentumScheme>(
    "momentum scheme", {{MomentumScheme::Upwind, "upwind"}, {MomentumScheme::Upwind5, "upwind5"}});

}  // namespace vdbcloud::sim
