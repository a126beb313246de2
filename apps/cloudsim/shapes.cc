#include "shapes.h"

#include "frames.h"
#include "inputs.h"
#include "option_words.h"
#include "solid_options.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/density.h"
#include "vdbcloud/grid/digest.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/grid/select.h"
#include "vdbcloud/grid/up_axis.h"

#include <openvdb/tools/Interpolation.h>

#include <algorithm>
#include <cmath>

namespace vdbcloud::app {

namespace {

using sim::Point;

/// From positions over the ground to the world of a file, whose unit has `metres`: the box stands on the origin.
struct Place {
    double length_x, length_y;  // of the box [m]
    UpAxis up;
    double metres;

    Vec3d world(const Point& p) const
    {
        const double x = p[0] - 0.5 * length_x, y = p[1] - 0.5 * length_y;
        return (up == UpAxis::Y ? Vec3d(x, p[2], y) : Vec3d(x, y, p[2])) / metres;
    }
    Point ground(const Vec3d& world) const
    {
        const Vec3d w = world * metres;
        return {w[0] + 0.5 * length_x, (up == UpAxis::Y ? w[2] : w[1]) + 0.5 * length_y, up == UpAxis::Y ? w[1] : w[2]};
    }
};

/// Corners of the box about the active voxels of a grid.
std::array<Point, 2> bounds_of(const GridBase& grid, const Place& place)
{
    const auto box = grid.evalActiveVoxelBoundingBox();
    std::array<Point, 2> bounds{Point{1e30, 1e30, 1e30}, Point{-1e30, -1e30, -1e30}};
    if (box.empty()) return bounds;
    for (const int corner : {0, 1, 2, 3, 4, 5, 6, 7}) {
        const auto end = [&](int axis) { return corner >> axis & 1 ? box.max()[axis] + 1.0 : box.min()[axis] - 1.0; };
        const Point p = place.ground(grid.transform().indexToWorld(Vec3d(end(0), end(1), end(2))));
        for (const size_t d : {0, 1, 2})
            bounds[0][d] = std::min(bounds[0][d], p[d]), bounds[1][d] = std::max(bounds[1][d], p[d]);
    }
    return bounds;
}

double distance_to(const Solid& s, const Vec3d& x)
{
    switch (s.kind) {
    case SolidKind::Plane: return (x - s.place).dot(s.extent);
    case SolidKind::Sphere: return (x - s.place).length() - s.extent[0];
    case SolidKind::Box: {
        const Vec3d beyond = openvdb::math::maxComponent(s.place - x, x - s.extent);
        const double inside = std::min(0.0, std::max({beyond[0], beyond[1], beyond[2]}));
        return openvdb::math::maxComponent(beyond, Vec3d(0.0)).length() + inside;
    }
    default: {
        const auto accessor = s.level_set->getConstAccessor();
        return double(openvdb::tools::BoxSampler::sample(accessor, s.level_set->transform().worldToIndex(x)));
    }
    }
}

/// A body: one solid.
class Body final : public sim::Shape {
public:
    Body(Solid solid, const Place& place, std::string identity)
        : solid_(std::move(solid)), place_(place), identity_(std::move(identity))
    {
    }
    bool body() const override { return true; }
    double distance(const Point& p) const override { return place_.metres * distance_to(solid_, place_.world(p)); }
    std::array<Point, 2> bounds() const override
    {
        std::array<Point, 2> bounds{Point{1e30, 1e30, 1e30}, Point{-1e30, -1e30, -1e30}};
        if (solid_.kind == SolidKind::Plane) std::swap(bounds[0], bounds[1]);
        for (const Vec3d& corner : corners_of(solid_)) {
            const Point p = place_.ground(corner);
            for (const size_t d : {0, 1, 2})
                bounds[0][d] = std::min(bounds[0][d], p[d]), bounds[1][d] = std::max(bounds[1][d], p[d]);
        }
        return bounds;
    }
    std::string identity() const override { return identity_; }

private:
    Solid solid_;
    Place place_;
    std::string identity_;
};

/// The mask of a fog volume, or of numbered ones, linear between two frames. The first frame holds before its time, the
/// last one after it.
class Mask final : public sim::Shape {
public:
    using Read = std::function<FloatGridPtr(int frame)>;

