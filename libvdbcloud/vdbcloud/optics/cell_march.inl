// Included by cell_march.h inside namespace vdbcloud.

namespace march_detail {

/// Exit of a ray from the block of 2^shift cells that holds `cell`: distance, and the axis of the exit face.
inline double exit_of(const IndexRay& ray, const Vec3i& cell, int shift, int& axis)
{
    double t = std::numeric_limits<double>::infinity();
    axis = 0;
    for (int a = 0; a < 3; ++a) {
        if (ray.direction[a] == 0) continue;
        const int64_t low = cell[a] & -(int64_t(1) << shift);
        const double edge = double(ray.direction[a] > 0 ? low + (int64_t(1) << shift) : low);
        const double at = (edge - ray.origin[a]) * ray.inverse[a];
        if (at < t) {
            t = at;
            axis = a;
        }
    }
    return t;
}

/// Moves `cell` to the first cell beyond its block, through `axis`, at distance t.
inline void leave(const IndexRay& ray, Vec3i& cell, int shift, int axis, double t)
{
    for (int a = 0; a < 3; ++a) {
        const int size = 1 << shift, low = cell[a] & -size;
        if (a == axis) {
            cell[a] = ray.direction[a] > 0 ? low + size : low - 1;
        } else {
            // From `low` on, where a conversion cuts as std::floor() does, which is a call on old processors.
            const double place = ray.origin[a] + t * ray.direction[a] - low;
            cell[a] = low + int(std::clamp(place, 0.0, size - 0.5));
        }
    }
}

/// Visits the cells of one brick. On return t is the exit distance and `cell` lies outside the brick, or t is t1.
template<typename Visit>
bool march_brick(const float* brick, const IndexRay& ray, Vec3i& cell, double& t, double t1, Visit& visit)
{
    constexpr double far = std::numeric_limits<double>::infinity();
    const Vec3i home(cell[0] >> 3, cell[1] >> 3, cell[2] >> 3);
    int forward[3], step[3];
    double next[3];
    for (int a = 0; a < 3; ++a) {
        forward[a] = ray.direction[a] > 0;
        step[a] = forward[a] ? 1 : -1;
        next[a] = ray.direction[a] == 0 ? far : (double(cell[a] + forward[a]) - ray.origin[a]) * ray.inverse[a];
    }
    constexpr int sx = BrickMap::sx, sy = BrickMap::sy;
    for (;;) {
        const int a = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
        const double t_out = std::min(next[a], t1);
        if (t_out > t) {
            const float* c = brick + (cell[0] & 7) * sx + (cell[1] & 7) * sy + (cell[2] & 7);
            const bool any = c[0] != 0 || c[1] != 0 || c[sy] != 0 || c[sy + 1] != 0 || c[sx] != 0 || c[sx + 1] != 0 ||
                             c[sx + sy] != 0 || c[sx + sy + 1] != 0;
            if (any && !visit(t, t_out, c, cell)) return false;
            t = t_out;
        }
        if (t >= t1) return true;
        cell[a] += step[a];
        if ((cell[a] >> 3) != home[a]) return true;
        next[a] = (double(cell[a] + forward[a]) - ray.origin[a]) * ray.inverse[a];
    }
}

/// Calls on_brick(number, cell, t) for each brick on the ray; on_brick moves t and `cell` beyond the brick, or t to t1,
/// and returns false to stop. Calls on_gap() for each box of emptiness in between.
template<typename OnBrick, typename OnGap>
bool march_root(const BrickMap& map, const BrickMap::Root& root, const IndexRay& ray, double t, double t1,
                OnBrick& on_brick, OnGap& on_gap)
{
    Vec3i cell;
    for (int a = 0; a < 3; ++a)
        cell[a] = int(
            std::clamp(std::floor(ray.origin[a] + t * ray.direction[a]), double(root.first[a]), double(root.last[a])));
    while (t < t1) {
        for (int a = 0; a < 3; ++a)
            if (cell[a] < root.first[a] || cell[a] > root.last[a]) return true;
        const int32_t s = BrickMap::super_at(root, cell);
        const int32_t number = s < 0 ? -1 : map.number_at(s, cell);
        if (number >= 0) {
            if (!on_brick(number, cell, t)) return false;
            continue;
        }
        on_gap();
        const int shift = map.empty_shift(root, s, cell);
        int axis = 0;
        t = std::max(t, exit_of(ray, cell, shift, axis));
        if (t < t1) leave(ray, cell, shift, axis, t);
    }
    return true;
}

/// A root that a ray meets, from t0 to t1.
struct RootHit {
    double t0, t1;
    const BrickMap::Root* root;
};

/// The roots that a ray meets between t0 and t1: the first `few` in an array, all in a vector where there are more.
struct RootHits {
    static constexpr size_t few = 16;
    std::array<RootHit, few> first;
    std::vector<RootHit> more;
    size_t count = 0;
    size_t tested = 0;  ///< boxes

