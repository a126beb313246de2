#pragma once
// Takes errors that are known by blocks of pixels off a picture. Private to render/.
#include "vdbcloud/render/film.h"

#include <vector>

namespace vdbcloud {

/// Which pixels of a film's window a block has, and what of them counts. Blocks are aligned with the whole picture.
struct PixelBlocks {
    /// Pixels that see the media: alpha or light above 0 there or at one of the eight neighbours.
    PixelBlocks(const Film&, int edge);

    size_t block_of(int i, int j) const { return size_t(j / edge - y0) * size_t(across) + size_t(i / edge - x0); }

    int edge, x0, y0, across, down;
    std::vector<std::vector<std::pair<int, int>>> pixels;  ///< that count, of each block
};

/// The change of one pixel for which the blocks' errors are `guess`: picture - truth in the mean of the pixels of
/// `blocks`. Taken off in proportion to alpha, interpolated between the middles of blocks, such that blocks keep their
/// mean to a few percent; no pixel falls below 0. Blocks of little alpha are left.
class Correction {
public:
    Correction(const Film&, const PixelBlocks&, const std::vector<Vec3d>& guess);

    /// What is added to R, G, B.
    Vec3d at(int i, int j) const;
    /// What a block loses in the mean of its pixels: the guess, but for what the interpolation spreads.
    const std::vector<Vec3d>& taken() const { return taken_; }

private:
    Vec3d wanted(int i, int j) const;
    void find_taken();

    const Film& film_;
    const PixelBlocks& blocks_;
    int beauty_;
    std::vector<char> used_;
    std::vector<Vec3d> per_alpha_, taken_;
};

}  // namespace vdbcloud
