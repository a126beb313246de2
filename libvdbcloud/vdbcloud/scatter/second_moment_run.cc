// The iteration of sweeps and solves, for several channels at once.
#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/memory.h"
#include "vdbcloud/core/release.h"
#include "vdbcloud/scatter/active_slots.h"
#include "vdbcloud/scatter/mixing.h"
#include "vdbcloud/scatter/second_moment.h"
#include "vdbcloud/scatter/solid_walls.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace vdbcloud {

namespace {

constexpr double loosest = 0.1;  // tolerance of a solve between sweeps

/// Estimates contraction and remaining error. Contraction is a mean over the last steps, as it varies under mixing.
void estimate_error(ClosureReport& report)
{
    const size_t n = report.change.size(), steps = std::min<size_t>(3, n - std::min<size_t>(n, 1));
    report.error = -1;
    if (steps == 0 || !(report.change[n - 1 - steps] > 0)) return;
    report.contraction = std::pow(report.change[n - 1] / report.change[n - 1 - steps], 1.0 / double(steps));
    if (report.contraction < 1) report.error = report.change[n - 1] * report.contraction / (1 - report.contraction);
}

double seconds_since(std::chrono::steady_clock::time_point start)
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// The same directions and functions of direction; inflow may differ.
bool alike(const SweepSet& a, const SweepSet& b)
{
    return a.direction == b.direction && a.weight == b.weight && a.source_terms == b.source_terms &&
           a.source_basis == b.source_basis && a.moment_terms == b.moment_terms && a.moment_basis == b.moment_basis;
}

}  // namespace

/// A sweep of one channel.
struct SecondMoment::Sweep {
    SecondMoment* of;
    const SweepSet* set;
    const std::vector<std::vector<float>>* source;
    SweepResult* to;
    PlaneLight* planes;
    SweepGround* ground;
    WallLight* walls;
};

WallLight* SecondMoment::walls() const { return walls_ ? &walls_->light : nullptr; }

/// Sweeps channels of equal extinction and directions at once.
void SecondMoment::run_together(const std::vector<Sweep>& all, bool emission)
{
    std::vector<char> done(all.size(), 0);
    for (size_t first = 0; first < all.size(); ++first) {
        if (done[first]) continue;
        std::vector<SweepChannel> channels;
        for (size_t n = first; n < all.size(); ++n) {
            const Sweep& one = all[n];
            if (done[n] || !one.of->shares_extinction(*all[first].of) || !alike(*one.set, *all[first].set)) continue;
            channels.push_back({one.set, one.source, one.to, one.planes, one.ground, one.walls});
            done[n] = 1;
        }
        all[first].of->transport_.run(*all[first].of->sigma_, emission, channels);
    }
}

void SecondMoment::sweep_emission(const std::vector<Channel>& channels)
{
    std::vector<SweepSet> sets;
    std::vector<SweepGround> grounds(channels.size());
    std::vector<WallLight> walls(channels.size());  // black
    std::vector<Sweep> sweeps;
    sets.reserve(channels.size());
    for (size_t n = 0; n < channels.size(); ++n) {
        SecondMoment& own = *channels[n].closure;
        if (own.emission_.empty()) continue;
        SweepSet& set = sets.emplace_back(own.set_);
        set.source_terms = 1;
        set.source_basis.assign(set.count(), float(std::sqrt(1 / (4 * pi))));
        set.inflow.clear();
        if (own.ground_) {
            grounds[n] = *own.ground_;
            grounds[n].direct.assign(own.ground_->direct.size(), 0.0f);
        }
        if (own.walls_) {
            walls[n].walls = own.walls_->light.walls;
            walls[n].radiance.assign(own.walls_->direct.size(), 0.0f);
        }
        const PlaneLight* planes = channels[n].planes;
        own.glow_.planes.by_cell = planes && planes->by_cell;
        sweeps.push_back({&own, &set, &own.emission_, &own.glow_.light, planes ? &own.glow_.planes : nullptr,
                          own.ground_ ? &grounds[n] : nullptr, own.walls_ ? &walls[n] : nullptr});
    }
    run_together(sweeps, true);
    for (const Sweep& each : sweeps)
        if (each.ground) each.of->glow_.on_ground = std::move(each.ground->irradiance);
    for (const Sweep& each : sweeps)
        if (each.walls) each.of->glow_.on_walls = std::move(each.walls->irradiance);
}

/// Adds the light of emission to that of a sweep.
void SecondMoment::add_glow(const Sweep& sweep) const
{
    if (emission_.empty()) return;
    const auto add = [](const std::vector<float>& from, std::vector<float>& sum) {
        for (size_t n = 0; n < sum.size(); ++n) sum[n] += from[n];
    };
    SweepResult& to = *sweep.to;
    for (size_t k = 0; k < to.moments.size(); ++k) add(glow_.light.moments[k], to.moments[k]);
    for (size_t n = 0; n < to.tally.size(); ++n) {
        to.tally[n].current += glow_.light.tally[n].current;
        to.tally[n].fluence += glow_.light.tally[n].fluence;
        to.tally[n].second += glow_.light.tally[n].second;
    }
    if (ground_) add(glow_.on_ground, ground_->irradiance);
    if (walls_) add(glow_.on_walls, walls_->light.irradiance);
    if (sweep.planes) sweep.planes->add(glow_.planes);
}

