#pragma once
// Runs programs as a user does: arguments, standard input and limits in; exit status and output out.
#include <sys/types.h>

#include <functional>
#include <string>
#include <vector>

namespace vdbcloud::test {

/// Whether this build has a sanitizer: its programs take terabytes of address space and more memory, so that limits and
/// estimates of memory say nothing of them.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool sanitized = true;
#else
inline constexpr bool sanitized = false;
#endif

struct RunOptions {
    std::string input;                     ///< all bytes of standard input
    std::string folder;                    ///< where the command runs; empty: where the test runs
    std::string stdout_to;                 ///< a file or device to open for standard output; empty: captured
    std::vector<std::string> environment;  ///< changes of the test's environment: "NAME=value" sets, "NAME" removes
    double seconds = 60;                   ///< time limit [s]; then the program is killed and `timed_out` is true
    uint64_t memory = 0;                   ///< limit of address space [bytes]; 0: no limit
    bool terminal = false;                 ///< standard streams are a terminal; `out` captures all output
    bool ignore_sigpipe = false;           ///< the program starts with SIGPIPE ignored, as under some services
    bool close_stdout = false;             ///< standard output is a pipe whose read end is closed
    std::string until;                     ///< once standard error contains this ...
    int signal = 0;                        ///< ... send this signal
};

struct RunResult {
    int status = -1;  ///< exit status as in a shell: 128 + N after signal N
    std::string out, err;
    bool timed_out = false;
};

/// Runs `command` (a path or a name in PATH, then arguments) and waits for its end.
RunResult run(const std::vector<std::string>& command, const RunOptions& = {});

/// As run(), for a line of shell, under `bash -o pipefail`, where the programs of this build are the first in PATH. A
/// path of theirs without quotes throws std::logic_error: a checkout with a space in its name would not forgive it.
RunResult shell(const std::string& line, const RunOptions& = {});

/// The path of a program of this build.
std::string program(const std::string& name);

/// A new empty folder, whose name has a space. The destructor removes the folder and its contents.
class Scratch {
public:
    Scratch();
    ~Scratch();
    Scratch(const Scratch&) = delete;
    Scratch& operator=(const Scratch&) = delete;

    std::string operator/(const std::string& name) const { return path_ + "/" + name; }
    const std::string& path() const { return path_; }
    /// Sorted names of all files and folders inside, hidden names included.
    std::vector<std::string> list() const;

private:
    std::string path_;
};

std::string read_text(const std::string& path);
void write_text(const std::string& path, const std::string& bytes);

}  // namespace vdbcloud::test