    RootHit* begin() { return count > few ? more.data() : first.data(); }
    void add(const RootHit& hit)
    {
        if (count < few)
            first[count] = hit;
        else {
            if (count == few) more.assign(first.begin(), first.end());
            more.push_back(hit);
        }
        ++count;
    }
};

/// Finds the roots on a ray, in the order of the tree of boxes.
inline void find_roots(const BrickMap& map, const IndexRay& ray, double t0, double t1, RootHits& hits)
{
    if (map.root_boxes().empty()) return;
    int32_t open[64] = {0};  // a tree of 2^32 roots is no deeper
    for (int left = 1; left > 0;) {
        const BrickMap::RootBox& box = map.root_boxes()[size_t(open[--left])];
        const Vec3d lo(box.first[0], box.first[1], box.first[2]);
        const Vec3d hi(box.last[0] + 1.0, box.last[1] + 1.0, box.last[2] + 1.0);
        RootHit hit{t0, t1, nullptr};
        ++hits.tested;
        if (!clip(ray, lo, hi, hit.t0, hit.t1)) continue;
        if (box.child[0] < 0) {
            hit.root = &map.roots()[size_t(~box.child[0])];
            hits.add(hit);
            continue;
        }
        open[left++] = box.child[0];
        open[left++] = box.child[1];
    }
}

template<typename OnBrick, typename OnGap>
bool march_roots(const BrickMap& map, const IndexRay& ray, double t0, double t1, OnBrick on_brick, OnGap on_gap)
{
    RootHits hits;
    find_roots(map, ray, t0, t1, hits);
    RootHit* hit = hits.begin();
    std::sort(hit, hit + hits.count, [](const RootHit& p, const RootHit& q) { return p.t0 < q.t0; });
    for (size_t n = 0; n < hits.count; ++n)
        if (!march_root(map, *hit[n].root, ray, hit[n].t0, hit[n].t1, on_brick, on_gap)) return false;
    return true;
}

template<typename OnBrick>
bool march_roots(const BrickMap& map, const IndexRay& ray, double t0, double t1, OnBrick on_brick)
{
    return march_roots(map, ray, t0, t1, on_brick, [] {});
}

/// Calls on_copy(ray, t_in, t_out, shift) for each copy of the map that the ray crosses, in order: the ray as the map
/// itself meets it, and the cells from there to the copy. Stops when on_copy returns false.
template<typename OnCopy>
bool march_copies(const BrickMap& map, const IndexRay& ray, double t, double t1, OnCopy on_copy)
{
    constexpr double infinity = std::numeric_limits<double>::infinity(), farthest = 1 << 30;
    if (!clip(ray, map, t, t1)) return true;
    const Vec3i &first = map.period().first, &length = map.period().length;
    Vec3d shift(0);  // whole periods; double, as a ray may enter far from the first copy
    for (int a = 0; a < 3; ++a)
        if (length[a] > 0)
            shift[a] = std::floor((ray.origin[a] + t * ray.direction[a] - first[a]) / length[a]) * length[a];
    for (;;) {
        int axis = 0;
        double next = infinity;
        for (int a = 0; a < 3; ++a) {
            if (length[a] == 0 || ray.direction[a] == 0) continue;
            const double plane = first[a] + shift[a] + (ray.direction[a] > 0 ? length[a] : 0);
            const double at = (plane - ray.origin[a]) * ray.inverse[a];
            if (at < next) {
                next = at;
                axis = a;
            }
        }
        const double t_out = std::min(next, t1);
        if (t_out > t) {
            for (int a = 0; a < 3; ++a)
                if (!(std::abs(shift[a]) < farthest)) return true;
            IndexRay here = ray;
            here.origin -= shift;
            if (!on_copy(here, t, t_out, Vec3i(int(shift[0]), int(shift[1]), int(shift[2])))) return false;
            t = t_out;
        }
        if (t >= t1) return true;
        shift[axis] += ray.direction[axis] > 0 ? length[axis] : -length[axis];
    }
}

/// Moves t and `cell` beyond the brick about `cell`, or t to t1 or beyond; true if the ray has a length in the brick,
/// which then ends at t_out.
inline bool cross_brick(const IndexRay& ray, Vec3i& cell, double& t, double t1, double& t_out)
{
    int axis = 0;
    const double exit = exit_of(ray, cell, 3, axis);
    t_out = std::min(exit, t1);
    const bool met = t_out > t;
    t = std::max(t, exit);
    if (t < t1) leave(ray, cell, 3, axis, t);
    return met;
}

/// As march_cells() through one copy of a map; `pieces`: as march_pieces().
template<bool pieces, typename Visit>
bool march_cells_once(const BrickMap& map, const IndexRay& ray, double t0, double t1, Visit& visit)
{
    return march_roots(map, ray, t0, t1, [&](int32_t number, Vec3i& cell, double& t) {
        const int32_t slot = map.slot(number);
        const float* corners = map.brick(slot);
        if (!map.constant(slot) || (!pieces && corners[0] != 0)) return march_brick(corners, ray, cell, t, t1, visit);
        const double t_in = t;
        const Vec3i entered = cell;
        double t_out = t;
        return !cross_brick(ray, cell, t, t1, t_out) || corners[0] == 0 || visit(t_in, t_out, corners, entered);
    });
}

template<typename Visit>
bool march_bricks_once(const BrickMap& map, const IndexRay& ray, double t0, double t1, Visit& visit)
{
    return march_roots(map, ray, t0, t1, [&](int32_t number, Vec3i& cell, double& t) {
        const double t_in = t;
        const Vec3i first(cell[0] & ~7, cell[1] & ~7, cell[2] & ~7);
        double t_out = t;
        return !cross_brick(ray, cell, t, t1, t_out) || visit(t_in, t_out, map.slot(number), first);
    });
}

/// Calls once(ray, t_in, t_out, visit) for each copy of the map on the ray.
template<typename Once, typename Visit>
bool in_each_copy(const BrickMap& map, const IndexRay& ray, double t0, double t1, const Once& once, Visit& visit)
{
    if (!map.repeats()) return once(ray, t0, t1, visit);
    return march_copies(map, ray, t0, t1, [&](const IndexRay& here, double in, double out, const Vec3i& shift) {
        auto shifted = [&](double t_in, double t_out, auto place, const Vec3i& cell) {
            return visit(t_in, t_out, place, cell + shift);
        };
        return once(here, in, out, shifted);
    });
}

}  // namespace march_detail

