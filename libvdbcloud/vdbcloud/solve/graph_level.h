#pragma once
// One coarse level of the multigrid: its operator, its smoothing, its vectors. Private to solve/.
#include "vdbcloud/solve/graph.h"

#include <memory>

namespace vdbcloud {

/// The rows of a graph, eight at a time, for kernels that work on eight unknowns together. Link k of the eight rows of
/// a batch lies side by side; rows of fewer links than the longest of their batch have links of 0 to themselves.
struct GraphRows {
    explicit GraphRows(const Graph&);
    /// The links of `like`, which the two share, with another extra.
    GraphRows(const GraphRows& like, std::vector<float> extra);

    struct Links {
        std::vector<uint32_t> begin{0};  ///< of each batch of eight rows, in column and c [eights]
        std::vector<int32_t> column;
        std::vector<float> c;
        size_t bytes() const { return 4 * (begin.size() + column.size() + c.size()); }
    };
    std::shared_ptr<const Links> links;
    bool owns_links = true;
    std::vector<float> extra, inverse;  ///< and 1 / diagonal, 0 where there is none; a multiple of eight, then 0

    size_t batches() const { return links->begin.size() - 1; }
    size_t bytes() const { return (owns_links ? links->bytes() : 0) + 4 * (extra.size() + inverse.size()); }
};

class GraphLevel {
public:
    explicit GraphLevel(const Graph&);
    /// The links and groups of `like`, which the two share, with another extra.
    GraphLevel(const GraphLevel& like, std::vector<float> extra);
    const std::vector<float>& extra() const { return rows_.extra; }
    /// Extra of the next level, given that of the next level of `like`.
    std::vector<float> next_extra(const GraphLevel& like, const GraphLevel& next) const;

    size_t size() const { return size_; }
    size_t bytes() const;

    /// Vectors of size() unknowns and up to seven zeros.
    std::vector<float> b, x;
    std::vector<float> search, image, other;  ///< for the Krylov steps

    /// Groups of the graph of this level for the next level (aggregation.h); returns its operator.
    Graph make_groups(const Graph&);
    void drop_groups();

    /// coarse_b becomes b, summed over groups.
    void descend(std::vector<float>& coarse_b) const;
    /// x becomes the groups' correction, smoothed.
    void ascend(const std::vector<float>& coarse_x);
    /// Smooths twice from x = 0, without a coarser level.
    void smooth_alone();

    struct Products {
        double x_ax, x_b, b_b, x_image;
    };
    /// ax = A x. Products of x and b with it, and of x with `image`.
    Products apply(std::vector<float>& ax) const;
    /// b -= step image; returns b . b.
    double advance(float step);
    /// x = s search + t x
    void scale(float s, float t);

private:
    void smooth();
    size_t size_;
    GraphRows rows_;
    struct Groups {
        std::vector<int32_t> of;      // of the next level, -1 without one; empty on the last
        std::vector<uint32_t> first;  // where each group's members begin
        std::vector<int32_t> member;
    };
    std::shared_ptr<const Groups> groups_ = std::make_shared<Groups>();
};

}  // namespace vdbcloud
