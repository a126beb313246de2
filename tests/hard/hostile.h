#pragma once
// Hostile files to every program, by name and by standard input.
#include "hard/suite.h"

#include <map>
#include <string>
#include <vector>

namespace vdbcloud::test {

class Dice;

/// A hostile file and the command that reads it.
struct Mutant {
    std::string what;  ///< what was done
    std::string name;  ///< of the file
    std::string bytes;
    Words arguments;
    std::string input = "/dev/null";  ///< file of standard input
};

/// What is wrong with the end of a program that read a hostile file; empty: nothing. `said`: its standard error.
std::string complaint(const std::string& tool, int status, std::string said);

class Hostile {
public:
    /// Makes the healthy files in `folder`. Throws std::runtime_error if a program fails.
    Hostile(Programs&, const std::string& folder);

    /// All programs that read files.
    static const Words& tools();

    /// Commands that fail on a healthy file: none may.
    Words refused_when_healthy();

    /// The mutant of a seed. The same on every machine. SIZE=full has files of 1e5 grids, else of 2000.
    Mutant mutant(const std::string& tool, uint64_t seed);
    /// Runs the program. It must end with status 0 to 3 and, unless 0, with a sentence that begins with its name and
    /// has no control characters; and leave no file. Three rows: what fails, processor seconds, memory [MiB].
    void run(const std::string& tool, uint64_t seed);
    /// Writes the mutant to the folder and returns the command as a line of shell.
    std::string keep(const std::string& tool, uint64_t seed);

    const std::vector<Row>& rows() const { return rows_; }
    /// How many runs ended with each status.
    const std::map<int, int>& statuses() const { return statuses_; }
    const std::vector<Failure>& failures() const { return failures_; }

private:
    /// A command with @ in place of the hostile file, and kinds of that file.
    struct Slot {
        const char* kind;  ///< grids, picture, text, checkpoint
        Words healthy;     ///< files to start from
        std::string line;
        bool pipe = true;  ///< the file may be standard input
    };
    static std::vector<Slot> slots(const std::string& tool);

    void make(const std::string& tool, const std::string& line);
    const std::string& healthy(const std::string& name);
    std::string contents(const Slot&, const std::string& name, Dice&, std::string& what);

    Programs& programs_;
    std::string folder_;
    Words known_;  ///< names in the folder
    std::map<std::string, std::string> bytes_;
    std::vector<Row> rows_;
    std::map<int, int> statuses_;
    std::vector<Failure> failures_;
};

}  // namespace vdbcloud::test