    Mask(Read read, int frames, double from, double every, const Place& place, std::string identity)
        : read_(std::move(read)), frames_(frames), from_(from), every_(every), place_(place),
          identity_(std::move(identity))
    {
        load(0);
    }
    bool body() const override { return false; }
    bool changes() const override { return frames_ > 1; }
    std::vector<double> times() const override
    {
        std::vector<double> list;
        for (int frame = 0; changes() && frame < frames_; ++frame) list.push_back(from_ + frame * every_);
        return list;
    }
    double value(const Point& p, double time) const override
    {
        const double at = frames_ > 1 ? std::clamp((time - from_) / every_, 0.0, double(frames_ - 1)) : 0;
        const int first = std::min(int(at), std::max(0, frames_ - 2));
        if (first != loaded_) load(first);
        const double part = at - first, early = sample(grid_[0], p);
        return part > 0 ? early + part * (sample(grid_[1], p) - early) : early;
    }
    std::array<Point, 2> bounds() const override
    {
        if (frames_ > 1) return {Point{-1e30, -1e30, -1e30}, Point{1e30, 1e30, 1e30}};
        return bounds_of(*grid_[0], place_);
    }
    std::string identity() const override { return identity_; }

private:
    void load(int first) const
    {
        grid_[0] = first == loaded_ + 1 && grid_[1] ? grid_[1] : read_(first);
        grid_[1] = frames_ > 1 ? read_(first + 1) : nullptr;
        loaded_ = first;
    }
    double sample(const FloatGridPtr& grid, const Point& p) const
    {
        return std::max(
            0.0f, openvdb::tools::BoxSampler::sample(grid->tree(), grid->transform().worldToIndex(place_.world(p))));
    }

