#pragma once
// Shapes of the tests: bodies and masks in closed form.
#include "vdbcloud/sim/shape.h"

#include <cmath>
#include <functional>
#include <memory>

namespace vdbcloud::sim::test {

class ClosedForm final : public Shape {
public:
    using Function = std::function<double(const Point&, double)>;

    ClosedForm(bool body, Function f, std::array<Point, 2> bounds, bool changes = false)
        : body_(body), changes_(changes), f_(std::move(f)), bounds_(bounds)
    {
    }
    bool body() const override { return body_; }
    double distance(const Point& p) const override { return f_(p, 0); }
    double value(const Point& p, double time) const override { return f_(p, time); }
    bool changes() const override { return changes_; }
    std::array<Point, 2> bounds() const override { return bounds_; }
    std::string identity() const override { return "test"; }

private:
    bool body_, changes_;
    Function f_;
    std::array<Point, 2> bounds_;
};

inline constexpr std::array<Point, 2> everywhere{Point{-1e9, -1e9, -1e9}, Point{1e9, 1e9, 1e9}};

inline std::shared_ptr<const Shape> ball(const Point& at, double radius)
{
    const std::array<Point, 2> bounds{Point{at[0] - radius, at[1] - radius, at[2] - radius},
                                      Point{at[0] + radius, at[1] + radius, at[2] + radius}};
    return std::make_shared<ClosedForm>(
        true, [=](const Point& p, double) { return std::hypot(p[0] - at[0], p[1] - at[1], p[2] - at[2]) - radius; },
        bounds);
}

inline std::shared_ptr<const Shape> body(ClosedForm::Function distance)
{
    return std::make_shared<ClosedForm>(true, std::move(distance), everywhere);
}

inline std::shared_ptr<const Shape> mask(ClosedForm::Function f, bool changes = false)
{
    return std::make_shared<ClosedForm>(false, std::move(f), everywhere, changes);
}

}  // namespace vdbcloud::sim::test
