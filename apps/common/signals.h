#pragma once
// How a run ends before its time, so that nothing half-written stays and the shell sees which signal it was.
#include <string>

namespace vdbcloud::app {

/// From here SIGINT, SIGTERM, SIGHUP and SIGPIPE remove this process's temporaries, leave the report (below) and end it
/// by the same signal. SIGINT, SIGTERM and SIGHUP stay ignored where the parent had them ignored (nohup, a job in the
/// background); SIGPIPE does not, for writing on into a closed pipe serves nobody. A file too large is an error of
/// writing (SIGXFSZ ignored), and std::terminate is one line and status 1.
void install_signals(const std::string& tool);

/// What to leave at `path` if a signal ends the run: a complete report but for its "SIGNAL" and "STATUS", which the
/// handler fills in. Nothing for an empty path, or if what is there is no regular file.
void report_if_ended(const std::string& path, const std::string& text);

/// Ends the process as `signal` would.
[[noreturn]] void end_by(int signal);

}  // namespace vdbcloud::app
