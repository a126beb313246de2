#pragma once
// Statistics of the air: means, variances and fluxes of its levels, and numbers of the whole box.
#include "vdbcloud/sim/simulation.h"

#include <string>
#include <vector>

namespace vdbcloud::sim {

/// Cells with more cloud water than this are cloud [kg/kg]: of cloud base, top, fraction and cover.
inline constexpr double cloudy = 1e-5;

/// A column of a table.
struct StatisticsColumn {
    const char* name;
    const char* unit;  ///< "" for ratios
    const char* meaning;
    bool at_face = false;  ///< of profiles: at the lower faces of the level, else at its centre

    /// "q_t[kg/kg]"; "cloud_cover" for a ratio.
    std::string heading() const;
};

/// Means over the cells of each level: column by column, nz values each.
using Profiles = std::vector<std::vector<double>>;
const std::vector<StatisticsColumn>& profile_columns();
/// Numbers of the box, a column each.
const std::vector<StatisticsColumn>& series_columns();

/// Statistics at one time.
struct Sample {
    Profiles profiles;
    std::vector<double> series;
};
/// Of the present state. Fluxes point upwards and are kinematic: without the density. Resolved ones are covariances of
/// values at faces, the means of the two values beside them; w is the air's own, without subsidence. Sub-grid ones are
/// those of eddy viscosity, viscosity and diffusivity, at the floor those of the surface. Means of levels are those of
/// the cells of air, and of the faces between two of them; a level within bodies has NaN. Paths and covers are per area
/// of the box. Results do not depend on the number of threads.
Sample take_sample(Simulation&, const Budget&);

/// Means of profiles over the samples of consecutive periods.
class ProfileMeans {
public:
    /// `period` [s], > 0.
    explicit ProfileMeans(double period) : period_(period) {}

    struct Period {
        double start = 0, end = 0;  ///< [s]
        int samples = 0;
        Profiles mean;
    };
    /// Adds profiles at a time that no earlier call passed. Returns true if the period that the time belongs to, which
    /// ends at its last moment, is complete.
    bool add(double time, const Profiles&);
    const Period& current() const { return current_; }

    /// All values, bit for bit, as bytes of a checkpoint.
    std::string bytes() const;
    /// Continues from bytes(); throws InputError "..." for those of another period or another lattice of `levels`.
    void restore(const std::string& bytes, size_t levels);

private:
    double period_;
    Period current_;
};

}  // namespace vdbcloud::sim
