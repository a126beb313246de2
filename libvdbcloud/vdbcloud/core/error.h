#pragma once
// Exception types of the library. Each program catches them once and maps each type to its exit status.
#include <stdexcept>
#include <string>
#include <string_view>

namespace vdbcloud {

/// An unusable input value. The message names the value and the expected range or type. Exit status 1.
struct InputError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// A file that cannot be read or written. The message begins with its path. Exit status 1.
struct IoError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Options that contradict each other or the metadata of a grid. The message names both sides. Exit status 2.
struct UsageError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// A solver did not reach its tolerance, or a result is not finite. Exit status 3.
struct ConvergenceError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// The user cancelled the work (a progress callback returned false).
struct Cancelled : std::runtime_error {
    Cancelled() : std::runtime_error("cancelled") {}
};

/// Makes text from a file safe to print. Bytes other than printable ASCII become '?'. Text over `most` bytes is cut to
/// `most` bytes and "...".
std::string printable(std::string_view text, size_t most = 200);

}  // namespace vdbcloud
