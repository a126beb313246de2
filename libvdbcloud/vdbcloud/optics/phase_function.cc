#include "vdbcloud/optics/phase_function.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace vdbcloud {

namespace {

/// cos_theta of Henyey-Greenstein as a function of t = 2 u - 1, u the cumulative distribution. The usual form divides
/// by 2 g and loses all digits towards g = 0; this form has no division by g.
double cosine_of(double g, double t)
{
    const double d = 1 + g * t;
    return (t + g * (t * t + 3) / 2 + g * g * t + g * g * g * (t * t - 1) / 2) / (d * d);
}

/// int_-1^t cosine_of(g, t')^2 dt'.
double square_integral(double g, double t)
{
    if (std::abs(g) < 0.2) {
        // The closed form loses digits as g^-3. Here the integrand's pole is at |t| > 5, where eight Gauss points
        // leave less than rounding.
        constexpr double node[] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
        constexpr double weight[] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};
        const double half = (t + 1) / 2, middle = (t - 1) / 2;
        double sum = 0;
        for (int k = 0; k < 4; ++k)
            for (const double side : {-1.0, 1.0}) {
                const double c = cosine_of(g, middle + side * half * node[k]);
                sum += weight[k] * c * c;
            }
        return half * sum;
    }
    // cosine = (1 + g^2 - s^2) / (2 g), s = (1 - g^2) / (1 + g t).
    const double a = 1 + g * g, b = (1 - g * g) * (1 - g * g);
    const auto primitive = [&](double x) {
        const double d = 1 + g * x;
        return (a * a * x + 2 * a * b / (g * d) - b * b / (3 * g * d * d * d)) / (4 * g * g);
    };
    return primitive(t) - primitive(-1);
}

/// 1 + alpha <cos^2>, by which a lobe is normalised.
double norm(const PhaseLobe& lobe) { return 1 + lobe.alpha * (1 + 2 * lobe.g * lobe.g) / 3; }

/// Any two unit vectors that make a right-handed frame with the unit vector w.
void frame_of(const Vec3d& w, Vec3d& x, Vec3d& y)
{
    x = (std::abs(w[0]) < 0.8 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0)).cross(w).unit();
    y = w.cross(x);
}

}  // namespace

bool PhaseParameter::allows(double value) const
{
    return open ? value > low && value < high : value >= low && value <= high;
}

std::string PhaseParameter::range() const
{
    std::ostringstream text;
    text << "a number in " << (open ? '(' : '[') << low << ", " << high << (open ? ')' : ']');
    return text.str();
}

std::string PhaseParameter::key() const
{
    std::string key = std::string("vdbcloud:") + name;
    std::replace(key.begin(), key.end(), '-', '_');
    return key;
}

double PhaseLobe::value(double cos_theta) const
{
    // (1-g)^2 + 2g(1-c) is 1 + g^2 - 2gc without the cancellation near g = 1 and c = 1; likewise a (1 + g) for 1 - g^2.
    const double a = 1.0 - g, d = a * a + 2.0 * g * (1.0 - cos_theta);
    const double henyey_greenstein = a * (1.0 + g) / (4.0 * pi * d * std::sqrt(d));
    if (alpha == 0) return weight * henyey_greenstein;
    return weight * henyey_greenstein * (1 + alpha * cos_theta * cos_theta) / norm(*this);
}

double PhaseLobe::moment(int l) const
{
    if (alpha == 0) return weight * std::pow(g, l);
    // c^2 P_l = up P_(l+2) + same P_l + down P_(l-2), by the recursion of P_l twice.
    const double up = (l + 1.0) * (l + 2.0) / ((2 * l + 1.0) * (2 * l + 3.0)),
                 same = (l + 1.0) * (l + 1.0) / ((2 * l + 1.0) * (2 * l + 3.0)) +
                        double(l) * l / ((2 * l + 1.0) * (2 * l - 1.0)),
                 down = l * (l - 1.0) / ((2 * l - 1.0) * (2 * l + 1.0));
    const double square = up * std::pow(g, l + 2) + same * std::pow(g, l) + (l >= 2 ? down * std::pow(g, l - 2) : 0.0);
    return weight * (std::pow(g, l) + alpha * square) / norm(*this);
}

