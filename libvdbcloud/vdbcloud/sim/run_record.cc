#include "vdbcloud/sim/run_record.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/grid/digest.h"
#include "vdbcloud/sim/effect.h"
#include "vdbcloud/sim/words.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace vdbcloud::sim {

namespace {

std::string exact(double x)
{
    char text[40];
    for (int digits = 6; digits <= 17; ++digits) {
        std::snprintf(text, sizeof text, "%.*g", digits, x);
        if (std::strtod(text, nullptr) == x) break;
    }
    return text;
}

std::string list_of(const std::vector<double>& values)
{
    std::string text;
    for (const double x : values) text += (text.empty() ? "" : ",") + exact(x);
    return text;
}

/// A list that grows by values of one kind.
struct Values {
    std::vector<RunValue>& list;
    bool can_change;

    void word(const std::string& name, const std::string& text) const { list.push_back({name, text, can_change}); }
    void flag(const std::string& name, bool on) const { word(name, on ? "on" : "off"); }
    void number(const std::string& name, double x) const { word(name, exact(x)); }
    void numbers(const std::string& name, const std::vector<double>& values) const { word(name, list_of(values)); }
    void setting(const Setting& s, const Parameters& p) const
    {
        s.kind == Setting::Kind::Switch ? flag(s.key(), s.on(p)) : number(s.key(), s.number(p));
    }
    /// All of a list in one value: "none", or "1,2;3,4".
    template<typename Item, typename Numbers>
    void items(const std::string& name, const std::vector<Item>& items, const Numbers& numbers_of) const
    {
        std::string text;
        for (const Item& item : items) text += (text.empty() ? "" : ";") + list_of(numbers_of(item));
        word(name, text.empty() ? "none" : text);
    }
};

void describe_numerics(const Parameters& p, std::vector<RunValue>& list)
{
    const Values fixed{list, false}, free{list, true};
    const Lattice& l = p.lattice;
    fixed.numbers("cells", {double(l.n[0]), double(l.n[1]), double(l.n[2])});
    fixed.numbers("spacing", {l.h[0], l.h[1], l.h[2]});
    fixed.word("side_x", side_words.word(l.side[0]));
    fixed.word("side_y", side_words.word(l.side[1]));
    fixed.word("precision", precision_words.word(p.precision));
    fixed.word("time_scheme", time_scheme_words.word(p.time_scheme));
    fixed.word("scalar_scheme", scalar_scheme_words.word(p.scalar_scheme));
    fixed.word("momentum_scheme", momentum_scheme_words.word(p.momentum_scheme));
    fixed.flag("maccormack", p.maccormack), fixed.flag("fix_budget", p.fix_budget);
    std::string colliders;
    for (const auto& shape : p.colliders) colliders += (colliders.empty() ? "" : ";") + shape->identity();
    fixed.word("collider", colliders.empty() ? "none" : colliders);
    fixed.numbers("frame_velocity", {p.frame[0], p.frame[1]});
    fixed.word("saturation", saturation_words.word(p.moist.by));
    for (const Setting& setting : numeric_settings()) free.setting(setting, p);
}

void describe_air(const Parameters& p, const Sounding& s, std::vector<RunValue>& list)
{
    const Values fixed{list, false}, free{list, true};
    for (const auto* group : {&constant_settings(), &noise_settings()})
        for (const Setting& setting : *group) fixed.setting(setting, p);
    for (const Effect& effect : effects())
        for (const Setting& setting : effect.settings) (effect.can_change ? free : fixed).setting(setting, p);
    free.items("patch", p.floor.patches, [](const Patch& f) {
        std::vector<double> numbers{f.centre[0], f.centre[1], f.radius, f.heat, f.moisture, f.dye};
        if (f.fuel != 0) numbers.push_back(f.fuel);
        return numbers;
    });
    std::string sources;
    for (const FieldSource& f : p.sources) {
        std::vector<double> numbers{f.heat, f.water, f.dye, f.fuel, f.from, f.until, f.ramp, f.rate};
        if (f.has_velocity) numbers.insert(numbers.end(), f.velocity.begin(), f.velocity.end());
        if (f.has_temperature) numbers.push_back(f.temperature);
        sources += (sources.empty() ? "" : ";") + f.shape->identity() + "," + list_of(numbers);
    }
    free.word("source", sources.empty() ? "none" : sources);
    Digest map;
    map.add(p.floor.map.data(), p.floor.map.size() * sizeof(double));
    free.word("floor_map_digest", p.floor.map.empty() ? "none" : map.hex());
    const LargeScale& f = p.large_scale;
    free.word("forcing", f.z.empty() ? "none" : f.name);
    for (const auto& [name, column] : {std::pair{"z", &f.z},
                                       {"w", &f.w},
                                       {"u_g", &f.u_g},
                                       {"v_g", &f.v_g},
                                       {"theta", &f.theta},
                                       {"water", &f.water}})
        free.numbers(std::string("forcing_") + name, *column);
    fixed.items("bubble", p.bubbles, [](const Bubble& b) -> std::vector<double> {
        return {b.centre[0], b.centre[1], b.centre[2], b.radius, b.height, b.theta, b.water, b.dye};
    });
    fixed.word("seed", std::to_string(p.noise.seed));
    fixed.word("sounding", s.name);
    fixed.numbers("sounding_z", s.z), fixed.numbers("sounding_theta", s.theta);
    fixed.numbers("sounding_water", s.water);
    // Air that moves by its forces meets another wind of the environment; a given wind is part of the state.
    const Values& wind = p.momentum ? free : fixed;
    wind.numbers("sounding_u", s.u), wind.numbers("sounding_v", s.v);
    fixed.number("sounding_pressure", s.pressure);
}

void describe_frames(const FramePlan& plan, std::vector<RunValue>& list)
{
    const Values fixed{list, false}, free{list, true};
    const SnapshotOptions& o = plan.snapshot;
    std::string grids;
    for (const std::string& name : o.grids) grids += (grids.empty() ? "" : ",") + name;
    fixed.word("init", plan.init);
    fixed.word("up", up_axis_words.word(o.up));
    fixed.number("first_frame", plan.first_frame);
    free.number("every", plan.every);
    free.word("grids", grids.empty() ? "all" : grids);
    free.flag("unpruned", o.unpruned);
    free.number("effective_radius", o.effective_radius);
    free.number("smoke_extinction", o.smoke_extinction);
}

const RunValue* find(const RunRecord& record, const std::string& name)
{
    const auto found = std::find_if(record.values.begin(), record.values.end(),
                                    [&](const RunValue& value) { return value.name == name; });
    return found == record.values.end() ? nullptr : &*found;
}

}  // namespace

