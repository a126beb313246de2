#pragma once
// Runs cases and random worlds, and keeps what was seen: rows of a table.
#include "hard/judge.h"

#include <string>
#include <vector>

namespace vdbcloud::test {

/// What was seen of one invariant in one case, or in all random worlds of a range.
struct Row {
    std::string group, invariant;  ///< the case's name, or "random worlds"
    double worst = 0, limit = 0;
    int worlds = 0, failed = 0;
    std::string where;  ///< of the worst value; of random worlds its seed, too
    std::string known;  ///< why it fails today; empty: it must not

    bool passes() const { return known.empty() ? failed == 0 : failed > 0; }
};

struct Failure {
    std::string world;  ///< a record, the smallest that still fails
    std::string invariant, where;
    double value = 0, limit = 0;
};

class Suite {
public:
    Suite(Programs& programs, const std::string& folder) : chain_(programs, folder) {}

    void run_case(const World&);
    /// A failure is made smaller first.
    void run_random(uint64_t seed);

    /// The smallest world that still fails at the invariant; at `ends` with these words.
    World smallest(const World&, const std::string& invariant, const std::string& words);

    const std::vector<Row>& rows() const { return rows_; }
    const std::vector<Failure>& failures() const { return failures_; }
    const Chain& chain() const { return chain_; }

private:
    struct Judged {
        std::string invariant, where;
        double value = 0, limit = 0;
        bool holds() const { return value <= limit; }  // not for NaN
    };
    std::vector<Judged> judge(const World&);
    void note(const std::string& group, const World&, const std::vector<Judged>&);

    Chain chain_;
    std::vector<Row> rows_;
    std::vector<Failure> failures_;
};

/// Rows of one group and invariant as one: worlds and failures add up, the worst value stays.
void add_row(std::vector<Row>& rows, const Row&);

/// Rows as text, one a line, and back.
std::string csv(const std::vector<Row>&);
std::vector<Row> rows_of_csv(const std::string& text);

/// The readable table.
std::string table(const std::vector<Row>&);

}  // namespace vdbcloud::test
