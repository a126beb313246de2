#include "vdbcloud/scene/panorama.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/digest.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/grid/select.h"
#include "vdbcloud/scene/colour.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

constexpr int most_rows = 64;  // of parts

/// Of a row of some that share the sphere, from straight up.
double latitude(double row, int rows) { return pi * (0.5 - row / rows); }

double solid_angle(int row, int rows, int columns)
{
    return 2 * pi / columns * (std::sin(latitude(row, rows)) - std::sin(latitude(row + 1, rows)));
}

Vec3d direction_of(double row, int rows, double column, int columns)
{
    const double up = latitude(row, rows), turn = 2 * pi * (0.5 - column / columns);
    return {std::cos(up) * std::sin(turn), std::sin(up), std::cos(up) * std::cos(turn)};
}

void check_size(int width, int height, size_t values)
{
    const std::string size = std::to_string(width) + " x " + std::to_string(height);
    if (width != 2 * height || width < 8)
        throw InputError("a panorama of " + size +
                         " pixels: expected all latitudes by all longitudes, twice as wide as high, "
                         "8 pixels wide or more");
    if (width > Panorama::most_columns)
        throw InputError("a panorama of " + size + " pixels: expected at most " +
                         std::to_string(Panorama::most_columns) + " columns; make it smaller");
    if (values != size_t(width) * size_t(height) * 3)
        throw InputError("a panorama of " + size + " pixels without three values for each");
}

}  // namespace

