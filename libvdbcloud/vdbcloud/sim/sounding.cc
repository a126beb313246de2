#include "vdbcloud/sim/sounding.h"

#include "vdbcloud/core/error.h"

#include <cmath>
#include <sstream>

namespace vdbcloud::sim {

Sounding read_sounding(const std::string& name, const std::string& text)
{
    Sounding s;
    s.name = name;
    std::istringstream lines(text);
    std::string line;
    for (int number = 1; std::getline(lines, line); ++number) {
        const auto refuse = [&](const std::string& what) {
            throw InputError(printable(name) + ": line " + std::to_string(number) + ": " + what);
        };
        line = line.substr(0, line.find('#'));
        std::istringstream words(line);
        std::string first;
        if (!(words >> first)) continue;
        if (first == "pressure") {
            double hectopascal = 0;
            if (!(words >> hectopascal) || !(hectopascal > 0 && hectopascal < 1e5)) refuse("expected 'pressure HPA'");
            s.pressure = 100 * hectopascal;
            continue;
        }
        std::istringstream values(line);
        std::vector<double> row;
        for (double x; values >> x;) row.push_back(x);
        if (!values.eof() || row.size() < 3 || row.size() == 4 || row.size() > 5)
            refuse("'" + printable(line, 60) + "': expected z theta q, or z theta q u v");
        for (const double x : row)
            if (!std::isfinite(x)) refuse("expected finite numbers");
        if (!s.z.empty() && row[0] <= s.z.back()) refuse("expected heights that increase");
        s.z.push_back(row[0]), s.theta.push_back(row[1]), s.water.push_back(1e-3 * row[2]);
        s.u.push_back(row.size() == 5 ? row[3] : 0), s.v.push_back(row.size() == 5 ? row[4] : 0);
    }
    if (s.z.empty()) throw InputError(printable(name) + ": expected a table of z theta q u v");
    return s;
}

void add_wind(Sounding& s, double u0, double v0, double shear_u, double shear_v)
{
    if (shear_u != 0 || shear_v != 0) {  // linear from the floor up, beyond the table's own top, too
        const double top = std::max(s.z.back(), 0.0) + 1e5;
        if (s.z.front() > 0) {
            s.z.insert(s.z.begin(), 0);
            for (auto* f : {&s.theta, &s.water, &s.u, &s.v}) f->insert(f->begin(), f->front());
        }
        s.z.push_back(top);
        for (auto* f : {&s.theta, &s.water, &s.u, &s.v}) f->push_back(f->back());
    }
    for (size_t i = 0; i < s.z.size(); ++i) s.u[i] += u0 + shear_u * s.z[i], s.v[i] += v0 + shear_v * s.z[i];
    if (shear_u != 0 || shear_v != 0) {
        // The last entry only carries the slope of the wind; theta and water stay constant above the table.
        const size_t n = s.z.size();
        const double limit = 3e4, f = (limit - s.z[n - 2]) / (s.z[n - 1] - s.z[n - 2]);
        if (f > 0 && f < 1) {
            s.u[n - 1] = s.u[n - 2] + f * (s.u[n - 1] - s.u[n - 2]);
            s.v[n - 1] = s.v[n - 2] + f * (s.v[n - 1] - s.v[n - 2]);
            s.z[n - 1] = limit;
        }
    }
}

}  // namespace vdbcloud::sim