/// Light by the sources of collided light and of the sky, and the light of emission.
void SecondMoment::sweep(const std::vector<Sweep>& sweeps)
{
    run_together(sweeps, false);
    for (const Sweep& each : sweeps) {
        each.of->drop_source();
        each.of->add_glow(each);
        if (each.walls) each.of->walls_->reflect();
    }
}

void SecondMoment::sweep_planes(const std::vector<double>& phi, PlaneLight* planes)
{
    take_phi(phi);
    build_source();
    sweep_emission({{this, nullptr, nullptr, nullptr, planes}});
    SweepResult unused;
    sweep({{this, &set_, &source_, &unused, planes, ground_, walls()}});
}

/// One channel's iteration.
class SecondMoment::Run {
public:
    /// `followed`: other channels take part.
    Run(const Channel& channel, const SolveOptions& options, bool followed)
        : of_(channel), my_(*channel.closure), options_(options), followed_(followed),
          mixing_(my_.p1_.blocks().slots(), mixed_arrays(my_.p1_.mean_cosine()), mixing_depth(my_.p1_.mean_cosine()))
    {
        report_.directions = my_.ordinates_.count();
        my_.take_phi(*of_.phi);
        of_phi_ = norm(of_.source->rhs);
        outflow_ = my_.take_replaced(*of_.source);
        rhs_.assign(of_.source->rhs.begin(), of_.source->rhs.end());
        release(of_.source->rhs);
        options_.progress = {};
    }

    bool ends() const { return report_.converged || report_.iterations >= my_.o_.iterations; }

    /// The next sweep.
    Sweep before()
    {
        start_ = std::chrono::steady_clock::now();
        release(*of_.phi);
        if (is_last()) mixing_.forget();
        mixing_.before(my_.swept_.moments);
        my_.build_source();
        lends_scratch_ = exchange_scratch();
        // Planes cost a few per cent of a sweep, so only a sweep that may be the last sums them.
        has_planes_ =
            of_.planes && (is_last() || (report_.iterations > 0 && report_.change.back() < 8 * my_.o_.change));
        seconds_ = seconds_since(start_);
        return {&my_,        &my_.set_,  &my_.source_, &my_.swept_, has_planes_ ? of_.planes : nullptr,
                my_.ground_, my_.walls()};
    }

    /// Solves for phi from what the sweep, which took `seconds`, has found. `before`: channels that are done with this.
    void after(double seconds, const std::vector<Run*>& before)
    {
        start_ = std::chrono::steady_clock::now();
        of_.source->rhs.assign(rhs_.begin(), rhs_.end());
        my_.close(*of_.source, outflow_);
        if (lends_scratch_) exchange_scratch();
        my_.drop_moments();
        // The solver's tolerance is relative to the right side for phi - phi_L, which shrinks as sweeps converge.
        const double size = norm(of_.source->rhs);
        const auto tolerance_at = [&](double change) {
            const double tolerance = tolerance_between(my_.o_, options_, change);
            if (tolerance == options_.tolerance || size >= of_phi_) return tolerance;
            return std::min(tolerance * of_phi_ / size, loosest);
        };
        SolveOptions solve = options_;
        solve.tolerance = tolerance_at(report_.change.empty() ? 1.0 : report_.change.back());
        const std::vector<float> swept = my_.swept_.moments[0], closed(of_.source->rhs.begin(), of_.source->rhs.end());
        std::vector<double> excess(excess_.begin(), excess_.end());
        changes_.clear();
        report_.solves.push_back(solve_excess(solve, before, excess));
        my_.take_excess(swept, excess);
        // Where the change falls steeply its own share is less than that of the change before, and no sweep follows.
        const double change = mixing_.change(my_.swept_.moments);
        if ((is_last() || change < my_.o_.change) && tolerance_at(change) < solve.tolerance / 2) {
            solve.tolerance = tolerance_at(change);
            of_.source->rhs.assign(closed.begin(), closed.end());
            SolveResult again = solve_excess(solve, before, excess);
            my_.take_excess(swept, excess);
            again.iterations += report_.solves.back().iterations;
            report_.solves.back() = std::move(again);
        }
        release(of_.source->rhs);
        report_.change.push_back(mixing_.after(my_.swept_.moments));
        ++report_.iterations;
        report_.converged = report_.change.back() < my_.o_.change;
        if (ends())
            put_phi(swept, excess);
        else
            mixing_.next(my_.swept_.moments);
        report_.seconds.push_back(seconds_ + seconds + seconds_since(start_));
    }