Panorama::Panorama(int width, int height, std::vector<float> rgb) : width_(width), height_(height), rgb_(std::move(rgb))
{
    check_size(width, height, rgb_.size());
    for (float& value : rgb_) {
        if (!std::isfinite(value))
            throw InputError("a panorama with the value " + std::to_string(value) + ": expected finite numbers");
        value = std::max(value, 0.0f);
    }
    Digest digest;
    digest.add_value(width);
    digest.add_value(height);
    digest.add(rgb_.data(), rgb_.size() * sizeof(float));
    digest_ = digest.hex();
    const Vec3d first = texel(0, 0, true);
    bool one = true;
    for (size_t n = 0; one && n < rgb_.size(); n += 3)
        for (int c = 1; c < 3; ++c) one = one && rgb_[n + size_t(c)] * first[0] == rgb_[n] * first[c];
    one = one && first[0] > 0;
    tones_ = one ? std::vector<Vec3d>{first} : std::vector<Vec3d>{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    if (std::all_of(rgb_.begin(), rgb_.end(), [](float v) { return v == 0; })) tones_ = {Vec3d(0)};
    find_suns();
    find_parts();
}

Vec3d Panorama::texel(int row, int column, bool with_suns) const
{
    const size_t n = size_t(row) * size_t(width_) + size_t(column);
    const Vec3d whole{double(rgb_[3 * n]), double(rgb_[3 * n + 1]), double(rgb_[3 * n + 2])};
    if (with_suns || of_suns_.empty()) return whole;
    const auto found = of_suns_.find(n);
    return found == of_suns_.end() ? whole : whole * double(found->second);
}

Vec3d Panorama::radiance(const Vec3d& w, bool with_suns) const
{
    const double y = (0.5 - std::asin(std::clamp(w[1], -1.0, 1.0)) / pi) * height_ - 0.5;
    const double x = (0.5 - std::atan2(w[0], w[2]) / (2 * pi)) * width_ - 0.5;
    const int row = int(std::floor(y)), column = int(std::floor(x));
    const double fy = y - row, fx = x - column;
    Vec3d sum(0.0);
    for (int n = 0; n < 4; ++n) {
        const double weight = (n & 1 ? fx : 1 - fx) * (n & 2 ? fy : 1 - fy);
        const int at = (column + (n & 1) + width_) % width_;
        if (weight > 0) sum += weight * texel(std::clamp(row + (n >> 1), 0, height_ - 1), at, with_suns);
    }
    return sum;
}

void Panorama::find_suns()
{
    const auto brightness = [&](size_t n) {
        return luminance(Vec3d(double(rgb_[3 * n]), double(rgb_[3 * n + 1]), double(rgb_[3 * n + 2])));
    };
    double mean = 0;
    for (int row = 0; row < height_; ++row) {
        double sum = 0;
        for (int column = 0; column < width_; ++column)
            sum += brightness(size_t(row) * size_t(width_) + size_t(column));
        mean += sum * solid_angle(row, height_, width_) / (4 * pi);
    }
    const double most = sun_contrast * mean;
    struct Found {
        Sun sun;
        double power;
        std::vector<size_t> texels;
    };
    std::vector<Found> found;
    std::vector<char> seen(size_t(width_) * size_t(height_), 0);
    for (size_t start = 0; start < seen.size() && most > 0; ++start) {
        if (seen[start] || !(brightness(start) > most)) continue;
        Found of{{Vec3d(0), Vec3d(0), 0}, 0, {start}};
        seen[start] = 1;
        double square = 0;
        for (size_t k = 0; k < of.texels.size(); ++k) {
            const int row = int(of.texels[k] / size_t(width_)), column = int(of.texels[k] % size_t(width_));
            const double weight = solid_angle(row, height_, width_), bright = brightness(of.texels[k]);
            const double excess = bright - most;
            of.power += weight * excess;
            square += weight * excess * excess;
            of.sun.irradiance += weight * excess / bright * texel(row, column, true);
            of.sun.direction += weight * excess * direction_of(row + 0.5, height_, column + 0.5, width_);
            for (int n = 0; n < 9; ++n) {
                const int r = row + n / 3 - 1, c = (column + n % 3 - 1 + width_) % width_;
                if (r < 0 || r >= height_) continue;
                const size_t next = size_t(r) * size_t(width_) + size_t(c);
                if (seen[next] || !(brightness(next) > most)) continue;
                seen[next] = 1;
                of.texels.push_back(next);
            }
        }
        const double size = of.power * of.power / square;
        if (!(size <= sun_size)) continue;
        of.sun.direction.normalize();
        of.sun.diameter = 2 * std::acos(1 - size / (2 * pi)) * 180 / pi;
        found.push_back(std::move(of));
    }
    std::stable_sort(found.begin(), found.end(), [](const Found& a, const Found& b) { return a.power > b.power; });
    found.resize(std::min(found.size(), most_suns), {{Vec3d(0), Vec3d(0), 0}, 0, {}});
    for (const Found& of : found) {
        suns_.push_back(of.sun);
        for (const size_t n : of.texels) of_suns_[n] = float(most / brightness(n));
    }
}

void Panorama::find_parts()
{
    const int rows = std::min(most_rows, height_ & ~1), columns = 2 * rows, fine = (height_ - 1) / rows + 1;
    parts_.resize(size_t(rows) * size_t(columns));
    tbb::parallel_for(0, rows, [&](int row) {
        for (int column = 0; column < columns; ++column) {
            Vec3d sum(0);
            double weights = 0;
            for (int n = 0; n < fine * fine; ++n) {
                const double r = row + (n / fine + 0.5) / fine, c = column + (n % fine + 0.5) / fine;
                const double weight = std::cos(latitude(r, rows));
                weights += weight;
                sum += weight * radiance(direction_of(r, rows, c, columns), false);
            }
            parts_[size_t(row) * size_t(columns) + size_t(column)] = {
                direction_of(row + 0.5, rows, column + 0.5, columns), sum / weights, solid_angle(row, rows, columns)};
        }
    });
}

std::shared_ptr<const Panorama> panorama_of(const GridFile& file)
{
    const GridBasePtr grid = find_grid(file, schema::environment);
    if (!grid) return nullptr;
    const auto texels = openvdb::gridPtrCast<Vec3SGrid>(grid);
    if (!texels)
        throw InputError("grid 'environment' of type " + grid->valueType() + ": expected radiances of type vec3s");
    const auto box = texels->evalActiveVoxelBoundingBox();
    const auto size = box.empty() ? openvdb::Coord(0, 0, 0) : box.dim();
    if (size.z() > 1 || size.x() > Panorama::most_columns || size.y() > Panorama::most_columns || size.x() < 1)
        throw InputError("grid 'environment' of " + std::to_string(size.x()) + " x " + std::to_string(size.y()) +
                         " x " + std::to_string(size.z()) + " voxels: expected one layer, at most " +
                         std::to_string(Panorama::most_columns) + " wide");
    std::vector<float> rgb(size_t(size.x()) * size_t(size.y()) * 3);
    auto accessor = texels->getConstAccessor();
    for (int y = 0; y < size.y(); ++y)
        for (int x = 0; x < size.x(); ++x) {
            const Vec3f value = accessor.getValue(box.min() + openvdb::Coord(x, y, 0));
            for (int c = 0; c < 3; ++c) rgb[3 * (size_t(y) * size_t(size.x()) + size_t(x)) + size_t(c)] = value[c];
        }
    return std::make_shared<Panorama>(size.x(), size.y(), std::move(rgb));
}

void put_panorama(GridFile& file, const std::shared_ptr<const Panorama>& panorama)
{
    remove_grids(file, [](const std::string& name) { return name == schema::environment; });
    if (!panorama) return;
    auto grid = Vec3SGrid::create(Vec3f(0.0f));
    grid->setName(schema::environment);
    auto accessor = grid->getAccessor();
    for (int y = 0; y < panorama->height(); ++y)
        for (int x = 0; x < panorama->width(); ++x) {
            const float* from = &panorama->rgb()[3 * (size_t(y) * size_t(panorama->width()) + size_t(x))];
            accessor.setValueOn(openvdb::Coord(x, y, 0), Vec3f(from[0], from[1], from[2]));
        }
    file.grids.push_back(grid);
}

}  // namespace vdbcloud
