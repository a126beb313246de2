#pragma once
// Bodies in the box: which share of each face is open. Private to sim/.
#include "vdbcloud/sim/parameters.h"

#include <array>
#include <vector>

namespace vdbcloud::sim {

/// The geometry of bodies on a lattice. Faces have the area of the polygon where the distance, linear along their edges
/// between corners, is above 0: of second order. Cells keep their whole volume, so that no step shrinks with a cell
/// that a body cuts to a sliver.
template<typename T>
struct Openness {
    Openness() = default;
    explicit Openness(const Parameters&);
    explicit operator bool() const { return !solid.empty(); }

    std::array<Field<T>, 3> face;  ///< open share of the lower faces; 0 at walls, floor and lid
    std::array<Field<T>, 3> flux;  ///< share times velocity of the present state: what carries air through faces
    std::vector<char> solid;       ///< cells without an open face, x fastest
    std::vector<int> ground;       ///< the lowest cell of each column that is not solid; nz: none
    size_t bytes() const;
};

extern template struct Openness<float>;
extern template struct Openness<double>;

}  // namespace vdbcloud::sim
