#pragma once
// What a run costs: counts of events times the time that an event takes.
#include <map>
#include <string>
#include <vector>

namespace vdbcloud {

/// A row of data/unit_costs.txt, which `make -C tests bench` measures.
struct UnitCost {
    std::string event;
    double nanoseconds;   ///< of processor time that one event takes, on one core of unit_cost_machine()
    std::string meaning;  ///< what is counted
};

/// The rows of the table, in its order.
const std::vector<UnitCost>& unit_costs();
/// The processor on which the table was measured.
const std::string& unit_cost_machine();

/// Counts of events, each a row of the table. An estimate has them before the work, a run counts them exactly.
class Workload {
public:
    /// Adds `count` events. Throws std::invalid_argument for an event without a row: a fault of the program.
    void add(const std::string& event, double count);
    Workload& operator+=(const Workload&);
    const std::map<std::string, double>& events() const { return events_; }
    double of(const std::string& event) const;  ///< 0 for an event that did not occur
    /// Processor time of all events [s].
    double seconds() const;

private:
    std::map<std::string, double> events_;
};

}  // namespace vdbcloud
