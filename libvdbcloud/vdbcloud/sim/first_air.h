#pragma once
// The air of each cell at the start: the sounding with bubbles and noise. Private to sim/.
#include "vdbcloud/sim/simulation.h"

#include <array>
#include <string>

namespace vdbcloud::sim {

/// Values at the centre of a cell, relative to the column's reference.
struct CellAir {
    double theta, water, dye;
};

/// Both arguments live as long as the object.
class FirstAir {
public:
    FirstAir(const Parameters& p, const Column& c) : parameters_(p), column_(c) {}
    CellAir at(int i, int j, int k) const;
    /// Throws InputError for a value of at(i, j, k) that air cannot have, in a quantity that the run has.
    void check(const CellAir&, int i, int j, int k) const;
    /// check() for all cells. Looks at single cells only where bubbles and noise together could leave the range.
    void check_all() const;

private:
    bool surely_allowed() const;

    const Parameters& parameters_;
    const Column& column_;
};

/// Throws InputError that names `source`, the quantity, its value and the cell, for a value that air cannot have.
void expect_allowed(Quantity, double value, const std::array<int, 3>& cell, const std::string& source);

}  // namespace vdbcloud::sim
