// Sources and sinks of shapes: rates of heat, water, dye and fuel, and air that is held at a velocity or a temperature.
// A sink takes no more than there is. Air is held by the factor exp(-rate weight dt), before the projection of a step.
#include "vdbcloud/sim/air.h"
#include "vdbcloud/sim/effect.h"

#include "vdbcloud/core/refuse.h"

#include <algorithm>
#include <cmath>
#include <memory>

namespace vdbcloud::sim::effect {

namespace {

/// Weights of a shape at the places of one field, those above 0 alone, row by row.
struct Mask {
    std::vector<size_t> row;  // where row (j, k) begins, and the end
    std::vector<int> cell;
    std::vector<double> weight;
};

/// Positions over the ground along an axis; beyond periodic sides the ground is that of the opposite side.
template<typename T>
std::vector<double> positions(const Air<T>& air, int axis, int count, double shift, double moved)
{
    const Lattice& l = air.lattice;
    const double h = l.h[size_t(axis)], length = l.n[size_t(axis)] * h;
    std::vector<double> list;
    for (int i = 0; i < count; ++i) {
        double x = (i + shift) * h + moved;
        if (moved != 0 && axis < 2 && l.side[size_t(axis)] == Side::Periodic) x -= length * std::floor(x / length);
        list.push_back(x);
    }
    return list;
}

template<typename T>
Mask mask_of(const Air<T>& air, const Shape& shape, Place place, double time)
{
    const Lattice& l = air.lattice;
    const auto moved = air.moved(time);
    const auto shift = [&](Place face) { return place == face ? 0.0 : 0.5; };
    const int width = place == Place::FaceX ? l.faces(0) : l.n[0], rows = place == Place::FaceY ? l.faces(1) : l.n[1];
    const auto x = positions(air, 0, width, shift(Place::FaceX), moved[0]),
               y = positions(air, 1, rows, shift(Place::FaceY), moved[1]),
               z = positions(air, 2, l.n[2], shift(Place::FaceZ), 0);
    const auto bounds = shape.bounds();
    const auto near = [&](double at, size_t axis) {
        return at >= bounds[0][axis] - l.h[axis] && at <= bounds[1][axis] + l.h[axis];
    };
    Mask mask;
    for (const double zk : z)
        for (const double yj : y) {
            mask.row.push_back(mask.cell.size());
            if (!near(zk, 2) || !near(yj, 1)) continue;
            for (int i = 0; i < width; ++i) {
                if (!near(x[size_t(i)], 0)) continue;
                if (place == Place::Centre && air.bodies &&
                    air.bodies.solid[mask.row.size() * size_t(width) - size_t(width) + size_t(i)])
                    continue;
                const double weight = weight_in(shape, {x[size_t(i)], yj, zk}, l.h, time);
                if (weight > 0) mask.cell.push_back(i), mask.weight.push_back(weight);
            }
        }
    mask.row.push_back(mask.cell.size());
    return mask;
}

/// Calls f(cell, weight) for the cells of a row in the mask.
template<typename F>
void visit(const Mask& mask, size_t row, const F& f)
{
    for (size_t n = mask.row[row]; n < mask.row[row + 1]; ++n) f(mask.cell[n], mask.weight[n]);
}

/// The weights at one place, made again before each stage where they change.
template<typename T>
std::shared_ptr<Mask> kept_mask(Air<T>& air, const FieldSource& source, Place place)
{
    auto mask = std::make_shared<Mask>();
    const Shape& shape = *source.shape;
    if (!air.moves() && !shape.changes()) {
        *mask = mask_of(air, shape, place, 0);
        return mask;
    }
    air.before_stage.push_back([&air, &source, mask, place](int) {
        if (source.strength(air.time, air.stage_time) > 0 || mask->row.empty())
            *mask = mask_of(air, *source.shape, place, air.stage_time);
    });
    return mask;
}

template<typename T>
void add_rate(Air<T>& air, Variable<T>& v, const FieldSource& source, double rate, std::shared_ptr<Mask>& mask)
{
    if (!v || rate == 0) return;
    if (!mask) mask = kept_mask(air, source, Place::Centre);
    auto& list = rate > 0 ? v.terms : v.sinks;
    list.push_back([&air, &source, rate, mask, rows = air.rows(v)](int, int j, int k, T* out) {
        const double now = rate * source.strength(air.time, air.stage_time);
        if (now == 0) return;
        visit(*mask, size_t(k) * size_t(rows) + size_t(j), [&](int i, double w) { out[i] += T(now * w); });
    });
}

/// Air returns to `target`, in the units of the field, by level.
template<typename T>
void add_hold(Air<T>& air, Variable<T>& v, const FieldSource& source, std::vector<double> target,
              const std::shared_ptr<Mask>& mask)
{
    v.holds.push_back(
        [&air, &source, mask, target = std::move(target), rows = air.rows(v)](double dt, int j, int k, T* out) {
            const double rate = source.rate * source.strength(air.time, air.time + 0.5 * dt), to = target[size_t(k)];
            if (rate == 0) return;
            visit(*mask, size_t(k) * size_t(rows) + size_t(j), [&](int i, double w) {
                out[i] = T(double(out[i]) - std::expm1(-rate * w * dt) * (to - double(out[i])));
            });
        });
}

template<typename T>
void add(Air<T>& air)
{
    const size_t nz = size_t(air.lattice.n[2]);
    for (const FieldSource& source : air.parameters.sources) {
        std::shared_ptr<Mask> centre;
        add_rate(air, air.theta, source, source.heat, centre);
        add_rate(air, air.water, source, source.water, centre);
        add_rate(air, air.dye, source, source.dye, centre);
        add_rate(air, air.fuel, source, source.fuel, centre);
        if (source.has_temperature && air.theta) {
            std::vector<double> target;
            for (const Level& level : air.column.level)
                target.push_back(source.temperature /
                                     (air.parameters.moist.by == SaturationBy::Temperature ? level.exner : 1) -
                                 air.reference(Quantity::Theta));
            if (!centre) centre = kept_mask(air, source, Place::Centre);
            add_hold(air, air.theta, source, target, centre);
        }
        if (source.has_velocity)
            for (const size_t axis : {0, 1, 2}) {
                Variable<T>& v = air.wind[axis];
                if (!v) continue;
                const double target = source.velocity[axis] - air.reference(v.quantity);
                add_hold(air, v, source, std::vector<double>(nz, target), kept_mask(air, source, v.place));
            }
        for (const double time : source.step_ends()) air.step_ends.push_back(time);
    }
}

void expect(const char* name, double value, const Range& range, const char* unit)
{
    if (!range.holds(value)) refuse(std::string("source: ") + name, value, range.text() + " " + unit);
}

void check(const Parameters& p)
{
    for (const FieldSource& s : p.sources) {
        expect("heat", s.heat, magnitude(1e6), "K/s");
        expect("water", s.water, magnitude(10), "kg/kg/s");
        expect("dye", s.dye, magnitude(1e6), "1/s");
        expect("fuel", s.fuel, magnitude(1e6), "1/s");
        expect("rate", s.rate, from_zero(1e12), "1/s");
        for (const double v : s.velocity) expect("velocity", v, magnitude(allowed_speed), "m/s");
        if (s.has_temperature) expect("temperature", s.temperature, {50, 1e4}, "K");
        expect("from", s.from, from_zero(1e12), "s");
        expect("until", s.until, {s.from, never, true}, "s");
        expect("ramp", s.ramp, from_zero((s.until - s.from) / 2), "s, half of its time at most");
        const auto lacks = [&](bool given, bool has, const char* what) {
            if (given && !has) throw InputError(std::string("source of ") + what + ": this run has none");
        };
        const bool heat = p.buoyancy || p.moisture;
        lacks(s.heat != 0 || s.has_temperature, heat, "heat");
        lacks(s.water != 0, p.moisture, "water");
        lacks(s.dye != 0, p.dye, "dye");
        lacks(s.fuel != 0, p.combustion.on, "fuel");
        lacks(s.has_velocity, p.momentum, "momentum");
    }
}

}  // namespace

Effect sources()
{
    return changeable({"sources",
                       "weights of the cells within them",
                       {},
                       [](const Parameters& p) { return !p.sources.empty(); },
                       check,
                       nullptr,
                       {add<float>, add<double>},
                       0,
                       "source"});
}

}  // namespace vdbcloud::sim::effect
