#include "vdbcloud/optics/solid_rays.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/optics/cell_march.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

constexpr double far = std::numeric_limits<double>::infinity();

/// How far off a surface of closed form a point is moved, relative to the lengths that its place was computed from.
constexpr double rounding = 1e-11;
/// The same for a level set [voxels].
constexpr double skin = 1e-4;

/// Where a cubic rises from below 0 to 0 or above for the first time within [0, 1]; nothing where it does not.
std::optional<double> first_rise(const Cubic& f)
{
    if (f.c0 >= 0) return 0.0;
    // Between its extremes a cubic is monotonic.
    double cut[4] = {0, 1, 1, 1};
    int cuts = 1;
    const double a = 3 * f.c3, b = 2 * f.c2, c = f.c1, square = b * b - 4 * a * c;
    if (square > 0) {
        const double q = -(b + std::copysign(std::sqrt(square), b)) / 2;
        double s[2] = {a != 0 ? q / a : 2.0, q != 0 ? c / q : 2.0};
        if (s[0] > s[1]) std::swap(s[0], s[1]);
        for (const double x : s)
            if (x > 0 && x < 1) cut[cuts++] = x;
    }
    cut[cuts] = 1;
    for (int n = 0; n < cuts; ++n) {
        double low = cut[n], high = cut[n + 1];
        if (!(f.at(high) >= 0)) continue;
        // Newton's method, kept between the bounds by bisection.
        double s = (low + high) / 2;
        for (int k = 0; k < 60 && high - low > 1e-15; ++k) {
            const double value = f.at(s), slope = f.c1 + s * (2 * f.c2 + s * 3 * f.c3);
            (value < 0 ? low : high) = s;
            const double next = s - value / slope;
            const double moved = next > low && next < high ? next : (low + high) / 2;
            if (std::abs(moved - s) < 1e-16) break;
            s = moved;
        }
        return s;
    }
    return std::nullopt;
}

/// A level set whose inside is active and above `level_`: the band's width less the distance.
BrickMap depth_map(const FloatGrid& distance)
{
    auto filled = distance.deepCopy();
    for (auto v = filled->beginValueOff(); v; ++v)
        if (*v < 0) v.setActiveState(true);
    const float band = distance.background();
    return BrickMap(*filled, 0, [band](float d) { return std::clamp(band - d, 0.0f, 2 * band); });
}

Vec3d transposed(const Affine& map, const Vec3d& v) { return v[0] * map.a[0] + v[1] * map.a[1] + v[2] * map.a[2]; }

}  // namespace

struct SolidRays::Shape {
    virtual ~Shape() = default;
    virtual bool inside(const Vec3d&) const = 0;
    /// The first t in [0, t1) on the surface or within; nothing without one.
    virtual std::optional<double> meet(const WorldRay&, double t1) const = 0;
    /// Normal at a point of the surface, and how far to move along it to be in the open.
    virtual Vec3d normal(const Vec3d&) const = 0;
    virtual Vec3d moved_out(const Vec3d& x, const Vec3d& normal) const = 0;
};

namespace {

double size_of(const Vec3d& v) { return std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])}); }

class PlaneShape : public SolidRays::Shape {
public:
    explicit PlaneShape(const Solid& s) : point_(s.place), up_(s.extent) {}
    bool inside(const Vec3d& x) const override { return (x - point_).dot(up_) <= 0; }
    std::optional<double> meet(const WorldRay& ray, double t1) const override
    {
        const double height = (ray.origin - point_).dot(up_), fall = -ray.direction.dot(up_);
        if (height <= 0) return 0.0;
        if (!(fall > 0) || !(height < t1 * fall)) return std::nullopt;
        return height / fall;
    }
    Vec3d normal(const Vec3d&) const override { return up_; }
    Vec3d moved_out(const Vec3d& x, const Vec3d& n) const override
    {
        const double length = std::max(size_of(x), size_of(point_));
        return x + (std::max(rounding * length, 1e-300) - std::min(0.0, (x - point_).dot(up_))) * n;
    }

private:
    Vec3d point_, up_;
};

class BallShape : public SolidRays::Shape {
public:
    explicit BallShape(const Solid& s) : middle_(s.place), radius_(s.extent[0]) {}
    bool inside(const Vec3d& x) const override { return (x - middle_).length() <= radius_; }
    std::optional<double> meet(const WorldRay& ray, double t1) const override
    {
        const Vec3d to = middle_ - ray.origin;
        if (to.length() <= radius_) return 0.0;
        const double along = to.dot(ray.direction);
        // From the nearest point of the ray, so that a far ball loses no digits.
        const double off = (to - along * ray.direction).length();
        if (!(along > 0) || !(off < radius_)) return std::nullopt;
        const double t = std::max(0.0, along - std::sqrt((radius_ - off) * (radius_ + off)));
        return t < t1 ? std::optional(t) : std::nullopt;
    }
    Vec3d normal(const Vec3d& x) const override
    {
        const Vec3d n = x - middle_;
        return n.length() > 0 ? n.unit() : Vec3d(0, 1, 0);
    }
    Vec3d moved_out(const Vec3d& x, const Vec3d& n) const override
    {
        const double length = std::max({size_of(x), size_of(middle_), radius_});
        const double deep = radius_ - (x - middle_).length();
        return x + (rounding * length + std::max(0.0, deep)) * n;
    }

private:
    Vec3d middle_;
    double radius_;
};

