#pragma once
// Bodies and masks on the ground, where air gains, loses or cannot go: described without a lattice.
#include <array>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace vdbcloud::sim {

/// A position over the ground [m]: from the lower corner of the box at time 0, z up.
using Point = std::array<double, 3>;

/// Threads: const functions can be called from several, except where changes() is true.
class Shape {
public:
    virtual ~Shape();
    /// True for a body with a surface: distance() counts, else value().
    virtual bool body() const = 0;
    /// Signed distance to the surface of a body [m], negative inside; near it exact, farther at least of its sign.
    virtual double distance(const Point&) const { return std::numeric_limits<double>::infinity(); }
    /// Value of a mask at a time [s].
    virtual double value(const Point&, double) const { return 0; }
    /// Whether value() depends on time.
    virtual bool changes() const { return false; }
    /// Times at which its slope in time jumps [s]: steps end there.
    virtual std::vector<double> times() const { return {}; }
    /// Lowest and highest corner of a box beyond which a body is not, or a mask is 0.
    virtual std::array<Point, 2> bounds() const = 0;
    /// What tells it from others, for the record of a run: one word.
    virtual std::string identity() const = 0;
};

/// The weight of a box about `centre`: of a mask the value there; of a body the share of its volume within the body, by
/// 4 x 4 x 4 points whose share is linear in the distance to the surface.
double weight_in(const Shape&, const Point& centre, const Point& size, double time);

/// What a shape gives to the air, or takes from it.
struct FieldSource {
    std::shared_ptr<const Shape> shape;
    double heat = 0;   ///< of potential temperature [K/s]
    double water = 0;  ///< [kg/kg/s]
    double dye = 0;    ///< [1/s]
    double fuel = 0;   ///< [1/s]
    double rate = 0;   ///< at which air returns to `velocity` and `temperature` [1/s]; 0: it does not
    bool has_velocity = false, has_temperature = false;
    std::array<double, 3> velocity{0, 0, 0};                 ///< over the ground [m/s]
    double temperature = 0;                                  ///< [K]
    double from = 0;                                         ///< [s]
    double until = std::numeric_limits<double>::infinity();  ///< [s], after `from`
    double ramp = 0;  ///< in which the strength rises after `from` and falls before `until` [s]

    /// Times that steps do not pass.
    std::vector<double> step_ends() const;
    /// 0 to 1 at time `t` of a step that begins at `step`: steps end at `from` and `until`.
    double strength(double step, double t) const;
};

}  // namespace vdbcloud::sim