    Read read_;
    int frames_;
    double from_, every_;
    Place place_;
    std::string identity_;
    mutable std::array<FloatGridPtr, 2> grid_;
    mutable int loaded_ = -2;
};

bool ends_with_vdb(const std::string& text) { return text.size() > 4 && text.substr(text.size() - 4) == ".vdb"; }

std::string last_digest(App& app) { return app.report()["inputs"].back()["digest"].get<std::string>(); }

Place place_in(const GridFile& file, const Place& otherwise)
{
    Place place = otherwise;
    place.up = read_up_axis(*file.metadata).value_or(otherwise.up);
    place.metres = get_number(*file.metadata, schema::meters_per_unit, 1);
    return place;
}

/// The level set that a file holds, or nothing.
FloatGridPtr level_set_in(const GridFile& file, const std::string& name)
{
    for (const GridBasePtr& grid : file.grids)
        if (grid->getGridClass() == openvdb::GRID_LEVEL_SET && grid->isType<FloatGrid>() &&
            (name.empty() || grid->getName() == name))
            return openvdb::gridPtrCast<FloatGrid>(grid);
    return nullptr;
}

std::shared_ptr<const sim::Shape> shape_of_file(App& app, OptionWords& words, const Place& box, double from)
{
    const std::string name = words.value("grid");
    const auto pattern = FramePattern::in(words.option(), words.shape);
    const double every = pattern ? words.time("every", std::nullopt) : 0;
    const std::vector<int> numbers = pattern ? pattern->existing() : std::vector<int>{0};
    if (numbers.empty()) words.refuse("no file of this name is there");
    const auto path = [pattern, numbers, shape = words.shape](int frame) {
        return pattern ? pattern->path(numbers[size_t(frame)]) : shape;
    };
    const GridFile first = app.read(path(0));
    const std::string identity = last_digest(app) + (name.empty() ? "" : ":" + name);
    const Place place = place_in(first, box);
    if (const FloatGridPtr surface = level_set_in(first, name)) {
        if (pattern) words.refuse("numbered level sets: expected numbered fog volumes");
        const Solid solid = make_level_set(surface);
        check(solid);
        return std::make_shared<Body>(solid, place, identity);
    }
    const auto read = [&app, path, name](int frame) {
        GridFile file = app.read(path(frame));
        return density_of(file, name, app.warnings());
    };
    const auto once = [&app, name, file = std::make_shared<GridFile>(first), read](int frame) {
        return frame == 0 ? density_of(*file, name, app.warnings()) : read(frame);
    };
    return std::make_shared<Mask>(once, int(numbers.size()), from, every, place,
                                  identity + (pattern ? "x" + std::to_string(numbers.size()) : ""));
}

std::shared_ptr<const sim::Shape> shape_of(App& app, OptionWords& words, std::vector<std::string>& known,
                                           const Place& box, double from)
{
    const Vec3d up = box.up == UpAxis::Y ? Vec3d(0, 1, 0) : Vec3d(0, 0, 1);
    if (const auto solid = plain_solid(words, up, known)) {
        check(*solid);
        Digest digest;
        digest.add_text(solids_digest({*solid}, false));
        return std::make_shared<Body>(*solid, box, digest.hex());
    }
    if (!ends_with_vdb(words.shape))
        words.refuse("'" + words.shape + "': expected plane, sphere, box, or the path of a .vdb");
    known = {"grid=NAME", "every=TIME"};
    return shape_of_file(app, words, box, from);
}

sim::FieldSource source_of(App& app, const std::string& text, const Place& box)
{
    OptionWords words("--source", text);
    sim::FieldSource s;
    s.from = words.time("start", 0.0), s.until = words.time("end", sim::never), s.ramp = words.time("ramp", 0.0);
    std::vector<std::string> known;
    s.shape = shape_of(app, words, known, box, s.from);
    s.heat = words.size("heat", 0.0), s.water = words.size("water", 0.0);
    s.dye = words.size("dye", 0.0), s.fuel = words.size("fuel", 0.0);
    const std::string velocity = words.peek("velocity"), temperature = words.peek("temperature");
    s.has_velocity = !velocity.empty(), s.has_temperature = !temperature.empty();
    if (s.has_velocity) {
        const Vec3d v = words.place("velocity", std::nullopt);
        s.velocity = {v[0], box.up == UpAxis::Y ? v[2] : v[1], box.up == UpAxis::Y ? v[1] : v[2]};
    }
    if (s.has_temperature) s.temperature = words.size("temperature", std::nullopt);
    if (s.has_velocity || s.has_temperature) s.rate = words.size("rate", std::nullopt);
    known.insert(known.end(), {"heat=K/s", "water=1/s", "dye=1/s", "fuel=1/s", "velocity=x,y,z", "temperature=K",
                               "rate=1/s (of these two)", "start=TIME", "end=TIME", "ramp=TIME"});
    words.finish(known);
    if (s.heat == 0 && s.water == 0 && s.dye == 0 && s.fuel == 0 && !(s.rate > 0))
        words.refuse("it gives nothing: expected heat, water, dye, fuel, or velocity or temperature with a rate");
    return s;
}

}  // namespace

std::vector<sim::FieldSource> sources_of(App& app, const Options& o, const sim::Lattice& l)
{
    const Place box{l.n[0] * l.h[0], l.n[1] * l.h[1], o.up, 1};
    std::vector<sim::FieldSource> list;
    for (const std::string& text : o.sources) list.push_back(source_of(app, text, box));
    return list;
}

std::vector<std::shared_ptr<const sim::Shape>> colliders_of(App& app, const Options& o, const sim::Lattice& l)
{
    const Place box{l.n[0] * l.h[0], l.n[1] * l.h[1], o.up, 1};
    std::vector<std::shared_ptr<const sim::Shape>> list;
    for (const std::string& text : o.colliders) {
        OptionWords words("--collider", text);
        std::vector<std::string> known;
        list.push_back(shape_of(app, words, known, box, 0));
        if (!list.back()->body()) words.refuse("a fog volume has no surface: expected a level set");
        words.finish(known);
    }
    return list;
}

}  // namespace vdbcloud::app
