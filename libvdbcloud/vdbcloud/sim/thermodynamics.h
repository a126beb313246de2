#pragma once
// Saturation, cloud water and buoyancy of moist air.
//
// The model transports theta_l = theta - (L / cp Pi) q_l and total water q_t, which condensation does not change. Cloud
// water q_l follows from both, so the equations have no latent heat term. Fields hold deviations of theta_l and q_t
// from a Reference, so that single precision resolves differences.
#include "vdbcloud/core/clones.h"

#include <string>
#include <vector>

namespace vdbcloud::sim {

/// Physical constants. All can be set; the metadata of frames hold them.
struct Constants {
    double g = 9.81;                ///< [m/s^2]
    double theta0 = 300;            ///< potential temperature of the base state [K]
    double latent_heat = 2.5e6;     ///< L [J/kg]
    double cp = 1004;               ///< [J/(kg K)]
    double r_dry = 287.05;          ///< gas constant of dry air [J/(kg K)]
    double r_vapour = 461.5;        ///< of water vapour [J/(kg K)]
    double surface_pressure = 1e5;  ///< at the floor [Pa]
    double rho0 = 1.16;             ///< density of the base state at the floor [kg/m^3]
};

/// What saturation depends on.
enum class SaturationBy {
    Height,       ///< q_s = A exp(-z / H): Kajiya and Von Herzen 1984, section 5.1
    Temperature,  ///< q_s(T, p0(z)) over water: Bolton 1980, eq. 10
};

/// Which terms act: what is off is not computed.
struct MoistTerms {
    SaturationBy by = SaturationBy::Temperature;
    bool latent_heat = true;  ///< off: cloud forms and changes nothing
    bool vapour = true;       ///< vapour is lighter than air: + 0.608 (q_v - q_v,env)
    bool loading = true;      ///< cloud water is carried: - q_l
    bool hot = false;         ///< dry air: g (theta - theta_env) / theta in place of g theta'/theta0
};

/// The values that fields of theta_l and q_t are relative to, one for the whole box.
struct Reference {
    double theta = 300;  ///< theta_l [K]
    double water = 0;    ///< q_t [kg/kg], not more than there is anywhere at the start
};

/// Constants of one level, in double; kernels take them in their own precision.
struct Level {
    double z = 0;           ///< [m]
    double pressure = 1e5;  ///< of the base state [Pa]
    double exner = 1;       ///< (p / 1e5 Pa)^(R/cp): T = theta exner
    double q_height = 0;    ///< saturation by height [kg/kg]
    double heat = 2490;     ///< L / cp, over exner where saturation is by temperature: what q_l adds to theta [K]
    double theta_env = 0;   ///< environment's theta_l, less the reference [K]
    double q_env = 0;       ///< environment's q_t, less the reference [kg/kg]
};

/// Buoyancy [m/s^2] = b_theta theta_l' + b_water q_t' + b_cloud q_l', dashes for deviations from the environment, which
/// is g [theta'/theta0 + 0.608 q_v' - q_l'] with the terms that are on. All arguments theta_l and q_t are less the
/// reference.
class Thermodynamics {
public:
    /// Without a reference: theta0 and no water.
    Thermodynamics(const Constants&, const MoistTerms&, bool moisture);
    Thermodynamics(const Constants&, const MoistTerms&, bool moisture, const Reference&);

    const Reference& reference() const { return reference_; }
    const MoistTerms& terms() const { return terms_; }
    bool moisture() const { return moisture_; }

    /// Saturation specific humidity at temperature T [K] and pressure p [Pa], and its slope [1/K].
    double saturation(double temperature, double pressure, double* slope = nullptr) const;

    /// Cloud water of one parcel [kg/kg], by the same arithmetic as the rows (double).
    double cloud_water(const Level&, double theta_l, double q_t) const;
    double buoyancy(const Level&, double theta_l, double q_t) const;

    /// q_l of a row, 0 where not saturated; exactly max(q_t - q_s, 0) with q_s at the temperature that results.
    template<typename T>
    void cloud_row(const Level&, const T* theta_l, const T* q_t, T* q_l, int n) const;
    /// Buoyancy of a row, exactly 0 where the air is the environment's; q_t null without moisture. `carried`, where not
    /// null: other water that weighs [kg/kg].
    template<typename T>
    void buoyancy_row(const Level&, const T* theta_l, const T* q_t, const T* carried, T* out, int n) const;

private:
    Constants constants_;
    MoistTerms terms_;
    bool moisture_;
    Reference reference_;
};

}  // namespace vdbcloud::sim
