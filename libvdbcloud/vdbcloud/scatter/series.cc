#include "vdbcloud/scatter/series.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/scatter/active_slots.h"
#include "vdbcloud/scatter/exposed_beam.h"
#include "vdbcloud/scatter/free_flux.h"
#include "vdbcloud/solve/dense.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

/// Computes I_0, I_1, ... in order and stores the quantities of each order that the next order needs.
class Orders {
public:
    Orders(const P1Operator& base, const SeriesSources& sources)
        : p1_(base), sources_(sources), g_(base.mean_cosine()), delta_f_(base.delta().delta_f),
          extinction_(base.medium().sigma_t_per_density), rhs_(base.blocks().slots()), outside_(base.exposed().size())
    {
        for (auto& faces : flux_) faces.assign(forward() ? base.blocks().slots() : 0, 0.0);
        for (auto& faces : additive_) faces.assign(forward() ? base.blocks().slots() : 0, 0.0);
        leaving_.resize(base.exposed().size());
    }

    SolveResult next(Multigrid& multigrid, const SolveOptions& options, std::vector<double>& phi)
    {
        assemble();
        P1Source source(p1_);
        source.rhs.swap(rhs_);
        if (order_ == 0) add_sky(p1_, sources_.sky, source);
        if (order_ == 0 && sources_.emission) add_emission(p1_, *sources_.emission, 1, source);
        std::vector<double> x;
        const SolveResult result = solve_p1(p1_, multigrid, source, x, options);
        rhs_.swap(source.rhs);
        phi_ = x;
        phi = std::move(x);
        if (forward()) keep_flux(source.sky_inflow);
        ++order_;
        return result;
    }

private:
    bool forward() const { return g_ != 0; }

    /// Taylor coefficients of w0'(beta) = (1-beta)(1-f) / (1-f+beta f), times those of exp(-beta f tau), order k.
    double scatter_order(double tau) const
    {
        double sum = 0, power = 1;  // (-f tau)^j / j!
        for (int j = 0; j <= order_; ++j) {
            const int i = order_ - j;
            const double r = -delta_f_ / (1 - delta_f_), a = i == 0 ? 1 : std::pow(r, i) - std::pow(r, i - 1);
            sum += a * power;
            power *= -delta_f_ * tau / (j + 1);
        }
        return sum;
    }
    /// Taylor coefficient of order k of (1-beta) exp(-beta f tau).
    double forward_order(double tau) const
    {
        double power = 1, before = 0;
        for (int j = 0; j < order_; ++j) {
            before = power;
            power *= -delta_f_ * tau / (j + 1);
        }
        return order_ == 0 ? 1 : power - before;
    }

    void assemble()
    {
        const Blocks& blocks = p1_.blocks();
        std::fill(rhs_.begin(), rhs_.end(), 0.0);
        const double back = forward() ? -g_ / (1 - g_) : 0;
        for (int a = 0; a < 3 && forward(); ++a)
            for (size_t slot = 0; slot < flux_[a].size(); ++slot)
                additive_[a][slot] = order_ > 0 ? back * flux_[a][slot] : 0.0;
        for (size_t k = 0; k < outside_.size(); ++k)
            for (int face = 0; face < 6; ++face) leaving_[k][face] = order_ > 0 ? back * outside_[k][face] : 0.0;
        if (order_ > 0)
            each_active(blocks, [&](size_t slot) { rhs_[slot] -= p1_.sigma_t(slot) * p1_.hbar() * phi_[slot]; });
        for (const auto& [depths, strength] : sources_.beams) add_beam_order(depths, strength);

        for (int a = 0; a < 3 && forward(); ++a)
            each_active(blocks, [&](size_t slot) {
                const size_t above = blocks.neighbour(slot, 2 * a + 1);
                rhs_[slot] += additive_[a][slot] - (blocks.active(above) ? additive_[a][above] : 0.0);
            });
        for (size_t k = 0; k < p1_.exposed().size(); ++k) {
            const ExposedVoxel& voxel = p1_.exposed()[k];
            for (int face = 0; face < 6; ++face) {
                if (!(voxel.faces >> face & 1)) continue;
                const double area = p1_.face_area(face / 2);
                leaving_[k][face] = p1_.boundary_flux(voxel, face, leaving_[k][face] / area) * area;
                rhs_[voxel.slot] -= leaving_[k][face];
            }
        }
    }

