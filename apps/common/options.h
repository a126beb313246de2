#pragma once
// Values on the command line: what is accepted, how it is read, and how it is written again.
#include "vdbcloud/core/fwd.h"
#include "vdbcloud/core/shortest.h"

#include <CLI/App.hpp>

#include <array>
#include <charconv>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

namespace vdbcloud::app {

// Each holds for every number of a list "1,2,3", too. A number is what strtod reads, whole, without nan and inf, of a
// size up to 1e30.
extern const CLI::Validator positive;     ///< a finite number above 0
extern const CLI::Validator nonnegative;  ///< a finite number, 0 or above
extern const CLI::Validator finite;       ///< a finite number
/// A finite number within [low, high].
CLI::Validator within(double low, double high);

/// The parts of `text` between characters `at`, empty ones included.
std::vector<std::string> split(const std::string& text, char at);

/// The whole of `text` as a finite number, or nothing.
std::optional<double> number(const std::string& text);

/// The whole of `text` as a whole number that a T holds: 0, or 1 for no whole number, 2 for one too large.
template<typename T>
int read_whole(const std::string& text, T& value)
{
    const size_t plus = text.size() > 1 && text[0] == '+' && text[1] != '-';
    const char* end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(text.data() + plus, end, value);
    if (error == std::errc::result_out_of_range && rest == end) return 2;
    return error != std::errc() || rest != end;
}

/// The numbers of "1,2,3", or nothing if any part is none.
std::optional<std::vector<double>> numbers(const std::string& text);

using vdbcloud::shortest;

/// A number for people, six digits at the most.
std::string brief(double x);
std::string brief(const Vec3d&);  ///< "x,y,z", or one number where they are equal

namespace traits {
template<typename T>
struct Element {
    using type = T;
};
template<typename T>
struct Element<std::vector<T>> {
    using type = T;
};
template<typename T>
struct Element<std::optional<T>> {
    using type = T;
};
template<typename T, size_t n>
struct Element<std::array<T, n>> {
    using type = T;
};

template<typename T>
inline constexpr bool holds_numbers =
    std::is_arithmetic_v<typename Element<T>::type> && !std::is_same_v<typename Element<T>::type, bool>;
template<typename T>
inline constexpr bool is_whole = std::is_integral_v<T> && !std::is_same_v<T, bool>;
template<typename T>
inline constexpr bool holds_unsigned = holds_numbers<T>&& std::is_unsigned_v<typename Element<T>::type>;
template<typename T>
inline constexpr bool is_vector = false;
template<typename T>
inline constexpr bool is_vector<std::vector<T>> = true;
}  // namespace traits

/// An option as the user sees it: its name without dashes and its value in words, given or default.
struct Setting {
    const CLI::Option* option;
    std::string name;
    std::vector<std::string> words;  ///< none: not given, and no default
    enum Kind { Flag, One, Many } kind;
    bool numeric;  ///< words are numbers, or lists of numbers
};

/// `option` with these words as its value.
Setting setting_of(const CLI::Option*, std::vector<std::string> words);

/// Every option that describes the result (not --threads, --json and the like), in the order of declaration.
std::vector<Setting> settings(const CLI::App&);

/// The words that stand for the default; none where there is none.
std::vector<std::string> default_words(const Setting&);

/// `setting` as the right side of a line of the config file: 0.5, true, "text", [0.3, 1, 0.2], ["a", "b"].
std::string toml(const Setting&);

}  // namespace vdbcloud::app
