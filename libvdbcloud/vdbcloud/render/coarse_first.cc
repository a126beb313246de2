#include "vdbcloud/render/coarse_first.h"

#include "vdbcloud/render/exposure.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>

namespace vdbcloud {

namespace {

constexpr int coarsest = 8;  // pixels along the edge of a block in the first round

/// Which pixels of a window are computed.
class Computed {
public:
    explicit Computed(const PixelWindow& w) : window_(w), done_(size_t(w.width()) * size_t(w.height()), 0) {}

    void set(int i, int j) { done_[place(i, j)] = 1; }
    bool operator()(int i, int j) const { return done_[place(i, j)]; }

    /// The first pixel of the smallest block about (i, j) whose first pixel is computed. All of the first round are.
    std::array<int, 2> stand_in(int i, int j) const
    {
        int size = 1;
        const auto first = [&](int at, int begin) { return at - (at - begin) % size; };
        while (!(*this)(first(i, window_.x0), first(j, window_.y0))) size *= 2;
        return {first(i, window_.x0), first(j, window_.y0)};
    }

private:
    size_t place(int i, int j) const
    {
        return size_t(j - window_.y0) * size_t(window_.width()) + size_t(i - window_.x0);
    }

    PixelWindow window_;
    std::vector<char> done_;
};

void fill(Film& film, const Computed& computed)
{
    const PixelWindow w = film.window();
    for (int j = w.y0; j < w.y1; ++j)
        for (int i = w.x0; i < w.x1; ++i) {
            const auto [a, b] = computed.stand_in(i, j);
            if (a != i || b != j) std::copy_n(film.pixel(a, b), film.channels(), film.pixel(i, j));
        }
}

}  // namespace

double clock_seconds()
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

bool Showing::due() const
{
    return options_.show && clock_seconds() - last_ >= std::max(options_.show_interval, 10 * taken_);
}

void Showing::show(const Film& film, const ShownPicture& what)
{
    const double start = clock_seconds();
    options_.show(film, what);
    last_ = clock_seconds();
    taken_ = last_ - start;
}

CoarseReport expose_coarse_first(Film& film, const SamplingOptions& sampling, const PassOptions& options,
                                 const SamplerFactory& factory, const Progress& progress)
{
    const double start = clock_seconds();
    const Exposure expose_pixel(film, sampling);
    const PixelWindow w = film.window();
    tbb::enumerable_thread_specific<SampleFunction> samplers(factory);
    Computed computed(w);
    Showing showing(options);
    const double all = double(w.width()) * double(w.height());
    // Rows of a round between two looks at the clock: a few for each thread.
    const int rows_at_a_time = std::max(16, 4 * tbb::this_task_arena::max_concurrency());
    std::atomic<uint64_t> pixels{0};

    // Rows of a round are `size` apart; of these, every second holds pixels of the round before.
    const auto add_rows = [&](int size, int begin, int end) {
        tbb::parallel_for(begin, end, [&](int row) {
            const SampleFunction& sample = samplers.local();
            const int j = w.y0 + row * size;
            const bool half_done = size < coarsest && row % 2 == 0;
            for (int i = w.x0 + (half_done ? size : 0); i < w.x1; i += half_done ? 2 * size : size) {
                expose_pixel(sample, i, j);
                computed.set(i, j);
                pixels.fetch_add(1, std::memory_order_relaxed);
            }
        });
    };
    CoarseReport out;
    for (int size = coarsest; size >= 1; size /= 2) {
        const int rows = (w.height() + size - 1) / size;
        for (int begin = 0; begin < rows; begin += rows_at_a_time) {
            const int end = std::min(rows, begin + rows_at_a_time);
            add_rows(size, begin, end);
            const bool round_done = end == rows;
            if (round_done) out.coarseness = size;
            out.pixels = pixels;
            report(progress, double(out.pixels) / all);
            if (double(out.pixels) == all || out.coarseness == 0) continue;
            if (options.time_limit > 0 && clock_seconds() - start > options.time_limit) {
                fill(film, computed);
                return out;
            }
            if (!showing.due()) continue;
            Film shown = film;
            fill(shown, computed);
            showing.show(shown, {out.coarseness, uint64_t(sampling.samples)});
        }
    }
    return out;
}

}  // namespace vdbcloud
