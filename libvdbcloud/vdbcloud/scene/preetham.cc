// The sky of a clear day with haze: Preetham, Shirley, Smits, "A Practical Analytic Model for Daylight", SIGGRAPH 1999.
#include "vdbcloud/grid/scatter_schema.h"
#include "vdbcloud/scene/atmosphere.h"
#include "vdbcloud/scene/colour.h"
#include "vdbcloud/scene/sky_kinds.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>

namespace vdbcloud {

namespace {

/// Perez' distribution, appendix A.2: (1 + A e^(B / cos t)) (1 + C e^(D g) + E cos^2 g), each coefficient linear in the
/// turbidity. t: from the zenith; g: from the sun.
struct Perez {
    double of(double cos_t, double g) const
    {
        const double cos_g = std::cos(g);
        return (1 + c[0] * std::exp(c[1] / cos_t)) * (1 + c[2] * std::exp(c[3] * g) + c[4] * cos_g * cos_g);
    }
    std::array<double, 5> c;
};

Perez perez(double turbidity, const std::array<std::array<double, 2>, 5>& lines)
{
    Perez out{};
    for (size_t k = 0; k < 5; ++k) out.c[k] = lines[k][0] * turbidity + lines[k][1];
    return out;
}

/// A chromaticity in the zenith: [T^2 T 1] M [t^3 t^2 t 1], t the sun's angle from the zenith.
double in_zenith(double T, double t, const std::array<std::array<double, 4>, 3>& m)
{
    const auto cubic = [&](size_t row) { return ((m[row][0] * t + m[row][1]) * t + m[row][2]) * t + m[row][3]; };
    return (cubic(0) * T + cubic(1)) * T + cubic(2);
}

class Preetham : public SkyModel {
public:
    explicit Preetham(const SkyDescription& sky)
        : up_(sky.up), to_sun_(sky.parameters[1].unit()), scale_(sky.parameters[2][0]),
          ground_(sky.ends_at_horizon ? Vec3d(0.0) : sky.parameters[3])
    {
        const double T = sky.parameters[0][0], t = std::acos(std::clamp(up_.dot(to_sun_), 0.0, 1.0));
        const double chi = (4.0 / 9 - T / 120) * (pi - 2 * t);
        Y_ =
            perez(T, {{{0.1787, -1.4630}, {-0.3554, 0.4275}, {-0.0227, 5.3251}, {0.1206, -2.5771}, {-0.0670, 0.3703}}});
        x_ = perez(T,
                   {{{-0.0193, -0.2592}, {-0.0665, 0.0008}, {-0.0004, 0.2125}, {-0.0641, -0.8989}, {-0.0033, 0.0452}}});
        y_ = perez(T,
                   {{{-0.0167, -0.2608}, {-0.0950, 0.0092}, {-0.0079, 0.2102}, {-0.0441, -1.6537}, {-0.0109, 0.0529}}});
        zenith_ = {in_zenith(T, t,
                             {{{0.00166, -0.00375, 0.00209, 0},
                               {-0.02903, 0.06377, -0.03202, 0.00394},
                               {0.11693, -0.21196, 0.06052, 0.25886}}}) /
                       x_.of(1, t),
                   in_zenith(T, t,
                             {{{0.00275, -0.00610, 0.00317, 0},
                               {-0.04214, 0.08970, -0.04153, 0.00516},
                               {0.15346, -0.26756, 0.06670, 0.26688}}}) /
                       y_.of(1, t),
                   std::max(0.0, (4.0453 * T - 4.9710) * std::tan(chi) - 0.2155 * T + 2.4192) / Y_.of(1, t)};
        sample();
    }

    Vec3d radiance(const Vec3d& w) const override
    {
        const double cos_t = w.dot(up_);
        return cos_t < 0 ? ground_ : above(cos_t, w.dot(to_sun_));
    }

    /// The sky as sources in `samples_` directions, the ground in closed form; relative error below 1e-3.
    Vec3d mean_inflow(const Vec3d& normal) const override
    {
        Vec3d sum(0.0);
        double weights = 0;
        for (const Sample& sample : samples_) {
            const double cosine = sample.direction.dot(normal);
            if (!(cosine > 0)) continue;
            weights += cosine * sample.solid_angle;
            sum += cosine * sample.power;
        }
        const double high = (1 + normal.dot(up_)) / 2;  // share of the inflow from above the horizon
        return (1 - high) * ground_ + (weights > 0 ? sum * high / weights : Vec3d(0.0));
    }

