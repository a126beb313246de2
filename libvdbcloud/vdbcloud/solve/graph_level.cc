#include "vdbcloud/solve/graph_level.h"

#include "vdbcloud/core/eight.h"
#include "vdbcloud/solve/aggregation.h"
#include "vdbcloud/solve/chebyshev.h"
#include "vdbcloud/solve/parallel.h"

#include <algorithm>

namespace vdbcloud {

using namespace eight;
using namespace chebyshev;

namespace {

/// Bare pointers of the rows.
struct Rows {
    explicit Rows(const GraphRows& of)
        : begin(of.links->begin.data()), column(of.links->column.data()), c(of.links->c.data()), extra(of.extra.data()),
          inverse(of.inverse.data())
    {
    }
    const uint32_t* begin;
    const int32_t* column;
    const float *c, *extra, *inverse;
};

/// A v of batch k.
VDBCLOUD_INLINE Floats product(const Rows& a, size_t k, const float* v)
{
    const Floats own = load(v + 8 * k);
    Floats sum = load(a.extra + 8 * k) * own;
    for (size_t link = 8 * size_t(a.begin[k]); link < 8 * size_t(a.begin[k + 1]); link += 8) {
        const int32_t* to = a.column + link;
        const Floats there{v[to[0]], v[to[1]], v[to[2]], v[to[3]], v[to[4]], v[to[5]], v[to[6]], v[to[7]]};
        sum += load(a.c + link) * (own - there);
    }
    return sum;
}

/// The first smoothing step from x to y, of batches first .. last - 1.
VDBCLOUD_CLONES void smooth_first(const Rows& a, size_t first, size_t last, const float* b, const float* x, float* y)
{
    for (size_t k = first; k < last; ++k)
        store(y + 8 * k,
              load(x + 8 * k) + all(first_step) * load(a.inverse + 8 * k) * (load(b + 8 * k) - product(a, k, x)));
}

/// The second step: x1 is the result of the first step, x its start and then the end.
VDBCLOUD_CLONES void smooth_second(const Rows& a, size_t first, size_t last, const float* b, const float* x1, float* x)
{
    for (size_t k = first; k < last; ++k) {
        const Floats v = load(x1 + 8 * k), step = load(a.inverse + 8 * k) * (load(b + 8 * k) - product(a, k, x1));
        store(x + 8 * k, v + all(keep) * (v - load(x + 8 * k)) + all(second_step) * step);
    }
}

VDBCLOUD_CLONES void apply_rows(const Rows& a, size_t first, size_t last, const float* x, const float* b,
                                const float* image, float* ax, double* sums)
{
    Doubles x_ax{}, x_b{}, b_b{}, x_image{};
    for (size_t k = first; k < last; ++k) {
        const Floats to = product(a, k, x);
        const Doubles xs = as<double>(load(x + 8 * k)), bs = as<double>(load(b + 8 * k));
        x_ax += xs * as<double>(to);
        x_b += xs * bs;
        b_b += bs * bs;
        x_image += xs * as<double>(load(image + 8 * k));
        store(ax + 8 * k, to);
    }
    sums[0] = sum(x_ax);
    sums[1] = sum(x_b);
    sums[2] = sum(b_b);
    sums[3] = sum(x_image);
}

VDBCLOUD_CLONES double advance_rows(size_t first, size_t last, float step, const float* image, float* b)
{
    Doubles b_b{};
    for (size_t k = first; k < last; ++k) {
        const Floats left = load(b + 8 * k) - all(step) * load(image + 8 * k);
        store(b + 8 * k, left);
        b_b += as<double>(left) * as<double>(left);
    }
    return sum(b_b);
}

}  // namespace

GraphRows::GraphRows(const Graph& graph) : extra(graph.extra)
{
    const size_t count = (graph.size() + 7) / 8;
    const auto links_of = [&](size_t i) { return i < graph.size() ? graph.begin[i + 1] - graph.begin[i] : 0u; };
    Links own;
    for (size_t k = 0; k < count; ++k) {
        uint32_t most = 0;
        for (size_t i = 8 * k; i < 8 * k + 8; ++i) most = std::max(most, links_of(i));
        own.begin.push_back(own.begin.back() + most);
    }
    own.column.resize(8 * size_t(own.begin.back()));
    own.c.assign(own.column.size(), 0.0f);
    extra.resize(8 * count, 0.0f);
    inverse.assign(8 * count, 0.0f);
    for_ranges(count, [&](size_t from, size_t to) {
        for (size_t i = 8 * from; i < 8 * to; ++i) {
            const uint32_t some = links_of(i);
            for (uint32_t k = 0; k < own.begin[i / 8 + 1] - own.begin[i / 8]; ++k) {
                const size_t at = 8 * size_t(own.begin[i / 8] + k) + i % 8;
                own.column[at] = k < some ? graph.column[graph.begin[i] + k] : int32_t(i);
                if (k < some) own.c[at] = graph.c[graph.begin[i] + k];
            }
            const double diagonal = i < graph.size() ? graph.linked(i) + graph.extra[i] : 0.0;
            if (diagonal > 0) inverse[i] = float(1 / diagonal);
        }
    });
    links = std::make_shared<Links>(std::move(own));
}

GraphRows::GraphRows(const GraphRows& like, std::vector<float> own)
    : links(like.links), owns_links(false), extra(std::move(own)), inverse(like.inverse.size(), 0.0f)
{
    extra.resize(inverse.size(), 0.0f);
    for_ranges(batches(), [&](size_t from, size_t to) {
        for (size_t i = 8 * from; i < 8 * to; ++i) {
            double diagonal = extra[i];
            for (uint32_t k = links->begin[i / 8]; k < links->begin[i / 8 + 1]; ++k)
                diagonal += links->c[8 * size_t(k) + i % 8];
            if (diagonal > 0) inverse[i] = float(1 / diagonal);
        }
    });
}

GraphLevel::GraphLevel(const Graph& graph) : size_(graph.size()), rows_(graph)
{
    for (auto* v : {&b, &x, &other, &search, &image}) v->assign(8 * rows_.batches(), 0.0f);
}

GraphLevel::GraphLevel(const GraphLevel& like, std::vector<float> extra)
    : size_(like.size_), rows_(like.rows_, std::move(extra)), groups_(like.groups_)
{
    for (auto* v : {&b, &x, &other, &search, &image}) v->assign(8 * rows_.batches(), 0.0f);
}

std::vector<float> GraphLevel::next_extra(const GraphLevel& like, const GraphLevel& next) const
{
    std::vector<float> extra = next.rows_.extra;
    for_rows(next.size(), [&](size_t g) {
        double more = 0;
        for (uint32_t m = groups_->first[g]; m < groups_->first[g + 1]; ++m) {
            const size_t i = size_t(groups_->member[m]);
            more += double(rows_.extra[i]) - like.rows_.extra[i];
        }
        extra[g] = float(extra[g] + more);
    });
    return extra;
}

size_t GraphLevel::bytes() const
{
    const size_t groups = groups_->of.size() + groups_->first.size() + groups_->member.size();
    return rows_.bytes() + 4 * (5 * b.size() + (rows_.owns_links ? groups : 0));
}

Graph GraphLevel::make_groups(const Graph& graph)
{
    Groups groups;
    Graph coarse = grouped(graph, groups.of);
    list_members(groups.of, coarse.size(), groups.first, groups.member);
    groups_ = std::make_shared<Groups>(std::move(groups));
    return coarse;
}

void GraphLevel::drop_groups() { groups_ = std::make_shared<Groups>(); }

void GraphLevel::smooth()
{
    const Rows a(rows_);
    for_batches(rows_.batches(),
                [&](size_t first, size_t last) { smooth_first(a, first, last, b.data(), x.data(), other.data()); });
    for_batches(rows_.batches(),
                [&](size_t first, size_t last) { smooth_second(a, first, last, b.data(), other.data(), x.data()); });
}

void GraphLevel::descend(std::vector<float>& coarse_b) const
{
    const std::vector<uint32_t>& from = groups_->first;
    const int32_t* member = groups_->member.data();
    for_rows(from.size() - 1, [&](size_t g) {
        float sum = 0;
        for (uint32_t m = from[g]; m < from[g + 1]; ++m) sum += b[size_t(member[m])];
        coarse_b[g] = sum;
    });
}

void GraphLevel::ascend(const std::vector<float>& coarse_x)
{
    const int32_t* group = groups_->of.data();
    for_rows(size(), [&](size_t i) { x[i] = group[i] >= 0 ? coarse_x[size_t(group[i])] : 0.0f; });
    smooth();
}

void GraphLevel::smooth_alone()
{
    std::fill(x.begin(), x.end(), 0.0f);
    smooth();
    smooth();
}

GraphLevel::Products GraphLevel::apply(std::vector<float>& ax) const
{
    const Rows a(rows_);
    const auto sums = ordered_batch_sums<4>(rows_.batches(), [&](size_t first, size_t last, double* sum) {
        apply_rows(a, first, last, x.data(), b.data(), image.data(), ax.data(), sum);
    });
    return {sums[0], sums[1], sums[2], sums[3]};
}

double GraphLevel::advance(float step)
{
    return ordered_batch_sums<1>(rows_.batches(), [&](size_t first, size_t last, double* sum) {
        *sum = advance_rows(first, last, step, image.data(), b.data());
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
