#pragma once
// The state of a simulation as grids, and grids as the state to start from. No other part of this module uses OpenVDB.
#include "vdbcloud/core/fwd.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/grid/up_axis.h"
#include "vdbcloud/sim/simulation.h"

namespace vdbcloud::sim {

struct RunRecord;  // run_record.h

struct SnapshotOptions {
    UpAxis up = UpAxis::Y;            ///< of the files
    bool unpruned = false;            ///< all voxels of all grids active, also where there is no cloud
    std::vector<std::string> grids;   ///< names to write; empty: all there are
    double effective_radius = 10e-6;  ///< of the droplets [m]
    double smoke_extinction = 0.05;   ///< sigma_t at dye 1 [1/m]
};

/// The present state as grids, in metres, with the floor at height 0 and the box centred above the origin:
///
/// | density     | q_l [kg/kg]; without moisture: dye. Active where above 0. Extinction = 3 rho0 q_l / (2 rho_w r_e) |
/// | temperature | T [K] (theta [K] with saturation by height)                                                     |
/// | qt          | total water [kg/kg]                                                                             |
/// | vel         | velocity [m/s], staggered: each component on the lower face of the voxel                         |
/// | rain, dye   | where the run has them                                                                          |
/// | flame       | heat that fuel gives to the air [K/s], with combustion                                          |
///
/// The box moves with the frame; velocities are over the ground.
///
/// temperature, qt and vel are active within two voxels of the density only, unless `unpruned`. In memory z is up. If y
/// is up in the files, this function exchanges axes y and z and the components of the velocity: the equations have no
/// rotation, so the mirror image of a solution is a solution. The metadata hold the record of the run.
GridFile make_snapshot(const Simulation&, const SnapshotOptions&, const RunRecord&);

/// What start_from() found in a file.
struct StartReport {
    uint64_t cells_set = 0;
    uint64_t negative_water = 0;  ///< cells whose water was raised to 0
    uint64_t saturated = 0;       ///< cells that hold cloud from the start
    double latent_heat = 0;       ///< mean of (L/cp) q_l over the box [K]: heat already in the temperature
    UpAxis up = UpAxis::Y;        ///< of the file
    bool centred_wind = false;    ///< vel was at the centres of voxels
    bool resampled = false;       ///< voxels lie elsewhere than cells
};

/// Replaces the initial air by the grids temperature, qt and vel of a file, each in the cells that touch an active
/// voxel: trilinear between voxels, where a voxel that is not active counts as the air of the sounding. vel is
/// staggered or at centres, as the class of the grid says. Up is the axis that the file names, else `up`;
/// meters_per_unit of the file is its unit of length. The temperature is the actual one: it includes the latent heat of
/// cloud that is there at the start. Throws InputError for a value that air cannot have (with its cell), for voxels
/// with slanted edges and for grids of another type; IoError if there is none of these grids.
StartReport start_from(Simulation&, const GridFile&, UpAxis up);

}  // namespace vdbcloud::sim
