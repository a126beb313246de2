// What a run is: every value that users can set is in its record, and differences are refused or noted.
#include "shapes.h"

#include "vdbcloud/sim/run_record.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/sim/effect.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace vdbcloud::sim {
namespace {

struct Choice {
    Parameters p;
    Sounding s = Sounding::uniform(300);
    FramePlan plan;
};

/// Names of the values in which the record of a changed run differs, and whether each can change.
std::vector<std::pair<std::string, bool>> differences(const std::function<void(Choice&)>& change)
{
    Choice before, after;
    change(after);
    const RunRecord a = describe(before.p, before.s, before.plan), b = describe(after.p, after.s, after.plan);
    std::vector<std::pair<std::string, bool>> names;
    EXPECT_EQ(a.values.size(), b.values.size());
    for (size_t i = 0; i < a.values.size(); ++i) {
        EXPECT_EQ(a.values[i].name, b.values[i].name);
        if (a.values[i].value != b.values[i].value) names.emplace_back(a.values[i].name, b.values[i].can_change);
    }
    return names;
}

using Names = std::vector<std::pair<std::string, bool>>;

/// Changes one setting to another value in its range.
std::function<void(Choice&)> changed(const Setting& setting)
{
    return [&setting](Choice& run) {
        if (setting.kind == Setting::Kind::Switch) {
            setting.flag(run.p) = !setting.flag(run.p);
            return;
        }
        double& value = setting.value(run.p);
        value = std::isfinite(value) && value != 0 ? value * 1.0000001 : 1.5;  // the seventh digit counts
    };
}

TEST(RunRecord, HoldsEverySettingUnderItsName)
{
    for (const Setting& setting : numeric_settings())
        EXPECT_EQ(differences(changed(setting)), (Names{{setting.key(), true}}));
    for (const auto* group : {&constant_settings(), &noise_settings()})
        for (const Setting& setting : *group)
            EXPECT_EQ(differences(changed(setting)), (Names{{setting.key(), false}})) << setting.key();
    size_t forcing = 0;
    for (const Effect& effect : effects())
        for (const Setting& setting : effect.settings) {
            EXPECT_EQ(differences(changed(setting)), (Names{{setting.key(), effect.can_change}})) << setting.key();
            forcing += effect.can_change;
        }
    EXPECT_GE(forcing, 15u);
}

TEST(RunRecord, HoldsWhatNoSettingHolds)
{
    const struct {
        const char* name;
        bool can_change;
        std::function<void(Choice&)> change;
    } cases[] = {
        {"cells", false, [](Choice& r) { r.p.lattice.n[1] = 1; }},
        {"spacing", false, [](Choice& r) { r.p.lattice.h[0] = 31; }},
        {"side_x", false, [](Choice& r) { r.p.lattice.side[0] = Side::Open; }},
        {"side_y", false, [](Choice& r) { r.p.lattice.side[1] = Side::Wall; }},
        {"precision", false, [](Choice& r) { r.p.precision = Precision::Double; }},
        {"time_scheme", false, [](Choice& r) { r.p.time_scheme = TimeScheme::Rk2; }},
        {"scalar_scheme", false, [](Choice& r) { r.p.scalar_scheme = ScalarScheme::Koren; }},
        {"momentum_scheme", false, [](Choice& r) { r.p.momentum_scheme = MomentumScheme::Upwind; }},
        {"maccormack", false, [](Choice& r) { r.p.maccormack = true; }},
        {"fix_budget", false, [](Choice& r) { r.p.fix_budget = true; }},
        {"collider", false,
         [](Choice& r) {
             r.p.colliders.push_back(test::ball({0, 0, 0}, 1));
         }},
        {"frame_velocity", false,
         [](Choice& r) {
             r.p.frame = {1, 2};
         }},
        {"saturation", false, [](Choice& r) { r.p.moist.by = SaturationBy::Height; }},
        {"patch", true, [](Choice& r) { r.p.floor.patches.push_back({}); }},
        {"source", true,
         [](Choice& r) {
             r.p.sources.push_back({test::ball({0, 0, 0}, 1)});
         }},
        {"floor_map_digest", true,
         [](Choice& r) {
             r.p.floor.map = {1, 2};
         }},
        {"bubble", false, [](Choice& r) { r.p.bubbles.push_back({}); }},
        {"seed", false, [](Choice& r) { r.p.noise.seed = 2; }},
        {"sounding", false, [](Choice& r) { r.s.name = "other"; }},
        {"sounding_z", false, [](Choice& r) { r.s.z[0] = 1; }},
        {"sounding_theta", false, [](Choice& r) { r.s.theta[0] = 301; }},
        {"sounding_water", false, [](Choice& r) { r.s.water[0] = 1e-9; }},
        {"sounding_u", true, [](Choice& r) { r.s.u[0] = -1; }},
        {"sounding_v", true, [](Choice& r) { r.s.v[0] = -1; }},
        {"sounding_pressure", false, [](Choice& r) { r.s.pressure = 9e4; }},
        {"init", false, [](Choice& r) { r.plan.init = "abc"; }},
        {"up", false, [](Choice& r) { r.plan.snapshot.up = UpAxis::Z; }},
        {"first_frame", false, [](Choice& r) { r.plan.first_frame = 1; }},
        {"every", true, [](Choice& r) { r.plan.every = 9; }},
        {"grids", true, [](Choice& r) { r.plan.snapshot.grids = {"vel"}; }},
        {"unpruned", true, [](Choice& r) { r.plan.snapshot.unpruned = true; }},
        {"effective_radius", true, [](Choice& r) { r.plan.snapshot.effective_radius = 2e-5; }},
        {"smoke_extinction", true, [](Choice& r) { r.plan.snapshot.smoke_extinction = 1; }},
    };
    for (const auto& c : cases) EXPECT_EQ(differences(c.change), (Names{{c.name, c.can_change}})) << c.name;
    // A given wind is part of the state of the air.
    EXPECT_FALSE(differences([](Choice& r) { r.p.momentum = false, r.s.u[0] = -1; }).back().second);
    // Two patches in one order are not the same two in the other.
    const Patch one{{1, 2}, 3, 4, 5, 6}, two{{7, 8}, 9, 1, 2, 3};
    Choice a, b;
    a.p.floor.patches = {one, two}, b.p.floor.patches = {two, one};
    EXPECT_NE(describe(a.p, a.s, a.plan).text(), describe(b.p, b.s, b.plan).text());
    EXPECT_NE(describe(a.p, a.s, a.plan).text().find("patch = 1,2,3,4,5,6;7,8,9,1,2,3\n"), std::string::npos);
}

TEST(RunRecord, DifferencesAreRefusedOrNotedWithTheirTime)
{
    const Choice first;
    Choice forced = first, other = first;
    forced.p.floor.heat = 0.1, forced.plan.every = 20;
    other.p.constants.g = 5, other.p.floor.heat = 0.1;
    const auto record = [](const Choice& run) { return describe(run.p, run.s, run.plan); };
    const auto refusal = [&](const Choice& run, bool change) -> std::string {
        RunRecord now = record(run);
        try {
            continue_record("state", record(first), 600, change, now);
        } catch (const UsageError& error) {
            return error.what();
        }
        return "";
    };
    EXPECT_EQ(refusal(first, false), "");
    EXPECT_EQ(refusal(first, true), "");
    EXPECT_EQ(refusal(forced, false), "state: the checkpoint has 'heat_flux = 0', this run has 'heat_flux = 0.1': "
                                      "expected equal values, or --change for the new one from here on");
    EXPECT_EQ(refusal(forced, true), "");
    for (const bool change : {false, true})
        EXPECT_EQ(refusal(other, change), "state: the checkpoint has 'gravity = 9.81', this run has 'gravity = 5': "
                                          "expected equal values, as this one cannot change within a run: a new run "
                                          "takes it, from the last frame by --init");
    // What was noted before stays, and comes first.
    RunRecord before = record(first), now = record(forced);
    before.changes = {"after 60 s: earlier"};
    continue_record("state", before, 600, true, now);
    EXPECT_EQ(now.changes, (std::vector<std::string>{"after 60 s: earlier", "after 600 s: heat_flux = 0 -> 0.1",
                                                     "after 600 s: every = 10 -> 20"}));
    // A value that one of the two versions does not know is never passed over.
    now = record(first), before = record(first);
    before.values.push_back({"unknown", "1", true});
    EXPECT_THROW(continue_record("state", before, 600, true, now), UsageError);
    now.values.push_back({"fresh", "1", true});
    EXPECT_THROW(continue_record("state", record(first), 600, true, now), UsageError);
}

TEST(RunRecord, SchedulesCountFramesFromTheirStart)
{
    const Schedule plain{30, 100};
    EXPECT_EQ(plain.last(), 4);
    EXPECT_EQ(plain.time_of(3), 90);
    EXPECT_EQ(plain.time_of(4), 100);
    const Schedule later{20, 200, 4, 100};
    EXPECT_EQ(later.last(), 9);
    EXPECT_EQ(later.time_of(5), 120);
    EXPECT_EQ(later.time_of(9), 200);
    const Schedule done{20, 50, 4, 100};
    EXPECT_EQ(done.last(), 4);
    const Schedule tenths{0.1, 0.3};
    EXPECT_EQ(tenths.last(), 3);  // and no fourth frame of rounding
}

}  // namespace
}  // namespace vdbcloud::sim