double Schedule::time_of(int frame) const { return std::min(end, start + (frame - first) * every); }

int Schedule::last() const { return first + int(std::ceil(std::max(0.0, end - start) / every - 1e-9)); }

std::string RunRecord::text() const
{
    std::string text;
    for (const RunValue& value : values) text += value.name + " = " + value.value + "\n";
    return text;
}

RunRecord describe(const Parameters& p, const Sounding& s, const FramePlan& plan)
{
    Parameters in_force = p;
    if (p.q_scale_height == 0) in_force.q_scale_height = p.lattice.n[2] * p.lattice.h[2] / std::log(10.0);
    RunRecord record;
    describe_numerics(in_force, record.values);
    describe_air(in_force, s, record.values);
    describe_frames(plan, record.values);
    return record;
}

void continue_record(const std::string& path, const RunRecord& before, double time, bool change, RunRecord& now)
{
    now.changes = before.changes;
    const auto compare = [&](const std::string& name) {
        const RunValue *was = find(before, name), *is = find(now, name);
        const std::string old = was ? was->value : "nothing", fresh = is ? is->value : "nothing";
        if (was && is && old == fresh) return;
        const bool can_change = was && is && is->can_change;
        if (!change || !can_change)
            throw UsageError(path + ": the checkpoint has '" + printable(name + " = " + old, 100) +
                             "', this run has '" + printable(name + " = " + fresh, 100) + "': expected equal values" +
                             (can_change ? ", or --change for the new one from here on"
                                         : ", as this one cannot change within a run: a new run takes it, from the "
                                           "last frame by --init"));
        now.changes.push_back("after " + exact(time) + " s: " + name + " = " + old + " -> " + fresh);
    };
    for (const RunValue& value : before.values) compare(value.name);
    for (const RunValue& value : now.values)
        if (!find(before, value.name)) compare(value.name);
}

}  // namespace vdbcloud::sim
