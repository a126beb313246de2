#include "vdbcloud/solve/graph_level.h"

#include "vdbcloud/solve/parallel.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <unordered_map>

namespace vdbcloud {

namespace {

// A link counts as strong if it is at least this part of the strongest link of EITHER end: across a jump nothing is joined.
constexpr float strong = 0.1f;
// The coarse operator must not be softer than what interpolation makes of the fine one (Galerkin), or the corrections of
// many levels overshoot and the cycle is no longer positive definite: a link keeps this share of itself, all of it.
constexpr double least_share = 1.0;

double series(double a, double b) { return a > 0 && b > 0 ? a * b / (a + b) : 0.0; }

/// Union-find without ranks; roots are the lowest members, so that the result does not depend on order.
int32_t root(std::vector<int32_t>& up, int32_t i)
{
    while (up[i] != i) i = up[i] = up[up[i]];
    return i;
}

void join(std::vector<int32_t>& up, int32_t i, int32_t j)
{
    i = root(up, i);
    j = root(up, j);
    if (i != j) up[std::max(i, j)] = std::min(i, j);
}

/// The axis along which two places differ; 3 if none.
int axis_between(const Vec3i& p, const Vec3i& q)
{
    return p.x() != q.x() ? 0 : p.y() != q.y() ? 1 : p.z() != q.z() ? 2 : 3;
}

Vec3i halved(const Vec3i& p) { return Vec3i(p.x() >> 1, p.y() >> 1, p.z() >> 1); }

/// The level made of `count` groups. links(f) calls f(i, j, c, axis) once for each link, in a fixed order.
template<typename Links, typename Place>
GraphLevel grouped(const std::vector<int32_t>& parent, size_t count, const std::vector<float>& extra,
                   const std::vector<float>& boundary, const Links& links, const Place& place)
{
    GraphLevel level;
    level.place.resize(count);
    level.extra.assign(count, 0.0f);
    level.boundary.assign(count, 0.0f);
    // Conductance of each unknown to others of its group, by axis: none where the group does not extend along it.
    std::vector<float> inner[3];
    for (auto& along : inner) along.assign(parent.size(), 0.0f);
    std::vector<uint32_t> degree(count + 1, 0);
    links([&](int32_t i, int32_t j, float c, int axis) {
        if (parent[i] == parent[j]) {
            if (axis < 3)
                for (int32_t k : {i, j}) inner[axis][k] = std::max(inner[axis][k], c);
            return;
        }
        ++degree[parent[i] + 1];
        ++degree[parent[j] + 1];
    });
    for (size_t i = 0; i < parent.size(); ++i) {
        if (parent[i] < 0) continue;
        level.place[parent[i]] = halved(place(int32_t(i)));
        const double outside = boundary[i];
        double seen = outside;  // half of the mean conductance to its partners in the group stands before it
        const int extent = (inner[0][i] > 0) + (inner[1][i] > 0) + (inner[2][i] > 0);
        if (extent && outside > 0) seen = series(outside, 2.0 * (inner[0][i] + inner[1][i] + inner[2][i]) / extent);
        level.boundary[parent[i]] += float(seen);
        level.extra[parent[i]] += float(seen + (extra[i] - outside));
    }
    std::partial_sum(degree.begin(), degree.end(), degree.begin());
    std::vector<int32_t> to(degree.back());
    std::vector<float> c_of(degree.back());
    std::vector<uint32_t> at(degree.begin(), degree.end() - 1);
    links([&](int32_t i, int32_t j, float c, int axis) {
        const int32_t a = parent[i], b = parent[j];
        if (a == b) return;
        if (axis < 3) {
            double path = c;
            for (int32_t k : {i, j})
                if (inner[axis][k] > 0) path = series(path, 2.0 * inner[axis][k]);
            c = float(std::max(path, least_share * c));
        }
        to[at[a]] = b;
        c_of[at[a]++] = c;
        to[at[b]] = a;
        c_of[at[b]++] = c;
    });
    // Links of one pair are added up, row by row.
    level.begin.assign(1, 0);
    std::vector<std::pair<int32_t, float>> row;
    for (size_t a = 0; a < count; ++a) {
        row.clear();
        for (uint32_t k = degree[a]; k < degree[a + 1]; ++k) {
            const auto same = std::find_if(row.begin(), row.end(), [&](const auto& e) { return e.first == to[k]; });
            if (same == row.end()) row.emplace_back(to[k], c_of[k]);
            else same->second += c_of[k];
        }
        std::sort(row.begin(), row.end());
        for (const auto& [column, c] : row) {
            level.column.push_back(column);
            level.c.push_back(c);
        }
        level.begin.push_back(uint32_t(level.column.size()));
    }
    level.inverse.resize(count);
    for (size_t a = 0; a < count; ++a) {
        double diagonal = level.extra[a];
        for (uint32_t k = level.begin[a]; k < level.begin[a + 1]; ++k) diagonal += level.c[k];
        level.inverse[a] = diagonal > 0 ? float(1 / diagonal) : 0.0f;
    }
    for (auto* v : {&level.b, &level.x, &level.other}) v->assign(count, 0.0f);
    return level;
}

/// Numbers the roots of a union-find, leaving -1 where up is -1.
size_t number_groups(std::vector<int32_t>& up, std::vector<int32_t>& parent)
{
    parent.assign(up.size(), -1);
    int32_t count = 0;
    for (size_t i = 0; i < up.size(); ++i) {
        if (up[i] < 0) continue;
        const int32_t r = root(up, int32_t(i));
        parent[i] = size_t(r) == i ? count++ : parent[r];
    }
    return size_t(count);
}

}  // namespace

size_t GraphLevel::bytes() const
{
    return 4 * (begin.size() + column.size() + c.size() + extra.size() + inverse.size() + parent.size() + b.size() + x.size() +
                other.size());
}

void GraphLevel::residual()
{
    for_ranges((size() + 511) / 512, [&](size_t first, size_t last) {
        for (size_t i = first * 512; i < std::min(size(), last * 512); ++i) {
            float sum = extra[i] * x[i];
            for (uint32_t k = begin[i]; k < begin[i + 1]; ++k) sum += c[k] * (x[i] - x[column[k]]);
            other[i] = b[i] - sum;
        }
    });
}

void GraphLevel::smooth(bool zero_guess)
{
    constexpr float first_step = 2.0f / 3, keep = 0.2f, second_step = 1.2f;
    const auto rows = [&](const auto& f) {
        for_ranges((size() + 511) / 512, [&](size_t first, size_t last) {
            for (size_t i = first * 512; i < std::min(size(), last * 512); ++i) f(i);
        });
    };
    const auto product = [&](const std::vector<float>& v, size_t i) {
        float sum = extra[i] * v[i];
        for (uint32_t k = begin[i]; k < begin[i + 1]; ++k) sum += c[k] * (v[i] - v[column[k]]);
        return sum;
    };
    if (zero_guess) {
        rows([&](size_t i) {
            other[i] = first_step * inverse[i] * b[i];
            x[i] = 0;
        });
    } else
        rows([&](size_t i) { other[i] = x[i] + first_step * inverse[i] * (b[i] - product(x, i)); });
    rows([&](size_t i) { x[i] = other[i] + keep * (other[i] - x[i]) + second_step * inverse[i] * (b[i] - product(other, i)); });
}

GraphLevel coarse_level(const Stencil& fine, const std::vector<float>& boundary, std::vector<int32_t>& parent)
{
    static constexpr int stride[3] = {64, 8, 1};
    const Blocks& blocks = *fine.blocks;
    const size_t slots = blocks.count() * 512;
    const auto strongest = [&](size_t slot) {
        float most = 0;
        for (int a = 0; a < 3; ++a)
            most = std::max({most, fine.face[a][slot], fine.face[a][blocks.neighbour(slot, 2 * a)]});
        return most;
    };
    std::vector<int32_t> up(slots, -1);
    for_ranges(blocks.count(), [&](size_t first, size_t last) {
        for (size_t b = first; b < last; ++b) {
            float most[512];
            for (size_t i = 0; i < 512; ++i) {
                const bool active = blocks.active(b * 512 + i);
                if (active) up[b * 512 + i] = int32_t(b * 512 + i);
                most[i] = active ? strongest(b * 512 + i) : 0;
            }
            for (size_t i = 0; i < 512; ++i)
                for (int a = 0; a < 3; ++a) {
                    if (i / stride[a] % 2) continue;  // the pair's lower voxel
                    const float c = fine.face[a][b * 512 + i];
                    if (c > 0 && c >= strong * std::max(most[i], most[i + stride[a]]))
                        join(up, int32_t(b * 512 + i), int32_t(b * 512 + i + stride[a]));
                }
        }
    });
    const size_t count = number_groups(up, parent);
    up = {};
    return grouped(parent, count, fine.extra, boundary, [&](const auto& f) {
        for (size_t slot = 0; slot < slots; ++slot)
            for (int a = 0; a < 3; ++a)
                if (const float c = fine.face[a][slot]; c > 0) f(int32_t(slot), int32_t(blocks.neighbour(slot, 2 * a + 1)), c, a);
    }, [&](int32_t slot) { return blocks.voxel(size_t(slot)); });
}

GraphLevel coarse_level(GraphLevel& fine)
{
    const size_t n = fine.size();
    std::vector<float> most(n, 0.0f);
    for (size_t i = 0; i < n; ++i)
        for (uint32_t k = fine.begin[i]; k < fine.begin[i + 1]; ++k) most[i] = std::max(most[i], fine.c[k]);
    std::vector<int32_t> up(n);
    std::iota(up.begin(), up.end(), 0);
    for (size_t i = 0; i < n; ++i)
        for (uint32_t k = fine.begin[i]; k < fine.begin[i + 1]; ++k) {
            const int32_t j = fine.column[k];
            if (size_t(j) > i && halved(fine.place[i]) == halved(fine.place[j]) && fine.c[k] >= strong * std::max(most[i], most[j]))
                join(up, int32_t(i), j);
        }
    const size_t count = number_groups(up, fine.parent);
    GraphLevel level = grouped(fine.parent, count, fine.extra, fine.boundary, [&](const auto& f) {
        for (size_t i = 0; i < n; ++i)
            for (uint32_t k = fine.begin[i]; k < fine.begin[i + 1]; ++k)
                if (size_t(fine.column[k]) > i) f(int32_t(i), fine.column[k], fine.c[k], axis_between(fine.place[i], fine.place[fine.column[k]]));
    }, [&](int32_t i) { return fine.place[i]; });
    fine.place = {};
    fine.boundary = {};
    return level;
}

}  // namespace vdbcloud