    /// Its colour changes with direction.
    std::vector<Vec3d> tones() const override
    {
        return {Vec3d(scale_, 0, 0), Vec3d(0, scale_, 0), Vec3d(0, 0, scale_)};
    }

private:
    struct Sample {
        Vec3d direction, power;
        double solid_angle;
    };

    Vec3d above(double cos_t, double cos_g) const
    {
        const double height = std::max(cos_t, 1e-6), g = std::acos(std::clamp(cos_g, -1.0, 1.0));
        const double Y = std::max(0.0, zenith_[2] * Y_.of(height, g));
        return scale_ *
               rec709_of_xyz(xyz_of_chromaticity(zenith_[0] * x_.of(height, g), zenith_[1] * y_.of(height, g), Y));
    }

    /// Rows of equal height angles, with as many directions as their circles are long.
    void sample()
    {
        constexpr int rows = 40;
        const Vec3d x = (std::abs(up_[0]) < 0.5 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0)).cross(up_).unit(), y = up_.cross(x);
        for (int row = 0; row < rows; ++row) {
            const double low = pi / 2 * row / rows, high = pi / 2 * (row + 1) / rows, middle = (low + high) / 2;
            const int count = 3 + int(4 * rows * std::cos(middle));
            for (int k = 0; k < count; ++k) {
                const double turn = 2 * pi * (k + 0.5) / count;
                const Vec3d w = std::sin(middle) * up_ + std::cos(middle) * (std::cos(turn) * x + std::sin(turn) * y);
                const double solid_angle = 2 * pi / count * (std::sin(high) - std::sin(low));
                samples_.push_back({w, solid_angle * radiance(w), solid_angle});
            }
        }
    }

    Vec3d up_, to_sun_;
    double scale_;
    Vec3d ground_;
    Perez Y_{}, x_{}, y_{};
    Vec3d zenith_;  // x, y [1], Y [kcd/m^2], each over its distribution in the zenith
    std::vector<Sample> samples_;
};

std::shared_ptr<const SkyModel> model(const SkyDescription& sky)
{
    if (!(sky.parameters[1].length() > 0)) throw InputError("sky's sun 0,0,0: expected a direction");
    return std::make_shared<Preetham>(sky);
}

constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace

const SkyKind preetham_kind{
    "preetham",
    {{"turbidity", schema::lit_sky_turbidity, false, least_turbidity, least_turbidity, most_turbidity},
     {"sun", schema::lit_sky_sun, true, 1, -infinity, infinity},
     {"scale", schema::lit_sky_scale, false, 0, 0, infinity},
     {"ground", schema::lit_sky_ground, true, 0, 0, infinity}},
    model};

Sky preetham_sky(const Vec3d& to_sun, const Vec3d& sun_irradiance, double turbidity, const Vec3d& up,
                 const std::optional<Vec3d>& ground)
{
    const double sine = to_sun.unit().dot(up.unit());
    if (!(sine > 0) || !(luminance(sun_irradiance) > 0)) {
        std::ostringstream what;
        what << "a clear sky about a sun towards " << to_sun << " of irradiance " << sun_irradiance
             << ": expected a sun above the horizon that shines";
        throw InputError(what.str());
    }
    const double height = std::asin(std::min(sine, 1.0)) * 180 / pi;
    const Vec3d scale(luminance(sun_irradiance) / luminance(sunlight(height, turbidity)));
    const Sky sky(preetham_kind, up, {Vec3d(turbidity), to_sun.unit(), scale, ground.value_or(Vec3d(0.0))});
    if (ground) return sky;
    constexpr double albedo = 0.2;
    const Vec3d lit = albedo * (sky.mean_inflow(up.unit()) + sine / pi * sun_irradiance);
    return Sky(preetham_kind, up, {Vec3d(turbidity), to_sun.unit(), scale, lit});
}

}  // namespace vdbcloud
