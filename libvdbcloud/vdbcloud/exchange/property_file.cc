#include "vdbcloud/exchange/property_file.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/shortest.h"
#include "vdbcloud/file/text.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace vdbcloud {

namespace {

/// The words of a text, one after the other, as numbers.
class Numbers {
public:
    Numbers(const std::string& path, const std::string& text, size_t begin) : path_(path), text_(text), at_(begin) {}

    bool more()
    {
        at_ = text_.find_first_not_of(" \t\r\n,", at_);
        return at_ != std::string::npos;
    }

    double number(const char* what)
    {
        if (!more()) fail(std::string("ends before ") + what);
        const size_t end = std::min(text_.find_first_of(" \t\r\n,", at_), text_.size());
        std::string word = text_.substr(at_, end - at_);
        for (char& c : word)
            if (c == 'D' || c == 'd') c = 'e';  // Fortran's double precision
        const char* const first = word.data() + (word[0] == '+');
        double value = 0;
        const auto [rest, error] = std::from_chars(first, word.data() + word.size(), value);
        if (error != std::errc() || rest != word.data() + word.size() || !std::isfinite(value))
            fail(std::string(what) + " '" + printable(word, 40) + "': expected a finite number");
        at_ = end;
        return value;
    }

    size_t whole(const char* what, size_t least, size_t most)
    {
        const double value = number(what);
        if (!(value >= double(least) && value <= double(most)) || value != std::floor(value))
            fail(std::string(what) + " " + shortest(value) + ": expected a whole number from " + std::to_string(least) +
                 " to " + std::to_string(most));
        return size_t(value);
    }

    [[noreturn]] void fail(const std::string& what) const
    {
        const auto lines = std::count(text_.begin(), text_.begin() + std::ptrdiff_t(std::min(at_, text_.size())), '\n');
        throw InputError(printable(path_, 4096) + ": line " + std::to_string(lines + 1) + ": " + what);
    }

private:
    const std::string &path_, &text_;
    size_t at_;
};

/// The grid: nx ny nz, spacing along x and y, levels.
Cells read_grid(Numbers& in)
{
    constexpr size_t most = 1 << 20;
    const size_t nx = in.whole("Nx", 1, most), ny = in.whole("Ny", 1, most), nz = in.whole("Nz", 1, most);
    if (double(nx) * double(ny) * double(nz) > 1 << 28) in.fail("more than 2^28 grid points");
    const double dx = in.number("delX"), dy = in.number("delY");
    if (!(dx > 0 && dy > 0)) in.fail("spacing " + shortest(dx) + ", " + shortest(dy) + ": expected numbers above 0");
    std::vector<double> levels(nz);
    for (double& level : levels) level = in.number("a level");
    Cells cells;
    cells.edges[0] = equal_edges(-dx / 2, dx, nx);
    cells.edges[1] = equal_edges(-dy / 2, dy, ny);
    try {
        cells.edges[2] = edges_between(levels, dx, "levels");
    } catch (const InputError& e) {
        in.fail(e.what());
    }
    return cells;
}

/// Mean cosine of each tabulated phase function.
std::vector<double> read_cosines(Numbers& in)
{
    std::vector<double> cosines(in.whole("number of phase functions", 1, 1 << 20));
    for (double& g : cosines) {
        const size_t terms = in.whole("number of Legendre coefficients", 0, 1 << 20);
        for (size_t l = 1; l <= terms; ++l) {
            const double chi = in.number("a Legendre coefficient");
            if (l == 1) g = chi / 3;
        }
        if (!(std::abs(g) <= 1)) in.fail("first Legendre coefficient " + shortest(3 * g) + ": expected -3 to 3");
    }
    return cosines;
}

void read_points(Numbers& in, const std::vector<double>& cosines, PropertyField& field)
{
    const size_t nx = field.cells.count(0), ny = field.cells.count(1), nz = field.cells.count(2);
    for (auto* values : {&field.extinction, &field.albedo, &field.temperature}) values->assign(nx * ny * nz, 0.0f);
    double scattered = 0, cosine = 0;
    size_t points = 0;
    for (; in.more(); ++points) {
        const size_t x = in.whole("ix", 1, nx) - 1, y = in.whole("iy", 1, ny) - 1, z = in.whole("iz", 1, nz) - 1;
        const size_t at = x + nx * (y + ny * z);
        const double temperature = in.number("temperature"), extinction = in.number("extinction"),
                     albedo = in.number("albedo");
        const size_t phase = in.whole("number of the phase function", extinction > 0 ? 1 : 0, cosines.size());
        if (!(temperature >= 0 && temperature <= 1e9)) in.fail("temperature " + shortest(temperature));
        if (!(extinction >= 0 && extinction <= 1e30))
            in.fail("extinction " + shortest(extinction) + ": expected 0 to 1e30");
        if (!(albedo >= 0 && albedo <= 1)) in.fail("albedo " + shortest(albedo) + ": expected 0 to 1");
        field.temperature[at] = float(temperature);
        field.extinction[at] = float(extinction);
        field.albedo[at] = float(extinction > 0 ? albedo : 0);
        const double scatters = extinction * albedo;
        scattered += scatters;
        if (phase > 0) cosine += scatters * cosines[phase - 1];
    }
    field.g = scattered > 0 ? std::clamp(cosine / scattered, -1.0, 1.0) : 0;
    field.said.push_back(std::to_string(points) + " of " + std::to_string(nx * ny * nz) + " grid points are given, " +
                         std::to_string(cosines.size()) + " phase functions");
}

void make_equal(PropertyField& field, const Vec3d& size)
{
    const Cells equal = equal_cells(field.cells, size);
    std::vector<float> scattering = field.extinction;
    for (size_t k = 0; k < scattering.size(); ++k) scattering[k] *= field.albedo[k];
    scattering = resampled(field.cells, scattering, equal);
    field.extinction = resampled(field.cells, field.extinction, equal);
    field.temperature = resampled(field.cells, field.temperature, equal);
    field.albedo.assign(scattering.size(), 0.0f);
    for (size_t k = 0; k < scattering.size(); ++k)
        if (field.extinction[k] > 0) field.albedo[k] = std::min(scattering[k] / field.extinction[k], 1.0f);
    if (equal.size() != field.cells.size())
        field.said.push_back("levels of unequal distance resampled onto cells of " +
                             shortest(equal.edges[2][1] - equal.edges[2][0]) +
                             "; the optical depth of each column is kept");
    field.cells = equal;
}

}  // namespace

PropertyField read_property_file(const std::string& path, const Vec3d& cell)
{
    const std::string text = read_text(path, uint64_t(1) << 30, "property file");
    const size_t first = text.find_first_not_of(" \t\r\n");
    if (first == std::string::npos || text[first] != 'T')
        throw InputError(printable(path, 4096) +
                         ": line 1: expected T, the tabulated-phase-function format of SHDOM, as "
                         "its program propgen writes");
    Numbers in(path, text, std::min(text.find('\n', first), text.size()));
    PropertyField field;
    field.cells = read_grid(in);
    const std::vector<double> cosines = read_cosines(in);
    read_points(in, cosines, field);
    make_equal(field, cell);
    return field;
}

}  // namespace vdbcloud
