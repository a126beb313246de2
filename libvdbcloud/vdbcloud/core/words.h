#pragma once
// Tables of enumerators and their words in files, options and reports. One table serves both directions.
#include "vdbcloud/core/error.h"

#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdbcloud {

template<typename E>
struct Word {
    E value;
    const char* word;
};

/// The words of an enumeration, in the order in which messages list them. Made by words().
template<typename E, size_t N>
struct Words {
    const char* what;  ///< name of the enumeration in messages: "phase function"
    Word<E> entries[N];

    /// The word of a value. Throws std::logic_error for a value without one.
    constexpr const char* word(E value) const
    {
        for (const Word<E>& entry : entries)
            if (entry.value == value) return entry.word;
        throw std::logic_error("internal error: an enumerator without a word");
    }

    /// The value of a word. Throws InputError "OF: WHAT 'TEXT': expected A, B or C"; an empty `of` omits "OF: ".
    E value(std::string_view text, const std::string& of = {}) const
    {
        for (const Word<E>& entry : entries)
            if (entry.word == text) return entry.value;
        throw InputError((of.empty() ? of : of + ": ") + what + " '" + printable(text) + "': expected " + list());
    }

    /// "A, B or C"
    std::string list() const
    {
        std::string text;
        for (size_t k = 0; k < N; ++k) text += (k == 0 ? "" : k + 1 < N ? ", " : " or ") + std::string(entries[k].word);
        return text;
    }

    /// Pairs of word and value, for an option that takes one of the words.
    std::vector<std::pair<std::string, E>> choices() const
    {
        std::vector<std::pair<std::string, E>> all;
        for (const Word<E>& entry : entries) all.emplace_back(entry.word, entry.value);
        return all;
    }
};

/// constexpr auto fruits = words<Fruit>("fruit", {{Fruit::Apple, "apple"}, {Fruit::Pear, "pear"}});
template<typename E, size_t N>
constexpr Words<E, N> words(const char* what, const Word<E> (&entries)[N])
{
    Words<E, N> table{what, {}};
    for (size_t k = 0; k < N; ++k) table.entries[k] = entries[k];
    return table;
}

}  // namespace vdbcloud
