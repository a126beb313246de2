// Work against precision: one cloud grown for 300 s in a slice by every accuracy preset on several grids, against a run
// on a grid four times as fine as the finest. Prints a table for precision.gp; SIZE=full for the whole of it.
//
//     SIZE=full bench_precision > precision.txt && gnuplot -c precision.gp precision.txt precision.svg
#include "support/size.h"

#include "vdbcloud/sim/presets.h"
#include "vdbcloud/sim/simulation.h"

#include <cmath>
#include <cstdio>
#include <ctime>
#include <string>

namespace vdbcloud::sim {
namespace {

constexpr double size = 4000, end = 300;

struct Outcome {
    int n = 0;
    std::vector<double> cloud, w;  // w at centres
    double seconds = 0, bytes = 0;
    Budget budget;
};

/// A bubble in moist air, without noise, before it breaks up: what differs is the method.
Outcome grow(int n, const std::function<void(Parameters&)>& change)
{
    Parameters p;
    p.lattice = {{n, 1, n}, {size / n, size / n, size / n}, {Side::Periodic, Side::Periodic}};
    p.bubbles.push_back({{2000, 0, 700}, 700, 600, 1.5, 1.5e-3, 0});
    change(p);
    auto sim = Simulation::make(
        p, {"humid", {0, 800, 4000}, {300, 300, 314}, {0.014, 0.0135, 0.001}, {0, 0, 0}, {0, 0, 0}, 0});
    const std::clock_t before = std::clock();
    sim->advance_to(end);
    Outcome o;
    o.seconds = double(std::clock() - before) / CLOCKS_PER_SEC;
    o.n = n, o.bytes = double(sim->bytes()), o.budget = sim->budget();
    o.cloud.resize(size_t(n) * size_t(n)), o.w = o.cloud;
    std::vector<double> faces(size_t(n) * size_t(n + 1), 0.0);
    for (int k = 0; k < n; ++k) {
        sim->get_cloud_plane(k, &o.cloud[size_t(k) * size_t(n)]);
        sim->get_plane(Quantity::W, k, &faces[size_t(k) * size_t(n)]);
    }
    for (size_t c = 0; c < o.w.size(); ++c) o.w[c] = 0.5 * (faces[c] + faces[c + size_t(n)]);
    return o;
}

/// Means over the cells of a grid whose spacing is a multiple; the same grid unchanged.
std::vector<double> coarsened(const std::vector<double>& fine, int from, int to)
{
    const int ratio = from / to;
    std::vector<double> mean(size_t(to) * size_t(to), 0.0);
    for (int k = 0; k < from; ++k)
        for (int i = 0; i < from; ++i)
            mean[size_t(k / ratio) * size_t(to) + size_t(i / ratio)] +=
                fine[size_t(k) * size_t(from) + size_t(i)] / (ratio * ratio);
    return mean;
}

/// Sum of |a - b| over that of |b|.
double relative_difference(const std::vector<double>& a, const std::vector<double>& b)
{
    double difference = 0, sum = 0;
    for (size_t c = 0; c < a.size(); ++c) difference += std::abs(a[c] - b[c]), sum += std::abs(b[c]);
    return difference / sum;
}

void study()
{
    const auto accuracy = [](Accuracy a) { return [a](Parameters& p) { apply(a, p); }; };
    const auto huge = [](double dt, bool corrected) {
        return [=](Parameters& p) { p.time_scheme = TimeScheme::HugeStep, p.dt = dt, p.maccormack = corrected; };
    };
    const auto paper = [](Parameters& p) {
        p.time_scheme = TimeScheme::Euler, p.dt = 1;
        p.scalar_scheme = ScalarScheme::Upwind, p.momentum_scheme = MomentumScheme::Upwind;
    };
    const int finest = test::sized(32, 128);
    const Outcome reference = grow(4 * finest, accuracy(Accuracy::Accurate));
    std::printf("# error: sum of differences over sum, against --accuracy accurate on %d x %d cells (%.0f CPU s)\n",
                4 * finest, 4 * finest, reference.seconds);
    std::printf("# method cells CPU_s MB error_of_q_l error_of_w steps divergence water_drift\n");
    const std::vector<std::pair<std::string, std::function<void(Parameters&)>>> methods{
        {"small", accuracy(Accuracy::Small)},       {"default", accuracy(Accuracy::Default)},
        {"accurate", accuracy(Accuracy::Accurate)}, {"forward-upwind", paper},
        {"huge-dt-10s", huge(10, false)},           {"huge-dt-10s-MacCormack", huge(10, true)}};
    for (const auto& [name, change] : methods) {
        for (int n = 16; n <= finest; n *= 2) {
            const Outcome o = grow(n, change);
            std::printf("%s %d %.4f %.3f %.5f %.5f %llu %.1e %+.1e\n", name.c_str(), n, o.seconds, o.bytes / 1e6,
                        relative_difference(o.cloud, coarsened(reference.cloud, reference.n, n)),
                        relative_difference(o.w, coarsened(reference.w, reference.n, n)),
                        static_cast<unsigned long long>(o.budget.steps), o.budget.divergence, o.budget.water_drift);
            std::fflush(stdout);
        }
        std::printf("\n\n");
    }
}

}  // namespace
}  // namespace vdbcloud::sim

int main() { vdbcloud::sim::study(); }
