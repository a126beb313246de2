#pragma once
// Radiance on the planes of the box about a cloud, summed over directions and over cells. Private to sweep/.
#include "vdbcloud/sweep/aprons.h"
#include "vdbcloud/sweep/face_tallies.h"
#include "vdbcloud/sweep/plane_light.h"

namespace vdbcloud {

/// Sums of PlaneLight. Planes are taken apart into tiles of 8 x 8 cells, each behind the face of one block's place. On
/// tiles of blocks that exist, light is that of a face (transport_sweep.h). To other tiles it comes through the void:
/// from the blocks whose shadow along a direction falls on the tile, else from the sky. Rays are traced from the tiles
/// in these shadows alone, unless each cell's light is asked for.
///
/// Threads: add() to different blocks; add_voids() after the last block of a batch.
class PlaneTallies {
public:
    /// Keeps references. `to` is what the sums of a channel are added to.
    PlaneTallies(const Blocks&, const SweepSet&, const Vec3d& spacing, int channel, PlaneLight& to);

    /// `of_pass`: 0 or 1, for two batches that go through the blocks together.
    void add(const block_sweep::Traversal&, int of_pass, int d, size_t block, const Vec3d& direction, float weight,
             const block_sweep::Scratch&);
    /// `below`: by channel, a patch of ground whose light has been reflected; empty: none. `channels` ask alike for
    /// cells, or not: rays are traced once for all of them.
    static void add_voids(const std::vector<PlaneTallies*>& channels, const std::vector<SweepPath>& batch, int of_pass,
                          const Aprons&, const std::vector<const PatchLight*>& below);
    bool by_cell() const { return to_.by_cell; }
    /// Writes the values of the cells.
    void write() const;

private:
    /// A tile without a block, and the directions of a batch whose rays are traced from it.
    struct Tile {
        int face;
        Vec3i corner;  // the voxel of the tile's first cell; may be outside the box, as may others
        uint8_t ways = 0;
        size_t cells = 0;               // place in cells_
        size_t first = 0, shadows = 0;  // in shadows_; none if by_cell
    };
    /// Of a block on a tile.
    struct Shadow {
        int32_t block;
        uint8_t ways;
    };
    struct Cells {
        std::array<float, 64> from_medium{}, from_sky{};
    };
    /// Of one tile, by direction of a batch: power from blocks, and what it hides of the sky and the patch.
    struct TileSums {
        std::array<double, block_sweep::batch> medium{}, hidden{};
        uint64_t tests = 0;
    };
    std::vector<SweepFace> find_faces();
    std::vector<Tile> all_voids() const;
    std::vector<Tile> shaded(const std::vector<SweepPath>& batch);
    void add_shadow(int face, uint8_t way, const Vec3d& step, size_t block, std::vector<Tile>& to) const;
    bool is_void(const Vec3i& corner) const;
    /// What comes along one direction to the cells of a tile.
    void take(const Tile&, const SweepPath&, size_t d, uint64_t sky, const float* radiance, const PatchLight* below,
              TileSums& to);
    void add_voids(const std::vector<SweepPath>& batch, int of_pass, const std::vector<Tile>&,
                   const std::vector<TileSums>&, const PatchLight* below);
    void add_sky(size_t m, int face, const PatchLight* below);
    double power(int face, size_t m) const
    {
        return (face % 2 ? 1 : -1) * set_.direction[m][face / 2] * set_.weight[m];
    }
    double inflow(size_t m) const { return set_.inflow.empty() ? 0.0 : double(set_.inflow[m]); }

    const Blocks& blocks_;
    const SweepSet& set_;
    const Vec3d spacing_;
    const int channel_;
    PlaneLight& to_;
    ActiveBox box_;
    std::vector<Vec3i> face_voxels_;  // of faces_; before it, for find_faces() fills both
    std::vector<SweepFace> faces_;    // the cells of tiles whose block exists
    FaceTallies on_blocks_;
    std::vector<int32_t> row_;                                // of a block in sums_; -1: no face
    std::array<std::vector<std::array<double, 3>>, 2> sums_;  // of a batch: block by block, `batch` each, by axis
    std::vector<Tile> voids_;                                 // all tiles without a block, if by_cell
    std::vector<Cells> cells_;                                // of voids_
    std::vector<Shadow> shadows_;                             // of a batch, tile by tile
    std::array<size_t, 6> void_cells_{};                      // cells of the planes that lie in tiles without a block
};

}  // namespace vdbcloud
