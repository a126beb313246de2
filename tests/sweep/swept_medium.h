#pragma once
// A density with its exposed faces and sources, and sets of directions, for the tests of sweeps.
#include "vdbcloud/core/random.h"
#include "vdbcloud/scatter/harmonics.h"
#include "vdbcloud/scatter/ordinates.h"
#include "vdbcloud/sweep/transport_sweep.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace vdbcloud::test {

/// Directions of a quadrature, source and moments in harmonics.
inline SweepSet set_of(const Ordinates& ordinates, int source_degree, int moment_degree, double sky)
{
    SweepSet set;
    set.source_terms = harmonic_count(source_degree);
    set.moment_terms = harmonic_count(moment_degree);
    std::vector<double> y(size_t(harmonic_count(std::max(source_degree, moment_degree))));
    for (size_t m = 0; m < ordinates.count(); ++m) {
        evaluate_harmonics(std::max(source_degree, moment_degree), ordinates.direction[m], y.data());
        set.direction.push_back(ordinates.direction[m]);
        set.weight.push_back(float(ordinates.weight[m]));
        set.source_basis.insert(set.source_basis.end(), y.begin(), y.begin() + set.source_terms);
        set.moment_basis.insert(set.moment_basis.end(), y.begin(), y.begin() + set.moment_terms);
        set.inflow.push_back(float(sky));
    }
    return set;
}

/// Clumps with true voids and jumps; about the share `missing` of all blocks is empty.
inline double clumps(const Vec3i& p, uint64_t seed, double missing)
{
    const double big = uniform(hash_bits(seed, uint64_t(p.x() >> 3), uint64_t(p.y() >> 3), uint64_t(p.z() >> 3)));
    const double small = uniform(hash_bits(seed + 1, uint64_t(p.x() >> 1), uint64_t(p.y() >> 1), uint64_t(p.z() >> 1)));
    return big < missing || small < 0.3 ? 0 : std::pow(10.0, 4 * small - 3);
}

/// A density, its exposed faces, and a source.
struct SweptMedium {
    explicit SweptMedium(const FloatGridPtr& of, std::array<bool, 3> periodic = {false, false, false})
        : grid(of), index(*of, {periodic}), sigma(index.gather(*of))
    {
        const Blocks& blocks = index.blocks();
        for (size_t slot = 0; slot < blocks.count() * 512; ++slot)
            for (int face = 0; face < 6 && blocks.active(slot); ++face)
                if (!blocks.active(blocks.neighbour(slot, face))) faces.push_back({uint32_t(slot), uint8_t(face)});
    }
    void add_source(const std::function<double(const Vec3i&)>& f)
    {
        source.emplace_back(index.blocks().slots(), 0.0f);
        for (size_t slot = 0; slot < index.blocks().count() * 512; ++slot)
            if (index.blocks().active(slot)) source.back()[slot] = float(f(index.blocks().voxel(slot)));
    }
    SweepFields fields() const { return {&sigma, &source, emission}; }
    FloatGridPtr grid;
    VoxelIndex index;
    std::vector<float> sigma;
    std::vector<SweepFace> faces;
    std::vector<std::vector<float>> source;
    bool emission = false;  ///< SweepFields::emission
};

/// Directions without harmonics: source term k and moment k belong to direction k alone, so that moment k is weight k
/// times the radiance along direction k.
inline SweepSet one_by_one(const std::vector<Vec3d>& directions)
{
    SweepSet set;
    set.direction = directions;
    set.source_terms = 1;
    set.moment_terms = int(directions.size());
    for (size_t m = 0; m < directions.size(); ++m) {
        set.weight.push_back(1.0f);
        set.source_basis.push_back(1.0f);
        set.inflow.push_back(0.0f);
        for (size_t k = 0; k < directions.size(); ++k) set.moment_basis.push_back(k == m ? 1.0f : 0.0f);
    }
    return set;
}

}  // namespace vdbcloud::test
