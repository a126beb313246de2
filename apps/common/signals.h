#pragma once
// Ends a run by a signal: removes incomplete files and lets the shell see the signal.
#include <string>

namespace vdbcloud::app {

/// From here SIGINT, SIGTERM, SIGHUP and SIGPIPE remove this process's temporaries, leave the report (below) and end it
/// by the same signal. SIGXCPU, the limit of processor time, does so too, but says so and ends with status 1. SIGINT,
/// SIGTERM and SIGHUP stay ignored where the parent had them ignored (nohup, a job in the background); SIGPIPE is never
/// ignored, because writing to a closed pipe is useless. SIGXFSZ is ignored, so that a file above the size limit is a
/// write error. std::terminate prints one line and ends with status 1.
void install_signals(const std::string& tool);

/// The report that a signal handler writes to `path`. The handler replaces its "SIGNAL" and "STATUS". For an empty
/// path, or a path that is not a regular file, the handler writes nothing.
void report_if_ended(const std::string& path, const std::string& text);

/// Ends the process as `signal` would.
[[noreturn]] void end_by(int signal);

}  // namespace vdbcloud::app