    /// Forgets what the channels that follow start from.
    void drop_changes() { changes_.clear(); }

    ClosureReport finish()
    {
        if (of_.planes && !has_planes_) {
            my_.build_source();
            SweepResult unused;
            sweep({{&my_, &my_.set_, &my_.source_, &unused, of_.planes, my_.ground_, my_.walls()}});
        }
        estimate_error(report_);
        return std::move(report_);
    }

private:
    bool is_last() const { return report_.iterations + 1 == my_.o_.iterations; }
    double norm(const std::vector<double>& v) const { return std::sqrt(dot(my_.p1_.blocks(), v.data(), v.data())); }
    /// The next solve of this iteration: from the last excess, and from what the solves of the channels before have
    /// changed.
    SolveResult solve_excess(const SolveOptions& options, const std::vector<Run*>& before, std::vector<double>& excess)
    {
        Fields alike;
        for (const Run* other : before)
            if (other->changes_.size() > changes_.size()) alike.push_back(&other->changes_[changes_.size()]);
        std::vector<float>* change = nullptr;
        if (followed_) {
            change = &changes_.emplace_back(my_.p1_.blocks().slots(), 0.0f);
            for (size_t slot = 0; slot < excess.size(); ++slot) (*change)[slot] = -float(excess[slot]);
        }
        release(excess_);
        SolveResult result = solve_p1(my_.p1_, *of_.multigrid, *of_.source, excess, options, alike);
        if (change) each_active(my_.p1_.blocks(), [&](size_t slot) { (*change)[slot] += float(excess[slot]); });
        excess_.assign(excess.begin(), excess.end());
        return result;
    }
    /// Gives the solver's scratch fields to moments that are freed after close(), or back. False: not possible.
    bool exchange_scratch()
    {
        auto& moments = my_.swept_.moments;
        std::vector<float>*last[2] = {&moments.back(), &moments[moments.size() - 2]},
        *scratch[2] = {&of_.multigrid->scratch(0), &of_.multigrid->scratch(1)};
        for (int n = 0; n < 2; ++n)
            if (last[n]->empty() == scratch[n]->empty()) return false;
        for (int n = 0; n < 2; ++n) last[n]->swap(*scratch[n]);
        return true;
    }
    /// phi = phi_L + `excess`.
    void put_phi(const std::vector<float>& swept, const std::vector<double>& excess)
    {
        of_.phi->assign(swept.size(), 0.0);
        each_active(my_.p1_.blocks(), [&](size_t slot) { (*of_.phi)[slot] = fluence_of(swept[slot]) + excess[slot]; });
    }

    const Channel of_;
    SecondMoment& my_;
    SolveOptions options_;
    const bool followed_;
    bool lends_scratch_ = false;
    std::vector<float> rhs_;       // before the parts of a sweep: take_replaced()
    std::vector<double> outflow_;  // the same
    double of_phi_ = 0, seconds_ = 0;
    std::vector<float> excess_;                // from which the next solve starts
    std::vector<std::vector<float>> changes_;  // of the excess, by each solve of this iteration
    Mixing mixing_;
    bool has_planes_ = false;
    ClosureReport report_;
    std::chrono::steady_clock::time_point start_;
};

std::vector<ClosureReport> SecondMoment::run(const std::vector<Channel>& channels, const SolveOptions& options)
{
    sweep_emission(channels);
    std::vector<std::unique_ptr<Run>> runs;
    int iterations = 0;
    for (const Channel& channel : channels) {
        runs.push_back(std::make_unique<Run>(channel, options, channels.size() > 1));
        iterations = std::max(iterations, channel.closure->o_.iterations);
    }
    for (int k = 0; k < iterations; ++k) {
        std::vector<Run*> at_work;
        std::vector<Sweep> sweeps;
        for (const auto& each : runs)
            if (!each->ends()) at_work.push_back(each.get());
        if (at_work.empty()) break;
        report(options.progress, double(k) / iterations);
        for (Run* each : at_work) sweeps.push_back(each->before());
        const auto start = std::chrono::steady_clock::now();
        sweep(sweeps);
        give_back_free_memory();  // of the sweep, before the balance of cells, which takes most
        const double seconds = seconds_since(start) / double(at_work.size());
        std::vector<Run*> before;
        for (Run* each : at_work) {
            each->after(seconds, before);
            before.push_back(each);
        }
        for (Run* each : at_work) each->drop_changes();
    }
    std::vector<ClosureReport> reports;
    for (const auto& each : runs) reports.push_back(each->finish());
    return reports;
}

ClosureReport SecondMoment::run(Multigrid& multigrid, const SolveOptions& options, P1Source& source,
                                std::vector<double>& phi, PlaneLight* planes)
{
    return run({{this, &multigrid, &source, &phi, planes}}, options)[0];
}

}  // namespace vdbcloud
