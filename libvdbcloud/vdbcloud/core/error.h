#pragma once
// What can go wrong, as types. Thrown where found, caught once by the program, which maps each to its exit status.
#include <stdexcept>
#include <string>
#include <string_view>

namespace vdbcloud {

/// A value that cannot be used: the message names it and says what was expected. Exit status 1.
struct InputError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// A file that cannot be read or written; the message begins with its path. Exit status 1.
struct IoError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Options that contradict each other or what a grid was computed with; the message names both. Exit status 2.
struct UsageError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// A solver that missed its tolerance, or a result that is not finite. Exit status 3.
struct ConvergenceError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// The user asked to stop (a progress callback returned false).
struct Cancelled : std::runtime_error {
    Cancelled() : std::runtime_error("cancelled") {}
};

/// Text that came from a file, made fit to print: control characters become '?', at most `most` bytes are kept,
/// and a cut is marked by "...".
std::string printable(std::string_view text, size_t most = 200);

}  // namespace vdbcloud