template<typename Visit>
bool march_cells(const BrickMap& map, const IndexRay& ray, double t0, double t1, Visit&& visit)
{
    const auto once = [&](const IndexRay& here, double in, double out, auto& in_copy) {
        return march_detail::march_cells_once<false>(map, here, in, out, in_copy);
    };
    return march_detail::in_each_copy(map, ray, t0, t1, once, visit);
}

template<typename Visit>
bool march_pieces(const BrickMap& map, const IndexRay& ray, double t0, double t1, Visit&& visit)
{
    const auto once = [&](const IndexRay& here, double in, double out, auto& in_copy) {
        return march_detail::march_cells_once<true>(map, here, in, out, in_copy);
    };
    return march_detail::in_each_copy(map, ray, t0, t1, once, visit);
}

template<typename Visit>
bool march_bricks(const BrickMap& map, const IndexRay& ray, double t0, double t1, Visit&& visit)
{
    const auto once = [&](const IndexRay& here, double in, double out, auto& in_copy) {
        return march_detail::march_bricks_once(map, here, in, out, in_copy);
    };
    return march_detail::in_each_copy(map, ray, t0, t1, once, visit);
}

inline size_t count_steps(const BrickMap& map, const IndexRay& ray, double t0, double t1)
{
    using namespace march_detail;
    size_t steps = 0;
    const auto cell = [&](auto...) { return ++steps, true; };
    const auto once = [&](const IndexRay& here, double in, double out, auto& visit) {
        const auto on_brick = [&](int32_t number, Vec3i& at, double& t) {
            const int32_t slot = map.slot(number);
            double t_out = t;
            if (!map.constant(slot)) return march_brick(map.brick(slot), here, at, t, out, visit);
            return ++steps, cross_brick(here, at, t, out, t_out), true;
        };
        return march_roots(map, here, in, out, on_brick, [&] { ++steps; });
    };
    in_each_copy(map, ray, t0, t1, once, cell);
    return steps;
}
