// Tables of enumerators and words, and the error for an unusable value.
#include "vdbcloud/core/refuse.h"
#include "vdbcloud/core/words.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

enum class Fruit { Apple, Pear, Plum, Unnamed };
constexpr auto fruits = words<Fruit>("fruit", {{Fruit::Apple, "apple"}, {Fruit::Pear, "pear"}, {Fruit::Plum, "plum"}});
static_assert(fruits.word(Fruit::Pear)[0] == 'p');

template<typename Work>
std::string message(const Work& work)
{
    try {
        work();
    } catch (const InputError& e) {
        return e.what();
    }
    return {};
}

TEST(Words, RoundTripBetweenValueAndWord)
{
    for (const Fruit fruit : {Fruit::Apple, Fruit::Pear, Fruit::Plum})
        EXPECT_EQ(fruits.value(fruits.word(fruit)), fruit);
    EXPECT_STREQ(fruits.word(Fruit::Plum), "plum");
    EXPECT_THROW(fruits.word(Fruit::Unnamed), std::logic_error);
    ASSERT_EQ(fruits.choices().size(), 3u);
    EXPECT_EQ(fruits.choices()[1], (std::pair<std::string, Fruit>("pear", Fruit::Pear)));
}

TEST(Words, ErrorListsAllWords)
{
    EXPECT_EQ(message([] { fruits.value("Pear"); }), "fruit 'Pear': expected apple, pear or plum");
    EXPECT_EQ(message([] { fruits.value("a\nb", "basket"); }), "basket: fruit 'a?b': expected apple, pear or plum");
}

TEST(Refuse, NamesValueAndExpectation)
{
    EXPECT_EQ(message([] { refuse("height", -1.5, "above 0"); }), "height = -1.5: expected above 0");
    EXPECT_EQ(message([] { refuse("name", std::string(300, 'x'), "a name"); }),
              "name = " + std::string(200, 'x') + "...: expected a name");
}

}  // namespace
}  // namespace vdbcloud
