#include "hard/body.h"

#include "hard/draw.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/file/io.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <stdexcept>

namespace vdbcloud::test {

namespace {

openvdb::Coord coord(const Vec3i& i) { return {i[0], i[1], i[2]}; }

/// NAME=VALUE words of a line.
class Values {
public:
    explicit Values(const Words& words)
    {
        for (const std::string& word : words)
            if (const size_t equals = word.find('='); equals != std::string::npos)
                text_[word.substr(0, equals)] = word.substr(equals + 1);
    }
    double number(const std::string& name, double otherwise) const
    {
        const auto found = text_.find(name);
        return found == text_.end() ? otherwise : std::stod(found->second);
    }
    /// Three numbers, or one for all.
    Vec3i size() const
    {
        const auto found = text_.find("n");
        if (found == text_.end()) return Vec3i(8);
        Vec3i n(std::stoi(found->second));
        if (const size_t a = found->second.find(','); a != std::string::npos) {
            n[1] = std::stoi(found->second.substr(a + 1));
            n[2] = std::stoi(found->second.substr(found->second.find(',', a + 1) + 1));
        }
        return n;
    }

private:
    std::map<std::string, std::string> text_;
};

using Visit = std::function<void(const Vec3i&, double)>;

void each_voxel(const Vec3i& n, const std::function<void(const Vec3i&)>& visit)
{
    for (int i = 0; i < n[0]; ++i)
        for (int j = 0; j < n[1]; ++j)
            for (int k = 0; k < n[2]; ++k) visit(Vec3i(i, j, k));
}

void noise(const Values& values, const Visit& set)
{
    Draw draw(uint64_t(values.number("seed", 1)));
    const double empty = values.number("void", 0), low = values.number("low", 0.1), high = values.number("high", 1);
    each_voxel(values.size(), [&](const Vec3i& i) {
        const bool there = !draw.chance(empty);
        const double value = draw.logarithmic(low, high);
        if (there) set(i, value);
    });
}

void ball(const Values& values, const Visit& set)
{
    const int n = values.size()[0];
    const double middle = 0.5 * (n - 1), radius = 0.5 * n;
    each_voxel(Vec3i(n), [&](const Vec3i& i) {
        const double r = (Vec3d(i) - Vec3d(middle)).length();
        if (r < radius) set(i, std::min(1.0, 2 * (1 - r / radius)));
    });
}

/// Two values by turns along `dimensions` axes.
void turns(const Values& values, int dimensions, const Visit& set)
{
    const double both[] = {values.number("low", 1), values.number("high", 1e6)};
    each_voxel(values.size(), [&](const Vec3i& i) {
        int sum = 0;
        for (int c = 0; c < dimensions; ++c) sum += i[c];
        set(i, both[sum % 2]);
    });
}

bool set_voxels(const std::string& kind, const Values& values, const Visit& set)
{
    const double value = values.number("value", 1);
    const int distance = int(values.number("distance", 100));
    if (kind == "noise") return noise(values, set), true;
    if (kind == "ball") return ball(values, set), true;
    if (kind == "layers") return turns(values, 1, set), true;
    if (kind == "rows") return turns(values, 2, set), true;
    if (kind == "checker") return turns(values, 3, set), true;
    if (kind == "box" || kind == "stray") each_voxel(values.size(), [&](const Vec3i& i) { set(i, value); });
    if (kind == "stray") set(Vec3i(distance, 0, 0), value);
    const int at = int(values.number("at", 10000000));
    if (kind == "far") each_voxel(values.size(), [&](const Vec3i& i) { set(Vec3i(at) + i, value); });
    if (kind == "line")
        for (int i = 0; i < values.size()[0]; ++i) set(Vec3i(i), value);
    if (kind == "spread") each_voxel(values.size(), [&](const Vec3i& i) { set(distance * i, value); });
    return kind == "box" || kind == "stray" || kind == "far" || kind == "line" || kind == "spread" || kind == "empty";
}

FloatGridPtr named(const std::string& name)
{
    auto grid = FloatGrid::create(0.0f);
    grid->setName(name);
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    return grid;
}

FloatGridPtr density(Programs& programs, const Words& words, const Values& values, const Change& change,
                     const std::string& folder)
{
    const auto grid = named("density");
    auto accessor = grid->getAccessor();
    const double times = values.number("times", 1) * change.density;
    const auto set = [&](const Vec3i& i, double value) {
        accessor.setValue(coord(change.index(i)), float(value * times));
    };
    if (words[0] == "tile") {
        const openvdb::Coord ends[] = {{7, 7, 7}, {127, 127, 127}, {4095, 4095, 4095}};
        grid->sparseFill({openvdb::Coord(0), ends[int(values.number("level", 1)) - 1]}, float(times));
        return grid;
    }
    if (words[0] == "fractal") {
        Words options{"-o", folder + "/fractal.vdb", "--threads", "1", "-q"};
        std::copy_if(words.begin() + 1, words.end(), std::back_inserter(options),
                     [](const std::string& word) { return word.find('=') == std::string::npos; });
        if (programs.run("fractalgen", options, folder).status != 0)
            throw std::runtime_error("fractalgen: " + read_text(folder + "/stderr"));
        const auto file = read_own(folder + "/fractal.vdb");
        const auto made = openvdb::gridPtrCast<FloatGrid>(find_grid(file, "density"));
        for (auto v = made->cbeginValueOn(); v; ++v) {
            const openvdb::Coord c = v.getCoord();
            set(Vec3i(c.x(), c.y(), c.z()), *v);
        }
        return grid;
    }
    if (!set_voxels(words[0], values, set)) throw std::runtime_error("no body is called " + words[0]);
    return grid;
}

Vec3SGridPtr vectors(const FloatGrid& like, const std::string& name, float background,
                     const std::function<openvdb::Vec3f(const openvdb::Coord&, float)>& f)
{
    auto grid = openvdb::Vec3SGrid::create(openvdb::Vec3f(background));
    grid->setName(name);
    auto accessor = grid->getAccessor();
    for (auto v = like.cbeginValueOn(); v; ++v) accessor.setValue(v.getCoord(), f(v.getCoord(), *v));
    return grid;
}

/// A matrix with small voxels is called singular, a scaling is not.
openvdb::math::Transform::Ptr transform_of(const std::array<Vec3d, 3>& axes, const Vec3d& first, const Change& change)
{
    openvdb::math::Mat4d to_world = openvdb::math::Mat4d::identity();
    bool diagonal = true;
    Vec3d at_zero = first;
    for (int c = 0; c < 3; ++c) {
        const Vec3d step = double(change.sign[size_t(c)]) * change.point(axes[size_t(change.axis[size_t(c)])]);
        at_zero -= double(change.shift[c]) * step;
        for (int d = 0; d < 3; ++d) {
            to_world[c][d] = step[d];
            diagonal = diagonal && (c == d || step[d] == 0);
        }
    }
    auto transform = openvdb::math::Transform::createLinearTransform();
    if (diagonal)
        transform->preScale(Vec3d(to_world[0][0], to_world[1][1], to_world[2][2]));
    else
        transform = openvdb::math::Transform::createLinearTransform(to_world);
    transform->postTranslate(at_zero);
    return transform;
}

}  // namespace

GridFile make_body(Programs& programs, const std::string& line, const std::array<Vec3d, 3>& axes, const Vec3d& origin,
                   const Change& change, const std::string& folder)
{
    openvdb::initialize();
    const Words words = split(line);
    const Values values(words);
    const FloatGridPtr grid = density(programs, words, values, change, folder);
    GridFile file{"memory", {grid}, std::make_shared<MetaMap>()};
    if (const double emission = values.number("emission", 0); emission > 0)
        file.grids.push_back(vectors(*grid, "emission", 0, [&](const openvdb::Coord&, float density_here) {
            return float(emission * change.power) * density_here * openvdb::Vec3f(1, 0.5f, 0.25f);
        }));
    if (const double kelvin = values.number("fire", 0); kelvin != 0)
        for (const auto& [name, at_1] : {std::pair{"temperature", kelvin}, {"flame", 1.0}}) {
            const FloatGridPtr hot = grid->deepCopy();
            hot->setName(name);
            for (auto v = hot->beginValueAll(); v; ++v) v.setValue(float(at_1 * double(*v)));
            file.grids.push_back(hot);
        }
    if (const double seed = values.number("cd", 0); seed > 0)
        file.grids.push_back(vectors(*grid, "Cd", 1, [&](const openvdb::Coord& c, float) {
            // By the voxel of the world, so that twins have the same colours.
            Vec3i i;
            for (int k = 0; k < 3; ++k) i[change.axis[size_t(k)]] = change.sign[size_t(k)] * (c[k] - change.shift[k]);
            Draw draw(uint64_t(seed) * 1000003u + uint64_t(i[0] * 10007 + i[1] * 101 + i[2] + 1000000));
            return openvdb::Vec3f(float(draw.uniform()), float(draw.uniform()), float(draw.uniform()));
        }));
    const auto transform = transform_of(axes, change.point(origin), change);
    for (const GridBasePtr& one : file.grids) one->setTransform(transform);
    return file;
}

std::optional<std::string> table_of_body(const std::string& line)
{
    if (line.rfind("table ", 0) != 0) return std::nullopt;
    std::string text;
    for (const std::string& word : split(line.substr(6))) text += word == "/" ? "\n" : word + " ";
    return text + "\n";
}

GridFile read_own(const std::string& path)
{
    ReadOptions options;
    options.trust = true;
    return read_grid_file(path, options);
}

void write_own(const std::string& path, const GridFile& file)
{
    WriteOptions options;
    options.compression = Compression::None;
    write_grid_file(path, file, options);
}

FloatGridPtr density_of_body(const GridFile& file) { return openvdb::gridPtrCast<FloatGrid>(file.grids.at(0)); }

}  // namespace vdbcloud::test
