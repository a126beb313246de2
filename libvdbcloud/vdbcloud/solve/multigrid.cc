#include "vdbcloud/solve/multigrid.h"

#include "vdbcloud/solve/dense_factor.h"
#include "vdbcloud/solve/finest_level.h"
#include "vdbcloud/solve/graph_level.h"
#include "vdbcloud/solve/parallel.h"

#include <algorithm>
#include <optional>

namespace vdbcloud {

namespace {

constexpr size_t direct_size = 256;  // unknowns that the coarsest level may have
constexpr size_t most_levels = 24;
constexpr double enough = 0.15;  // reduction of a coarse residual after which the second step is omitted

}  // namespace

struct Multigrid::Levels {
    explicit Levels(const Stencil& fine) : finest(fine), voxels(fine.blocks->active_count())
    {
        Graph graph = collapsed(fine, finest.groups());
        graphs.emplace_back(graph);
        while (graph.size() > direct_size && graph.links() > 0 && graphs.size() < most_levels) {
            Graph next = graphs.back().make_groups(graph);
            if (next.size() == 0 || next.size() >= graph.size()) {
                graphs.back().drop_groups();
                break;
            }
            graph = std::move(next);
            graphs.emplace_back(graph);
        }
        if (graph.size() <= 4 * direct_size) {
            direct.emplace(graph);
            coarsest = std::move(graph);
        }
        graph = {};
        finest.make_fields();
    }

    Levels(const Stencil& fine, const Levels& like) : finest(fine, like.finest), voxels(like.voxels)
    {
        graphs.emplace_back(like.graphs[0], finest.next_extra(like.finest, like.graphs[0].extra()));
        for (size_t k = 1; k < like.graphs.size(); ++k)
            graphs.emplace_back(like.graphs[k], graphs[k - 1].next_extra(like.graphs[k - 1], like.graphs[k]));
        if (!like.direct) return;
        coarsest = like.coarsest;
        std::copy_n(graphs.back().extra().begin(), coarsest.size(), coarsest.extra.begin());
        direct.emplace(coarsest);
    }

    /// The correction of the next graph, by correct(), and smoothing: x approximates A^-1 b of graph `number`.
    void visit(size_t number)
    {
        GraphLevel& level = graphs[number];
        level.descend(graphs[number + 1].b);
        correct(number + 1);
        level.ascend(graphs[number + 1].x);
    }

    /// x approximates A^-1 b of graph `number`: one or two steps of flexible conjugate gradients. Overwrites b.
    void correct(size_t number)
    {
        GraphLevel& l = graphs[number];
        if (number + 1 == graphs.size()) {
            if (direct)
                direct->solve(l.b, l.x);
            else
                l.smooth_alone();
            return;
        }
        visit(number);
        const auto first = l.apply(l.image);
        if (!(first.x_ax > 0)) return;
        const double step = first.x_b / first.x_ax;
        const double remaining = l.advance(float(step));  // x is now the first direction, kept as `search`
        l.x.swap(l.search);
        if (remaining <= enough * enough * first.b_b) return l.scale(float(step), 0);
        visit(number);
        const auto second = l.apply(l.other);
        const double mixed = second.x_image, projected = second.x_ax - mixed * mixed / first.x_ax;
        if (!(projected > 0)) return l.scale(float(step), 0);
        l.scale(float(step - mixed * second.x_b / (first.x_ax * projected)), float(second.x_b / projected));
    }

    FinestLevel finest;
    size_t voxels;
    std::vector<GraphLevel> graphs;
    Graph coarsest;  // that of `direct`
    std::optional<DenseFactor> direct;
};

Multigrid::Multigrid(const Stencil& fine) : levels_(std::make_unique<Levels>(fine)) {}
Multigrid::Multigrid(const Stencil& fine, const Multigrid& like)
    : levels_(std::make_unique<Levels>(fine, *like.levels_))
{
}
Multigrid::~Multigrid() = default;
Multigrid::Multigrid(Multigrid&&) noexcept = default;

double Multigrid::cycle(const std::vector<double>& residual)
{
    levels_->finest.descend(residual, levels_->graphs[0].b);
    levels_->correct(0);
    return levels_->finest.ascend(residual, levels_->graphs[0].x);
}

const std::vector<float>& Multigrid::z() const { return levels_->finest.x(); }

std::vector<float>& Multigrid::scratch(int number) { return levels_->finest.field(number); }

std::vector<size_t> Multigrid::sizes() const
{
    std::vector<size_t> sizes{levels_->voxels};
    for (const GraphLevel& level : levels_->graphs) sizes.push_back(level.size());
    return sizes;
}

int Multigrid::levels() const { return int(levels_->graphs.size()) + 1; }

size_t Multigrid::bytes() const
{
    size_t total = levels_->finest.bytes();
    for (const GraphLevel& level : levels_->graphs) total += level.bytes();
    return total;
}

}  // namespace vdbcloud