double PhaseLobe::sample(double u) const
{
    double t = 2 * u - 1;
    if (alpha != 0) {
        // With t, 2 u - 1 of Henyey-Greenstein, as the variable: t + 1 + alpha int cos^2 dt = 2 norm u. The left side
        // is monotonic with a slope from 1 to 1 + alpha.
        const double wanted = 2 * norm(*this) * u;
        double low = -1, high = 1;
        for (int k = 0; k < 100 && high - low > 1e-15; ++k) {
            const double excess = t + 1 + alpha * square_integral(g, t) - wanted;
            (excess > 0 ? high : low) = t;
            const double c = cosine_of(g, t), step = excess / (1 + alpha * c * c), next = t - step;
            if (std::abs(step) < 1e-15) break;
            t = next > low && next < high ? next : (low + high) / 2;
        }
    }
    return std::clamp(cosine_of(g, t), -1.0, 1.0);
}

PhaseFunction::PhaseFunction(const std::string& name, std::vector<double> parameters)
    : form_(&phase_form(name)), parameters_(std::move(parameters))
{
    const auto& expected = form_->parameters;
    if (parameters_.size() > expected.size())
        throw InputError("phase function " + name + ": " + std::to_string(parameters_.size()) +
                         " parameters: expected " + std::to_string(expected.size()));
    for (size_t k = parameters_.size(); k < expected.size(); ++k) parameters_.push_back(expected[k].otherwise);
    for (size_t k = 0; k < expected.size(); ++k)
        if (!expected[k].allows(parameters_[k])) {
            std::ostringstream text;
            text << "phase function " << name << ": " << expected[k].name;
            if (!std::isnan(parameters_[k])) text << " = " << parameters_[k];
            text << ": expected " << expected[k].range();
            throw InputError(text.str());
        }
    lobes_ = form_->lobes(parameters_);
}

std::string PhaseFunction::text() const
{
    std::ostringstream text;
    text << name();
    for (size_t k = 0; k < parameters_.size(); ++k) text << ", " << form_->parameters[k].name << ' ' << parameters_[k];
    return text.str();
}

double PhaseFunction::operator()(double cos_theta) const
{
    double sum = 0;
    for (const PhaseLobe& lobe : lobes_) sum += lobe.value(cos_theta);
    return sum;
}

Vec3d PhaseFunction::sample(const Vec3d& incoming, double u, double v) const
{
    size_t k = 0;
    while (k + 1 < lobes_.size() && u >= lobes_[k].weight) u -= lobes_[k++].weight;
    const double c = lobes_[k].sample(std::min(u / lobes_[k].weight, 1.0)), s = std::sqrt(std::max(0.0, 1 - c * c));
    Vec3d x, y;
    frame_of(incoming, x, y);
    return (c * incoming + s * std::cos(2 * pi * v) * x + s * std::sin(2 * pi * v) * y).unit();
}

double PhaseFunction::moment(int l) const
{
    if (l == 0) return 1.0;
    double sum = 0;
    for (const PhaseLobe& lobe : lobes_) sum += lobe.moment(l);
    return sum;
}

int PhaseFunction::degree_below(double size) const
{
    // |m_l| <= weight |g|^(l-2): the moments of (1 + alpha c^2) / norm times the lobe are a mean of three powers of g.
    double degree = 3;
    for (const PhaseLobe& lobe : lobes_) {
        const double g = std::abs(lobe.g);
        if (g > 0 && lobe.weight > 0)
            degree = std::max(degree, 3 + std::ceil(std::log(size / double(lobes_.size())) / std::log(g)));
    }
    return int(std::min(degree, 1e9));
}

bool PhaseFunction::operator==(const PhaseFunction& other) const
{
    if (form_ != other.form_) return false;
    for (size_t k = 0; k < parameters_.size(); ++k) {
        const double a = parameters_[k], b = other.parameters_[k];
        if (std::abs(a - b) > 1e-9 * std::max(std::abs(a), std::abs(b))) return false;
    }
    return true;
}

}  // namespace vdbcloud
