#pragma once
// Programs run as a user would, from tests: arguments, standard input, limits; status and what they said.
#include <sys/types.h>

#include <functional>
#include <string>
#include <vector>

namespace vdbcloud::test {

struct RunOptions {
    std::string input;                     ///< bytes for standard input, which then ends
    std::string stdout_to;                 ///< a file or device to open for standard output; empty: captured
    std::vector<std::string> environment;  ///< "NAME=value", added to the test's own; "NAME" takes NAME away
    double seconds = 60;                   ///< then it is killed: `timed_out`
    uint64_t memory = 0;                   ///< address space [bytes]; 0: no limit
    bool terminal = false;                 ///< standard input, output and error are a terminal; all said is in `out`
    bool ignore_sigpipe = false;           ///< SIGPIPE ignored at the start, as some services leave it
    bool close_stdout = false;             ///< nobody reads standard output (a pipe whose other end is closed)
    std::string until;                     ///< once standard error contains this ...
    int signal = 0;                        ///< ... send this signal
};

struct RunResult {
    int status = -1;  ///< as a shell shows it: 128 + N for an end by signal N
    std::string out, err;
    bool timed_out = false;
};

/// Runs `command` (a path, or a name to find in PATH, then arguments) and waits for its end.
RunResult run(const std::vector<std::string>& command, const RunOptions& = {});

/// The same for a shell line, under `bash -o pipefail`.
RunResult shell(const std::string& line, const RunOptions& = {});

/// Where the programs of this build are: "DIR/NAME".
std::string program(const std::string& name);

/// A fresh folder, removed with all it holds at the end of this object's life.
class Scratch {
public:
    Scratch();
    ~Scratch();
    Scratch(const Scratch&) = delete;
    Scratch& operator=(const Scratch&) = delete;

    std::string operator/(const std::string& name) const { return path_ + "/" + name; }
    const std::string& path() const { return path_; }
    /// Names of what is in it, hidden ones too, in order.
    std::vector<std::string> list() const;

private:
    std::string path_;
};

std::string read_text(const std::string& path);
void write_text(const std::string& path, const std::string& bytes);

}  // namespace vdbcloud::test