class BoxShape : public SolidRays::Shape {
public:
    explicit BoxShape(const Solid& s) : low_(s.place), high_(s.extent) {}
    bool inside(const Vec3d& x) const override
    {
        for (int a = 0; a < 3; ++a)
            if (!(x[a] >= low_[a] && x[a] <= high_[a])) return false;
        return true;
    }
    std::optional<double> meet(const WorldRay& ray, double t1) const override
    {
        if (inside(ray.origin)) return 0.0;
        double in = 0, out = t1;
        if (!clip(IndexRay(Affine(), ray), low_, high_, in, out)) return std::nullopt;
        return in;
    }
    Vec3d normal(const Vec3d& x) const override
    {
        // Of the face that the point is nearest to, relative to the box.
        Vec3d n(0.0);
        double nearest = far;
        for (int a = 0; a < 3; ++a)
            for (int side = 0; side < 2; ++side) {
                const double from = std::abs(x[a] - (side ? high_ : low_)[a]);
                if (from >= nearest) continue;
                nearest = from;
                n = Vec3d(0.0);
                n[a] = side ? 1 : -1;
            }
        return n;
    }
    Vec3d moved_out(const Vec3d& x, const Vec3d& n) const override
    {
        const double length = std::max({size_of(x), size_of(low_), size_of(high_)});
        Vec3d out = x;
        for (int a = 0; a < 3; ++a)
            if (n[a] != 0) out[a] = (n[a] > 0 ? high_ : low_)[a] + n[a] * rounding * length;
        return out;
    }

private:
    Vec3d low_, high_;
};

class LevelSetShape : public SolidRays::Shape {
public:
    explicit LevelSetShape(const Solid& s) : map_(depth_map(*s.level_set)), level_(double(s.level_set->background()))
    {
        edge_ = far;
        for (int a = 0; a < 3; ++a)
            edge_ = std::min(edge_, map_.world_from_index().vector(Vec3d(a == 0, a == 1, a == 2)).length());
    }
    bool inside(const Vec3d& x) const override { return value(x) >= level_; }
    std::optional<double> meet(const WorldRay& world, double t1) const override
    {
        const IndexRay ray(map_.index_from_world(), world);
        std::optional<double> found;
        march_pieces(map_, ray, 0, t1, [&](double t_in, double t_out, const float* corners, const Vec3i& cell) {
            constexpr int sx = BrickMap::sx, sy = BrickMap::sy;
            const float most = std::max({corners[0], corners[1], corners[sy], corners[sy + 1], corners[sx],
                                         corners[sx + 1], corners[sx + sy], corners[sx + sy + 1]});
            if (double(most) < level_) return true;
            Cubic f = along(corners, ray.at(t_in) - Vec3d(cell[0], cell[1], cell[2]), (t_out - t_in) * ray.direction);
            f.c0 -= level_;
            const auto s = first_rise(f);
            if (!s) return true;
            found = t_in + *s * (t_out - t_in);
            return false;
        });
        return found && *found < t1 ? found : std::nullopt;
    }
    Vec3d normal(const Vec3d& x) const override
    {
        const Vec3d p = map_.index_from_world().point(x);
        Vec3d g;
        for (int a = 0; a < 3; ++a) {
            Vec3d low = p, high = p;
            low[a] -= 1;
            high[a] += 1;
            g[a] = map_.sample(low) - map_.sample(high);
        }
        const Vec3d n = transposed(map_.index_from_world(), g);
        return n.length() > 0 ? n.unit() : Vec3d(0, 1, 0);
    }
    Vec3d moved_out(const Vec3d& x, const Vec3d& n) const override
    {
        Vec3d out = x;
        for (double step = skin; step < 2; step *= 2) {
            out = x + step * edge_ * n;
            if (value(out) < level_) break;
        }
        return out;
    }

private:
    double value(const Vec3d& x) const { return map_.sample(map_.index_from_world().point(x)); }

    BrickMap map_;
    double level_, edge_;
};

}  // namespace

SolidRays::SolidRays(const std::vector<Solid>& solids) : solids_(solids)
{
    for (const Solid& s : solids_) {
        check(s);
        switch (s.kind) {
        case SolidKind::Plane: shapes_.push_back(std::make_unique<PlaneShape>(s)); break;
        case SolidKind::Sphere: shapes_.push_back(std::make_unique<BallShape>(s)); break;
        case SolidKind::Box: shapes_.push_back(std::make_unique<BoxShape>(s)); break;
        case SolidKind::LevelSet: shapes_.push_back(std::make_unique<LevelSetShape>(s)); break;
        }
    }
}

SolidRays::~SolidRays() = default;
SolidRays::SolidRays(SolidRays&&) noexcept = default;

std::optional<SolidHit> SolidRays::nearest(const WorldRay& ray, double t1) const
{
    std::optional<size_t> found;
    for (size_t n = 0; n < shapes_.size(); ++n)
        if (const auto t = shapes_[n]->meet(ray, t1)) {
            t1 = *t;
            found = n;
        }
    if (!found) return std::nullopt;
    const Shape& shape = *shapes_[*found];
    const Vec3d x = ray.at(t1);
    Vec3d n = shape.normal(x);
    // A smooth normal may lean away from a ray that grazes the cells' surface.
    if (const double away = n.dot(ray.direction); away > -1e-6) n = (n - (away + 1e-6) * ray.direction).unit();
    return SolidHit{t1, n, shape.moved_out(x, n), *found};
}

bool SolidRays::blocked(const WorldRay& ray, double t1) const
{
    return std::any_of(shapes_.begin(), shapes_.end(), [&](const auto& shape) { return bool(shape->meet(ray, t1)); });
}

bool SolidRays::inside(const Vec3d& x) const
{
    return std::any_of(shapes_.begin(), shapes_.end(), [&](const auto& shape) { return shape->inside(x); });
}

}  // namespace vdbcloud
