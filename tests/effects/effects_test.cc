// Which effects are in play, and why: the criterion of each, on both sides.
#include "vdbcloud/effects/effects.h"

#include "vdbcloud/core/vdb.h"

#include <gtest/gtest.h>

#include <functional>
#include <set>
#include <string>
#include <vector>

namespace vdbcloud {
namespace {

using Mode = EffectsAsked::Mode;

/// A grid of one active voxel.
template<typename GridT>
typename GridT::Ptr voxel(const typename GridT::ValueType& value)
{
    const auto grid = GridT::create();
    grid->tree().setValue(openvdb::Coord(0, 0, 0), value);
    return grid;
}

const FloatGridPtr matter = voxel<FloatGrid>(1.0f), vacuum = voxel<FloatGrid>(0.0f);

Vec3SGridPtr colour(float r, float g, float b) { return voxel<Vec3SGrid>(Vec3f(r, g, b)); }

/// A grey, isotropic medium in white sunlight, with neither sky nor ground nor solids.
EffectFacts plain(EffectStage stage)
{
    EffectFacts facts;
    facts.stage = stage;
    MediumFacts medium;
    medium.density = matter.get();
    medium.medium.sigma_t_per_density = Vec3d(1);
    medium.medium.albedo = Vec3d(0.9);
    medium.medium.phase = PhaseFunction::henyey_greenstein(0);
    facts.media = {medium};
    facts.lights = {make_sun(Vec3d(0, 1, 0))};
    facts.share = [] { return ShareFound{0.5, 0.01}; };
    return facts;
}

EffectsAsked asked(Mode mode, const std::vector<Effect>& list = {})
{
    EffectsAsked all;
    all.mode = mode;
    for (const Effect effect : list) all.list[size_t(effect)] = true;
    return all;
}

using Change = std::function<void(EffectFacts&)>;

/// How an effect comes into play in a scene without it, and how it is there and adds nothing; null where that cannot
/// be.
struct Row {
    Effect effect;
    Change on, idle;
};

const Vec3SGridPtr glowing = colour(0, 1, 0), dark = colour(0, 0, 0), red = colour(1, 0.5f, 0.5f),
                   white = colour(1, 1, 1);

const std::vector<Row>& rows()
{
    static const std::vector<Row> all = {
        {Effect::Lights, [](EffectFacts& f) { f.lights = {make_lamp(Vec3d(0), Vec3d(0, 0, 1e-9))}; },
         [](EffectFacts& f) { f.lights = {make_lamp(Vec3d(0), Vec3d(0.0))}; }},
        {Effect::Emission, [](EffectFacts& f) { f.media[0].emission = glowing.get(); },
         [](EffectFacts& f) { f.media[0].emission = dark.get(); }},
        {Effect::Sky, [](EffectFacts& f) { f.sky = Sky::constant(Vec3d(0, 0, 1e-9)); }, {}},
        {Effect::Ground, [](EffectFacts& f) { f.ground_albedo = 0.0; }, {}},
        {Effect::Solids, [](EffectFacts& f) { f.solids = {make_ball(Vec3d(1e6), 1)}; }, {}},
        {Effect::Tint, [](EffectFacts& f) { f.media[0].tint = red.get(); },
         [](EffectFacts& f) { f.media[0].tint = white.get(); }},
        {Effect::Multiple, [](EffectFacts&) {}, [](EffectFacts& f) { f.share = [] {
                                                                         return ShareFound{0.019, 0};
                                                                     }; }},
        {Effect::Colour, [](EffectFacts& f) { f.media[0].medium.sigma_t_per_density = Vec3d(1, 1, 1.001); }, {}},
        {Effect::Anisotropy, [](EffectFacts& f) { f.media[0].medium.phase = PhaseFunction("rayleigh"); }, {}},
        {Effect::Mixture, [](EffectFacts& f) { f.media.push_back(f.media[0]); }, {}},
        {Effect::Periodic, [](EffectFacts& f) { f.periodic[2] = true; }, {}},
    };
    return all;
}

/// A scene without the effect.
EffectFacts without(Effect effect)
{
    EffectFacts facts = plain(EffectStage::Scatter);
    if (effect == Effect::Lights) facts.lights.clear();
    if (effect == Effect::Multiple) facts.media[0].medium.albedo = Vec3d(0.0);
    return facts;
}

TEST(Effects, EachIsOnWhereItAddsLightAndElseOff)
{
    std::set<Effect> known;
    for (const Row& row : rows()) {
        known.insert(row.effect);
        const std::string name = effect_names()[size_t(row.effect)].name;
        EffectFacts facts = without(row.effect);
        EXPECT_FALSE(Effects(facts, {}).on(row.effect)) << name;
        EXPECT_FALSE(Effects(facts, asked(Mode::All)).on(row.effect) && row.effect != Effect::Multiple) << name;
        if (row.effect == Effect::Multiple) facts = plain(EffectStage::Scatter);
        row.on(facts);
        EXPECT_TRUE(Effects(facts, {}).on(row.effect)) << name;
        if (!row.idle) continue;
        row.idle(facts);
        const Effects idle(facts, {}), forced(facts, asked(Mode::All));
        EXPECT_FALSE(idle.on(row.effect)) << name;
        EXPECT_TRUE(forced.on(row.effect)) << name;
    }
    EXPECT_EQ(known.size(), effect_names().size()) << "an effect without a row";
}

TEST(Effects, HaveTheNamesAndTheOrderOfTheEnumeration)
{
    ASSERT_EQ(effect_names().size(), effect_count);
    std::set<std::string> names;
    for (size_t k = 0; k < effect_count; ++k) {
        EXPECT_EQ(size_t(effect_names()[k].effect), k);
        EXPECT_TRUE(names.insert(effect_names()[k].name).second);
    }
}

TEST(Effects, AListLeavesOutTheOptionalOnesThatItLacks)
{
    for (const Row& row : rows()) {
        EffectFacts facts = plain(EffectStage::Scatter);
        row.on(facts);
        const bool optional = effect_names()[size_t(row.effect)].optional;
        const Effects others(facts, asked(Mode::List)), own(facts, asked(Mode::List, {row.effect, Effect::Lights}));
        EXPECT_EQ(others.on(row.effect), !optional) << effect_names()[size_t(row.effect)].name;
        EXPECT_EQ(others[row.effect].left_out, optional) << effect_names()[size_t(row.effect)].name;
        EXPECT_TRUE(own.on(row.effect)) << effect_names()[size_t(row.effect)].name;
    }
}

TEST(Effects, LightsWithoutPowerOrReachAreLeftOutOneByOne)
{
    EffectFacts facts = plain(EffectStage::Scatter);
    facts.lights.push_back(make_lamp(Vec3d(0), Vec3d(0.0)));
    facts.lights.push_back(make_spot(Vec3d(0), Vec3d(1, 0, 0)));
    facts.hidden = {false, false, true};
    const Effects effects(facts, {});
    EXPECT_EQ(effects.lights(), (std::vector<bool>{true, false, false}));
    EXPECT_EQ(effects[Effect::Lights].why, "sun; lamp has no power, spot reaches no voxel");
    EXPECT_EQ(effects.lights_in_play(facts.lights).size(), 1u);
    EXPECT_EQ(Effects(facts, asked(Mode::All)).lights_in_play(facts.lights).size(), 3u);
    facts.lights_shown = true;
    EXPECT_EQ(Effects(facts, {}).lights(), (std::vector<bool>{true, true, false})) << "a layer for each light";
}

// Skipping errs by at most the share that is skipped: an estimate that may be above the limit is not skipped.
TEST(Effects, MultipleScatteringIsSkippedBelowTheErrorWithTwoStandardErrorsToSpare)
{
    EffectFacts facts = plain(EffectStage::Scatter);
    const struct {
        double share, error, accuracy;
        bool on;
    } table[] = {{0.0199, 0, 0.02, false},     {0.0201, 0, 0.02, true},     {0.018, 0.0011, 0.02, true},
                 {0.018, 0.0009, 0.02, false}, {0.018, 0.0009, 0.01, true}, {0, 0, 0, true}};
    for (const auto& row : table) {
        facts.accuracy = row.accuracy;
        facts.share = [&] { return ShareFound{row.share, row.error}; };
        const Effects effects(facts, {});
        EXPECT_EQ(effects.on(Effect::Multiple), row.on) << row.share << " " << row.error << " " << row.accuracy;
        ASSERT_TRUE(effects.share());
        EXPECT_EQ(effects.share()->share, row.share);
    }
    facts.accuracy = 0.02;
    facts.share = [] { return ShareFound{0.0031, 0}; };
    EXPECT_EQ(Effects(facts, {})[Effect::Multiple].why, "an expected 0.31 % of scattered light, below 2 %");
}

// Sweeps bring the light of solids, which the share of the medium's own scattering does not count.
TEST(Effects, SweptSolidsThatSendLightNeedMultipleScattering)
{
    EffectFacts facts = plain(EffectStage::Scatter);
    facts.share = [] { return ShareFound{0.001, 0}; };
    Material black, grey, chequered;
    black.colour = Vec3d(0.0);
    chequered.checker = Vec3d(0.5, 0.1, 0.1);
    facts.solids = {make_ball(Vec3d(3, 0, 0), 1, grey)};
    EXPECT_FALSE(Effects(facts, {}).on(Effect::Multiple)) << "P1 alone sees no walls";
    facts.walls = true;
    EXPECT_TRUE(Effects(facts, {}).on(Effect::Multiple));
    EXPECT_FALSE(Effects(facts, {}).on(Effect::Colour));
    facts.solids.push_back(make_ball(Vec3d(3, 4, 0), 1, chequered));
    EXPECT_TRUE(Effects(facts, {}).on(Effect::Colour));
    facts.solids = {make_ball(Vec3d(3, 0, 0), 1, black)};
    EXPECT_FALSE(Effects(facts, {}).on(Effect::Multiple));
    facts.solids = {make_ball(Vec3d(3, 0, 0), 1, grey)};
    facts.lights = {make_lamp(Vec3d(0), Vec3d(0.0))};
    EXPECT_FALSE(Effects(facts, {}).on(Effect::Multiple)) << "no light";
}

// phi brings all scattered light of sky, ground and emission, also what is scattered once.
TEST(Effects, MultipleScatteringIsOnForSkyGroundAndEmissionWhateverItsShare)
{
    for (const Effect effect : {Effect::Sky, Effect::Ground, Effect::Emission}) {
        EffectFacts facts = plain(EffectStage::Scatter);
        facts.share = []() -> ShareFound { throw std::logic_error("nobody needs the share"); };
        rows()[size_t(effect)].on(facts);
        EXPECT_TRUE(Effects(facts, {}).on(Effect::Multiple)) << effect_names()[size_t(effect)].name;
        EXPECT_FALSE(Effects(facts, asked(Mode::List, {effect})).on(Effect::Multiple)) << "left out on request";
    }
    EffectFacts facts = plain(EffectStage::Scatter);
    facts.media[0].emission = glowing.get();
    facts.media[0].medium.albedo = Vec3d(0.0);
    EXPECT_FALSE(Effects(facts, {}).on(Effect::Multiple)) << "nothing scatters the emission";
    facts.needed_by = "--flux-map";
    EXPECT_TRUE(Effects(facts, {}).on(Effect::Multiple));
    facts.needed_by.clear();
    facts.media[0].density = vacuum.get();
    facts.media[0].medium.albedo = Vec3d(1);
    EXPECT_FALSE(Effects(facts, {}).on(Effect::Multiple)) << "no density";
}

TEST(Effects, APictureTakesMultipleScatteringFromItsInputOrComputesIt)
{
    EffectFacts facts = plain(EffectStage::Picture);
    facts.share = [] { return ShareFound{0.001, 0}; };
    facts.computed = false;
    EXPECT_FALSE(Effects(facts, {}).on(Effect::Multiple));
    EXPECT_FALSE(Effects(facts, {})[Effect::Multiple].left_out) << "there is none to leave out";
    facts.brought = true;
    EXPECT_TRUE(Effects(facts, {}).on(Effect::Multiple));
    EXPECT_TRUE(Effects(facts, asked(Mode::List))[Effect::Multiple].left_out);
    facts.brought = false;
    facts.computed = true;
    EXPECT_TRUE(Effects(facts, {})[Effect::Multiple].left_out);
    EXPECT_TRUE(Effects(facts, asked(Mode::All)).on(Effect::Multiple));
}

// A stage of light needs three computations for three extinctions; a solution also for albedos, grids and lights that
// are not proportional.
TEST(Effects, ChannelsCoincideWhereOneComputationServesAll)
{
    const struct {
        Change change;
        bool light, scatter, picture;
    } table[] = {
        {[](EffectFacts&) {}, false, false, false},
        {[](EffectFacts& f) { f.media[0].medium.sigma_t_per_density = Vec3d(1, 2, 1); }, true, true, true},
        {[](EffectFacts& f) { f.media[0].medium.albedo = Vec3d(0.9, 0.9, 0.8); }, false, true, false},
        {[](EffectFacts& f) {
             f.media[0].medium.albedo = Vec3d(0.9, 0.9, 0.8);
             f.media[0].delta_f = 0.5;
         },
         true, true, true},
        {[](EffectFacts& f) { f.media[0].tint = red.get(); }, false, true, false},
        {[](EffectFacts& f) { f.media[0].emission = glowing.get(); }, false, true, false},
        {[](EffectFacts& f) { f.lights[0] = make_sun(Vec3d(0, 1, 0), Vec3d(3, 2, 1)); }, false, false, false},
        {[](EffectFacts& f) { f.lights.push_back(make_sun(Vec3d(1, 1, 0), Vec3d(3, 2, 1))); }, false, true, false},
        {[](EffectFacts& f) { f.sky = Sky::constant(Vec3d(0, 0, 1)); }, false, true, false},
    };
    for (const auto& row : table)
        for (const auto& [stage, on] : {std::pair{EffectStage::Light, row.light},
                                        {EffectStage::Scatter, row.scatter},
                                        {EffectStage::Picture, row.picture}}) {
            EffectFacts facts = plain(stage);
            row.change(facts);
            EXPECT_EQ(Effects(facts, {}).on(Effect::Colour), on) << &row - table << " at stage " << int(stage);
        }
}

TEST(Effects, AStageOfLightHasNoUseForWhatLaterStagesTake)
{
    for (const Effect effect :
         {Effect::Emission, Effect::Sky, Effect::Ground, Effect::Tint, Effect::Multiple, Effect::Anisotropy}) {
        EffectFacts facts = plain(EffectStage::Light);
        rows()[size_t(effect)].on(facts);
        EXPECT_FALSE(Effects(facts, asked(Mode::All)).on(effect)) << effect_names()[size_t(effect)].name;
    }
}

TEST(EffectCosts, TimersAddEntriesAndProcessorTime)
{
    EffectCosts costs;
    {
        const EffectCosts::Timer timer(costs, Effect::Sky);
        volatile double x = 1;
        for (int k = 0; k < 2000000; ++k) x = x * 1.0000001;
    }
    costs.hold(Effect::Tint, 2, 100);
    EffectCosts sum = costs;
    sum += costs;
    EXPECT_EQ(sum[Effect::Sky].entries, 2u);
    EXPECT_GT(sum[Effect::Sky].seconds, 0);
    EXPECT_EQ(sum[Effect::Sky].seconds, 2 * costs[Effect::Sky].seconds);
    EXPECT_TRUE(sum[Effect::Sky].timed);
    EXPECT_FALSE(sum[Effect::Tint].timed);
    EXPECT_EQ(sum[Effect::Tint].fields, 4u);
    EXPECT_EQ(sum[Effect::Tint].bytes, 200);
    EXPECT_EQ(sum[Effect::Lights].entries, 0u);
}

}  // namespace
}  // namespace vdbcloud