    void add_beam_order(const BeamDepths& depths, double strength)
    {
        const Blocks& blocks = p1_.blocks();
        const FreeFlux free(p1_, depths.light);
        const ExposedBeam at_exposed(p1_, depths, extinction_);
        const double q = forward() ? (g_ - delta_f_) / (1 - g_) : 0;
        const auto beam = [&](double depth) { return strength * std::exp(-(1 - delta_f_) * extinction_ * depth); };
        std::vector<double> u(blocks.slots());
        for (int a = 0; a < 3; ++a) {
            std::fill(u.begin(), u.end(), 0.0);
            each_active(blocks, [&](size_t slot) {
                if (!blocks.active(blocks.neighbour(slot, 2 * a))) return;
                const double depth = depths.lower[a][slot], through = free(slot, a, 0) * beam(depth);
                u[slot] = through * scatter_order(extinction_ * depth);
                if (forward()) additive_[a][slot] += q * through * forward_order(extinction_ * depth);
            });
            each_active(blocks, [&](size_t slot) {
                const size_t above = blocks.neighbour(slot, 2 * a + 1);
                rhs_[slot] += u[slot] - (blocks.active(above) ? u[above] : 0.0);
            });
            for (size_t k = 0; k < p1_.exposed().size(); ++k) {
                const ExposedVoxel& voxel = p1_.exposed()[k];
                for (int up = 0; up < 2; ++up) {
                    if (!(voxel.faces >> (2 * a + up) & 1)) continue;
                    at_exposed.each_depth(k, 2 * a + up, [&](double weight, double depth) {
                        const double outward = (up ? weight : -weight) * free(voxel.slot, a, up) * beam(depth);
                        rhs_[voxel.slot] -= outward * scatter_order(extinction_ * depth);
                        leaving_[k][2 * a + up] += q * outward * forward_order(extinction_ * depth);
                    });
                }
            }
        }
    }

    void keep_flux(const std::array<double, 6>& sky_inflow)
    {
        const Blocks& blocks = p1_.blocks();
        for (int a = 0; a < 3; ++a)
            each_active(blocks, [&](size_t slot) {
                const size_t below = blocks.neighbour(slot, 2 * a);
                flux_[a][slot] =
                    blocks.active(below)
                        ? double(p1_.stencil().face[a][below]) * (phi_[below] - phi_[slot]) + additive_[a][slot]
                        : 0.0;
            });
        for (size_t k = 0; k < outside_.size(); ++k) {
            const ExposedVoxel& voxel = p1_.exposed()[k];
            for (int face = 0; face < 6; ++face)
                if (voxel.faces >> face & 1)
                    outside_[k][face] =
                        p1_.conductance(voxel, face) * (phi_[voxel.slot] - sky_inflow[face]) + leaving_[k][face];
        }
    }

    const P1Operator& p1_;
    const SeriesSources& sources_;
    double g_, delta_f_, extinction_;
    int order_ = 0;
    std::vector<double> rhs_, phi_;
    std::array<std::vector<double>, 3> flux_, additive_;    // through lower faces, with area
    std::vector<std::array<double, 6>> outside_, leaving_;  // through exposed faces, outward, with area
};

/// Galerkin solution at one albedo on a basis: the direct operator and its sources, projected.
std::vector<double> galerkin(const P1Operator& p1, const SeriesSources& sources,
                             const std::vector<std::vector<double>>& basis)
{
    P1Source source(p1);
    const double extinction = p1.medium().sigma_t_per_density * p1.scaling(0).extinction;
    for (const auto& [depths, strength] : sources.beams) add_beam(p1, depths, extinction, {{&source, strength}});
    add_sky(p1, sources.sky, source);
    if (sources.emission) add_emission(p1, *sources.emission, 1, source);
    const size_t n = basis.size();
    std::vector<double> h(n * n), b(n), product(p1.blocks().slots(), 0.0);
    for (size_t j = 0; j < n; ++j) {
        apply(p1.stencil(), basis[j], product);
        for (size_t i = 0; i < n; ++i) h[i * n + j] = dot(p1.blocks(), basis[i].data(), product.data());
        b[j] = dot(p1.blocks(), basis[j].data(), source.rhs.data());
    }
    return SemidefiniteFactor(h, n, 0).solve(b);
}

/// Nodes of the table: Chebyshev-Lobatto points in (beta / beta_max)^(1/4).
double node_of(int k, int nodes) { return 0.5 - 0.5 * std::cos(pi * k / (nodes - 1)); }

}  // namespace

