#include "vdbcloud/solve/graph_level.h"

#include "vdbcloud/solve/aggregation.h"
#include "vdbcloud/solve/chebyshev.h"
#include "vdbcloud/solve/parallel.h"

#include <algorithm>

namespace vdbcloud {

namespace {

float product(const Graph& a, const float* v, size_t i)
{
    float sum = a.extra[i] * v[i];
    for (uint32_t k = a.begin[i]; k < a.begin[i + 1]; ++k) sum += a.c[k] * (v[i] - v[a.column[k]]);
    return sum;
}

}  // namespace

GraphLevel::GraphLevel(Graph graph) : a(std::move(graph)), inverse(a.size())
{
    for_rows(a.size(), [&](size_t i) {
        const double diagonal = a.linked(i) + a.extra[i];
        inverse[i] = diagonal > 0 ? float(1 / diagonal) : 0.0f;
    });
    for (auto* v : {&b, &x, &other, &search, &image}) v->assign(a.size(), 0.0f);
}

size_t GraphLevel::bytes() const
{
    return a.bytes() + 4 * (6 * size() + group_.size() + first_.size() + member_.size());
}

Graph GraphLevel::make_groups()
{
    Graph coarse = grouped(a, group_);
    list_members(group_, coarse.size(), first_, member_);
    return coarse;
}

void GraphLevel::drop_groups()
{
    group_ = {};
    first_ = {};
    member_ = {};
}

void GraphLevel::smooth_from_zero()
{
    using namespace chebyshev;
    for_rows(size(), [&](size_t i) { other[i] = first_step * inverse[i] * b[i]; });
    for_rows(size(), [&](size_t i) {
        x[i] = (1 + keep) * other[i] + second_step * inverse[i] * (b[i] - product(a, other.data(), i));
    });
}

void GraphLevel::smooth()
{
    using namespace chebyshev;
    for_rows(size(), [&](size_t i) { other[i] = x[i] + first_step * inverse[i] * (b[i] - product(a, x.data(), i)); });
    for_rows(size(), [&](size_t i) {
        x[i] = other[i] + keep * (other[i] - x[i]) + second_step * inverse[i] * (b[i] - product(a, other.data(), i));
    });
}

void GraphLevel::descend(std::vector<float>& coarse_b)
{
    smooth_from_zero();
    for_rows(size(), [&](size_t i) { other[i] = b[i] - product(a, x.data(), i); });
    for_rows(coarse_b.size(), [&](size_t g) {
        float sum = 0;
        for (uint32_t m = first_[g]; m < first_[g + 1]; ++m) sum += other[size_t(member_[m])];
        coarse_b[g] = sum;
    });
}

void GraphLevel::ascend(const std::vector<float>& coarse_x)
{
    for_rows(size(), [&](size_t i) {
        if (group_[i] >= 0) x[i] += coarse_x[size_t(group_[i])];
    });
    smooth();
}

void GraphLevel::smooth_alone()
{
    smooth_from_zero();
    smooth();
}

GraphLevel::Products GraphLevel::apply(std::vector<float>& ax) const
{
    const auto sums = ordered_row_sums<3>(size(), [&](size_t i, double* sum) {
        ax[i] = product(a, x.data(), i);
        sum[0] += double(x[i]) * ax[i];
        sum[1] += double(x[i]) * b[i];
        sum[2] += double(b[i]) * b[i];
    });
    return {sums[0], sums[1], sums[2]};
}

double GraphLevel::x_image() const
{
    return ordered_row_sums<1>(size(), [&](size_t i, double* sum) { sum[0] += double(x[i]) * image[i]; })[0];
}

double GraphLevel::advance(float step)
{
    return ordered_row_sums<1>(size(), [&](size_t i, double* sum) {
        b[i] -= step * image[i];
        sum[0] += double(b[i]) * b[i];
    })[0];
}

void GraphLevel::scale(float s, float t)
{
    if (t == 0)
        for_rows(size(), [&](size_t i) { x[i] = s * search[i]; });
    else
        for_rows(size(), [&](size_t i) { x[i] = s * search[i] + t * x[i]; });
}

}  // namespace vdbcloud
