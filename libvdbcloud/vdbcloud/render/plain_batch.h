#pragma once
// A stretch of a ray through one grey medium, cell by cell, computed four cells at a time. Private to render/.
#include <array>
#include <vector>

namespace vdbcloud {

inline constexpr int most_plain_fields = 256;  ///< of a corner

/// What is the same for all cells of a ray.
struct PlainRay {
    double origin[3], direction[3];  ///< index space
    double sigma_t;                  ///< extinction at density 1 [1/world unit], of the scaled medium
    int lights = 0;                  ///< fields 0 .. lights - 1 are their depths
    int fields = 0, groups = 0;      ///< floats a corner, and these in fours
    int channels = 0;                ///< of collided light: 0, 1 or 3
    /// Collided light towards the eye is the sum of weight[c][k] times field k; 4 * groups each, 0 after the last.
    std::vector<double> weight[3];
    /// Where the flux is shortened to flux_limit phi (CollidedLight::flux_limit): fields of phi and flux of each
    /// channel. 0: it is not.
    double flux_limit = 0;
    int phi[3] = {-1, -1, -1}, flux[3] = {-1, -1, -1};
    /// Of each light: the factor of ForwardPeak at this ray's angle, by depth; null: 1.
    std::vector<const double*> peak;
    double peak_depth_of_tau = 0;  ///< from a scaled optical depth to ForwardPeak's x
};

/// Cells of a ray in order, and what is computed of them. Reused from batch to batch; one object a thread.
struct PlainBatch {
    static constexpr int size = 64;

    // Set by the march.
    int count = 0;
    double t0[size], t1[size];  // [world]
    float corner[size][8];      // density, BrickMap's order of corners
    double cell[3][size];       // index space
    const float* field[size];   // the cell's first corner
    bool joined[size];          // the cell begins where the one before it ends, in this batch

    // Set by find_depths().
    double to_mid[size], whole[size];  // optical depth of the first half and of the cell
    double weight[16][size];           // of the corners at the middle, then at the end
    double local[3][size];             // where the ray enters [cell]

    // Set by the integrator: optical depth before the cell.
    double tau[size];

    // Set by gather(): at the start, middle and end of each cell.
    std::vector<std::array<std::array<double, size>, 3>> depth;  // of each light
    std::array<std::array<double, size>, 3> collided[3];         // of each channel

    /// Sums over cells: of each light, scattered light over E, p, albedo and sigma_t / scaled sigma_t; of each channel,
    /// collided light the same way.
    std::vector<double> direct;
    double multiple[3];
};

/// Optical depths of the cells and the weights of their corners.
void find_depths(const PlainRay&, PlainBatch&);
/// Fields at three points of the first `lit` cells. `lit` is rounded up to fours by cells that add nothing.
void gather(const PlainRay&, PlainBatch&, int lit);
/// Adds the light of the first `lit` cells to direct and multiple, by the rule of cells.cc.
void add_light(const PlainRay&, PlainBatch&, int lit);

}  // namespace vdbcloud
