#pragma once
// How far the work is, shown on stderr.
#include "vdbcloud/core/progress.h"

#include <mutex>
#include <string>

namespace vdbcloud::app {

/// What is written to stderr, by any thread: progress, and lines between it.
class Meter {
public:
    enum Mode { Off, Bar, Lines, Machine };

    void set(Mode mode, const std::string& tool);

    /// Draws `fraction` of `label` if it is time to: the bar ten times a second, lines each 10 %, and for machines an
    /// object {"tool", "phase", "fraction", "seconds"} a line, once a second and at the end.
    Progress of(const std::string& label);

    /// Writes one line, the bar out of its way.
    void line(const std::string& text);

    /// Takes the bar away.
    void clear();

private:
    struct Task;
    void update(Task&, double fraction);

    std::mutex mutex_;
    Mode mode_ = Off;
    std::string tool_;
    bool bar_shown_ = false;
};

/// `text` with control characters as '?' and cut at `most` bytes, letters of other alphabets kept.
std::string one_line(const std::string& text, size_t most = 4000);

/// Standard error is a terminal, and NO_COLOR is not set.
bool coloured();

}  // namespace vdbcloud::app
