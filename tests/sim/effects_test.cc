// The table of effects: names, ranges and defaults of all settings.
#include "vdbcloud/sim/effect.h"

#include "vdbcloud/core/error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace vdbcloud::sim {
namespace {

TEST(Effects, SettingsHaveNamesOfTheirOwnAndDefaultsInRange)
{
    std::set<std::string> names;
    const Parameters defaults;
    const auto inspect = [&](const std::vector<Setting>& settings) {
        for (const Setting& setting : settings) {
            EXPECT_TRUE(names.insert(setting.name).second) << setting.name;
            EXPECT_NO_THROW(setting.check(defaults)) << setting.name;
            EXPECT_FALSE(setting.help.empty()) << setting.name;
        }
    };
    for (const auto* group : {&constant_settings(), &noise_settings(), &numeric_settings()}) inspect(*group);
    for (const Effect& effect : effects()) {
        inspect(effect.settings);
        EXPECT_LE(effect.switches, effect.settings.size());
        EXPECT_EQ(effect.switches == 0, !effect.turned_on_by.empty()) << effect.name;
    }
}

TEST(Effects, EachNumberOutOfItsRangeIsRefusedByName)
{
    for (const Effect& effect : effects())
        for (const Setting& setting : effect.settings) {
            if (setting.kind == Setting::Kind::Switch) continue;
            for (const double bad : {std::nextafter(setting.range.low, -never), double(NAN)}) {
                Parameters p;
                setting.value(p) = bad;
                try {
                    check(p, Sounding::uniform(300));
                    ADD_FAILURE() << setting.name << " = " << bad;
                } catch (const InputError& error) {
                    std::string words = setting.name;
                    std::replace(words.begin(), words.end(), '-', ' ');
                    EXPECT_EQ(std::string(error.what()).rfind(words + " = ", 0), 0u) << error.what();
                }
            }
        }
}

}  // namespace
}  // namespace vdbcloud::sim