AlbedoSeries albedo_series(const VoxelIndex& index, const std::vector<float>& density,
                           const std::vector<ExposedVoxel>& exposed, const P1Medium& medium,
                           const SeriesSources& sources, const SeriesOptions& options)
{
    if (medium.tint) throw InputError("the series in albedo needs one albedo for all voxels: expected no Cd");
    P1Medium conservative = medium;
    conservative.albedo = 1;
    const P1Operator base(index, density, exposed, conservative);
    Multigrid multigrid(base.stencil());
    SolveOptions solve = options.solve;
    solve.tolerance = std::min(solve.tolerance, series_tolerance);

    AlbedoSeries series;
    std::vector<std::vector<double>> basis, rows;
    Orders orders(base, sources);
    const Blocks& blocks = index.blocks();
    for (int k = 0; k <= options.order; ++k) {
        solve.progress = [&](double f) {
            return !options.solve.progress || options.solve.progress((k + f) / (options.order + 2));
        };
        std::vector<double> v;
        const SolveResult result = orders.next(multigrid, solve, v);
        series.iterations += result.iterations;
        series.converged = series.converged && (result.converged || result.residual < 1e-9);
        series.norm.push_back(std::sqrt(dot(blocks, v.data(), v.data())));
        // Orthogonalise twice: the I_k are nearly parallel, so one pass leaves components from rounding.
        std::vector<double> row(size_t(k) + 1, 0.0);
        for (int pass = 0; pass < 2; ++pass)
            for (size_t j = 0; j < basis.size(); ++j) {
                const double along = dot(blocks, v.data(), basis[j].data());
                row[j] += along;
                each_active(blocks, [&](size_t slot) { v[slot] -= along * basis[j][slot]; });
            }
        row[size_t(k)] = std::sqrt(dot(blocks, v.data(), v.data()));
        if (!(row[size_t(k)] >
              1e-13 * series.norm.back())) {  // I_k is in the span of the others: the basis is complete
            series.norm.pop_back();
            break;
        }
        each_active(blocks, [&](size_t slot) { v[slot] /= row[size_t(k)]; });
        basis.push_back(std::move(v));
        rows.push_back(std::move(row));
    }
    const size_t n = basis.size();
    series.map.assign(n * n, 0.0);
    for (size_t k = 0; k < n; ++k) std::copy(rows[k].begin(), rows[k].end(), series.map.begin() + ptrdiff_t(k * n));
    for (const auto& v : basis) series.basis.emplace_back(v.begin(), v.end());

    double widest = 1 - options.least_albedo;
    if (!options.galerkin && series.ratio() > 0) widest = std::min(widest, 0.9 / series.ratio());
    for (int k = options.nodes - 1; k >= 0; --k) {
        const double albedo = 1 - widest * std::pow(node_of(k, options.nodes), 4);
        series.albedo.push_back(albedo);
        std::vector<double> row;
        if (options.galerkin) {
            P1Medium here = medium;
            here.albedo = albedo;
            row = galerkin(P1Operator(index, density, exposed, here), sources, basis);
        } else
            row = partial_sum(series, albedo);
        series.table.insert(series.table.end(), row.begin(), row.end());
    }
    return series;
}

std::vector<double> partial_sum(const AlbedoSeries& series, double albedo)
{
    const size_t n = series.size();
    std::vector<double> c(n, 0.0);
    double power = 1;
    for (size_t k = 0; k < n; ++k, power *= 1 - albedo)
        for (size_t j = 0; j <= k; ++j) c[j] += power * series.map[k * n + j];
    return c;
}

std::vector<double> series_coefficients(const std::vector<double>& albedo, const std::vector<double>& table, double at)
{
    const size_t nodes = albedo.size(), n = nodes ? table.size() / nodes : 0;
    if (nodes < 2 || !(at >= albedo.front() - 1e-12 && at <= albedo.back() + 1e-12))
        throw InputError("albedo " + std::to_string(at) + ": the series' table reaches from " +
                         std::to_string(nodes ? albedo.front() : 1) + " to " +
                         std::to_string(nodes ? albedo.back() : 1));
    const double widest = 1 - albedo.front(), t = widest > 0 ? std::pow(std::max(0.0, (1 - at) / widest), 0.25) : 0;
    std::vector<double> sum(n, 0.0);
    double weights = 0;
    for (size_t row = 0; row < nodes; ++row) {
        const int k = int(nodes - 1 - row);
        const double distance = t - node_of(k, int(nodes));
        if (std::abs(distance) < 1e-14)
            return {table.begin() + ptrdiff_t(row * n), table.begin() + ptrdiff_t(row * n + n)};
        const double w = (k % 2 ? -1.0 : 1.0) * (k == 0 || k == int(nodes) - 1 ? 0.5 : 1.0) / distance;
        weights += w;
        for (size_t j = 0; j < n; ++j) sum[j] += w * table[row * n + j];
    }
    for (double& c : sum) c /= weights;
    return sum;
}

}  // namespace vdbcloud
