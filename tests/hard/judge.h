#pragma once
// Invariants: what must hold for every world, whatever its values.
#include "hard/chain.h"

#include <cmath>
#include <string>
#include <vector>

namespace vdbcloud::test {

struct Verdict {
    double worst = 0;   ///< the largest error
    std::string where;  ///< what has this error

    void take(double error, const std::string& what)
    {
        if (std::isnan(worst) || error <= worst) return;  // NaN is the largest
        worst = error;
        where = what;
    }
};

struct Invariant {
    std::string name;
    std::string meaning;  ///< of the value, for the page
    double limit;         ///< for random worlds
    std::string why;      ///< this limit
    bool (*applies)(const World&);
    /// `seen` is what the world gives.
    Verdict (*judge)(Chain&, const World&, const Seen& seen);
};

const std::vector<Invariant>& invariants();
const Invariant& invariant(const std::string& name);

/// What a line `holds` says of a world: an invariant, or `number FILE /POINTER VALUE`: the relative difference of a
/// number in a report and a value, which is a number or again FILE /POINTER; of 0 the absolute one. Of a file of JSON
/// lines the pointer begins with the number of the line, from 0.
Verdict judged(Chain&, const World&, const Seen&, const std::string& held);

/// The largest difference of two worlds' grids, powers and pictures, over the largest value of each, where `a` times
/// `factor` is expected to be `b` under the change. Pictures of 16-bit floats differ by their rounding.
Verdict difference(const Seen& a, const Seen& b, const Change& change, double factor);

/// The optical depth of the trilinear density along p + t d, t >= 0, in double and exact but for rounding.
double line_integral(const FloatGrid& density, const Vec3d& p, const Vec3d& d);

}  // namespace vdbcloud::test
