#pragma once
// Progress of the work on standard error.
#include "vdbcloud/core/progress.h"

#include <mutex>
#include <string>

namespace vdbcloud::app {

/// Writes progress and lines to standard error. Any number of threads may call it at a time, except set().
class Meter {
public:
    enum Mode { Off, Bar, Lines, Machine };

    void set(Mode mode, const std::string& tool);

    /// The progress of a phase called `label`; empty where the mode is Off. The bar is drawn at most ten times a
    /// second, a line at each 10 %. Mode Machine writes one JSON object a line, at most once a second and at the end:
    /// {"tool", "phase", "fraction", "seconds"}.
    Progress of(const std::string& label);

    /// Removes the bar and writes one line.
    void line(const std::string& text);

    /// Removes the bar.
    void clear();

private:
    struct Task;
    void update(Task&, double fraction);

    std::mutex mutex_;
    Mode mode_ = Off;
    std::string tool_;
    bool bar_shown_ = false;
};

/// `text` on one line: a line break becomes a blank, any other control character '?'. Text of more than `most` bytes is
/// cut and ends with "...". UTF-8 is kept.
std::string one_line(const std::string& text, size_t most = 4000);

/// True if standard error is a terminal and the environment variable NO_COLOR is unset or empty.
bool coloured();

}  // namespace vdbcloud::app
