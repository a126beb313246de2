#pragma once
// A picture of all directions: latitude by longitude.
#include "vdbcloud/core/fwd.h"

#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

namespace vdbcloud {

struct GridFile;

/// Radiance from all directions as texels, in linear Rec. 709. Rows go from straight up to straight down, columns from
/// longitude 180 degrees to -180, both by middles of texels; between middles radiance is bilinear. Directions here have
/// components (left, up, ahead): ahead is the middle of the picture, left the middle of its left half.
///
/// Suns are taken out. Connected texels whose luminance is above `sun_contrast` times the mean over the sphere are a
/// sun where their excess over that value comes from at most `sun_size`; no more than `most_suns`, by their power. What
/// is left is smooth enough for a quadrature of some dozens of directions, and a sun gets its shadows.
///
/// Threads: immutable.
class Panorama {
public:
    static constexpr double sun_contrast = 20, sun_size = 0.02;  // [1], [sr]: a disc of 9 degrees
    static constexpr size_t most_suns = 8;
    static constexpr int most_columns = 8192;

    struct Sun {
        Vec3d direction;   ///< unit: the middle of its power
        Vec3d irradiance;  ///< of its excess
        double diameter;   ///< [degrees] of the disc that has its solid angle (int L dw)^2 / int L^2 dw
    };
    /// A cell of latitude and longitude, and its mean radiance without suns.
    struct Part {
        Vec3d direction, radiance;
        double solid_angle;
    };

    /// `rgb`: row by row, three values a texel; values below 0 become 0. Throws InputError unless the picture is twice
    /// as wide as high, 8 to most_columns wide, and all values are finite.
    Panorama(int width, int height, std::vector<float> rgb);

    int width() const { return width_; }
    int height() const { return height_; }
    const std::vector<float>& rgb() const { return rgb_; }
    const std::string& digest() const { return digest_; }  ///< of size and texels
    const std::vector<Sun>& suns() const { return suns_; }
    const std::vector<Part>& parts() const { return parts_; }  ///< rows of at most 64, none across the horizon
    /// Colours in whose ratios the channels stand: one where that is the same everywhere, else three.
    const std::vector<Vec3d>& tones() const { return tones_; }

    /// Radiance from a unit direction, with its suns or without.
    Vec3d radiance(const Vec3d& direction, bool with_suns) const;

private:
    Vec3d texel(int row, int column, bool with_suns) const;
    void find_suns();
    void find_parts();

    int width_, height_;
    std::vector<float> rgb_;
    std::string digest_;
    std::unordered_map<size_t, float> of_suns_;  // texels, and the share of their radiance that is left without suns
    std::vector<Sun> suns_;
    std::vector<Part> parts_;
    std::vector<Vec3d> tones_;
};

/// The grid `environment` of a file, one voxel a texel; null if there is none. Throws InputError as the constructor.
std::shared_ptr<const Panorama> panorama_of(const GridFile&);

/// Puts a panorama into a file in place of the one that it has; null: takes it out.
void put_panorama(GridFile&, const std::shared_ptr<const Panorama>&);

}  // namespace vdbcloud
