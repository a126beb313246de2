#pragma once
// Radiance on the planes of the box about a cloud, summed over directions. Private to sweep/.
#include "vdbcloud/sweep/aprons.h"
#include "vdbcloud/sweep/face_tallies.h"
#include "vdbcloud/sweep/plane_light.h"

namespace vdbcloud {

/// Sums of PlaneLight. Planes are taken apart into tiles of 8 x 8 cells, each behind the face of one block's place. On
/// tiles of blocks that exist, light is that of a face (transport_sweep.h). To other tiles it comes through the void.
///
/// Threads: add() to different blocks; add_voids() after the last block of a batch.
class PlaneTallies {
public:
    explicit PlaneTallies(const Blocks&);

    void add(const block_sweep::Traversal& traversal, int d, size_t block, const Vec3d& direction, float weight,
             const block_sweep::Scratch& s)
    {
        on_blocks_.add(traversal, d, block, direction, weight, s);
    }
    /// `below`: a patch of ground whose light has been reflected; null: none.
    void add_voids(const std::vector<SweepPath>& batch, const Aprons&, const SweepSet&, const PatchLight* below);
    void write(const SweepSet&, PlaneLight& to) const;

private:
    struct Tile {
        int face;
        Vec3i corner;  // the voxel of the tile's first cell; may be outside the box, as may others
        std::array<float, 64> from_medium{}, from_sky{};
    };
    std::vector<SweepFace> find_tiles(const Blocks&);

    ActiveBox box_;
    std::vector<Tile> voids_;
    std::vector<size_t> cells_;     // of faces_; before it, for find_tiles() fills both
    std::vector<SweepFace> faces_;  // the cells of tiles whose block exists
    FaceTallies on_blocks_;
};

}  // namespace vdbcloud
