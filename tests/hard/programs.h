#pragma once
// The programs of this build, each started once, then run many times.
#include "hard/start_once.h"
#include "support/run.h"

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace vdbcloud::test {

using Words = std::vector<std::string>;

/// Words separated by blanks.
Words split(const std::string& text);

struct Limits {
    double seconds = 20;        ///< processor time of one run
    double bytes = 2147483648;  ///< address space of one run
};

/// Runs programs by start_once.cc. One thread at a time.
class Programs {
public:
    explicit Programs(const Limits& = {});
    ~Programs();

    /// Runs a program in `folder`; its output is in the files stdout and stderr there. `input`: the file of standard
    /// input.
    Answer run(const std::string& name, const Words& arguments, const std::string& folder,
               const std::string& input = "/dev/null");

    /// False under sanitizers, where every run starts anew and limits hold for time alone.
    static bool start_once();

    double seconds() const { return seconds_; }  ///< processor time of all runs
    int runs() const { return runs_; }

private:
    struct Started;
    Limits limits_;
    std::map<std::string, std::unique_ptr<Started>> started_;
    double seconds_ = 0;
    int runs_ = 0;
};

}  // namespace vdbcloud::test
