#pragma once
// One coarse level of the multigrid: its operator, its smoothing, its vectors. Private to solve/.
#include "vdbcloud/solve/graph.h"

namespace vdbcloud {

struct GraphLevel {
    explicit GraphLevel(Graph);

    Graph a;
    std::vector<float> inverse;  ///< of the diagonal, 0 where there is none
    std::vector<float> b, x;
    std::vector<float> search, image, other;  ///< for the Krylov steps

    size_t size() const { return a.size(); }
    size_t bytes() const;

    /// Groups for the next level (aggregation.h); returns its operator.
    Graph make_groups();
    void drop_groups();

    /// Smooths from x = 0; coarse_b becomes the residual b - A x, summed over groups.
    void descend(std::vector<float>& coarse_b);
    /// Adds the groups' correction to x and smooths.
    void ascend(const std::vector<float>& coarse_x);
    /// Smooths twice from x = 0, without a coarser level.
    void smooth_alone();

    struct Products {
        double x_ax, x_b, b_b;
    };
    /// ax = A x
    Products apply(std::vector<float>& ax) const;
    double x_image() const;
    /// b -= step image; returns b . b.
    double advance(float step);
    /// x = s search + t x
    void scale(float s, float t);

private:
    void smooth_from_zero();
    void smooth();
    std::vector<int32_t> group_;   // of the next level, -1 without one; empty on the last
    std::vector<uint32_t> first_;  // where each group's members begin
    std::vector<int32_t> member_;
};

}  // namespace vdbcloud
