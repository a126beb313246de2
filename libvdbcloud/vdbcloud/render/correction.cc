#include "vdbcloud/render/correction.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

constexpr double least_alpha = 0.01;  // of a block in the mean
constexpr int rounds = 3;             // of giving back to blocks what the interpolation takes from them

}  // namespace

PixelBlocks::PixelBlocks(const Film& film, int block_edge) : edge(block_edge)
{
    const PixelWindow w = film.window();
    x0 = w.x0 / edge;
    y0 = w.y0 / edge;
    across = (w.x1 + edge - 1) / edge - x0;
    down = (w.y1 + edge - 1) / edge - y0;
    pixels.resize(size_t(across) * size_t(down));
    const int beauty = film.offset(film.find(""));
    std::vector<char> sees(size_t(w.width()) * size_t(w.height()));
    const auto place = [&](int i, int j) { return size_t(j - w.y0) * size_t(w.width()) + size_t(i - w.x0); };
    for (int j = w.y0; j < w.y1; ++j)
        for (int i = w.x0; i < w.x1; ++i) {
            const float* p = film.pixel(i, j) + beauty;
            sees[place(i, j)] = p[0] > 0 || p[1] > 0 || p[2] > 0 || p[3] > 0;
        }
    for (int j = w.y0; j < w.y1; ++j)
        for (int i = w.x0; i < w.x1; ++i) {
            bool counts = false;
            for (int b = std::max(w.y0, j - 1); b <= std::min(w.y1 - 1, j + 1); ++b)
                for (int a = std::max(w.x0, i - 1); a <= std::min(w.x1 - 1, i + 1); ++a)
                    counts = counts || sees[place(a, b)];
            if (counts) pixels[block_of(i, j)].emplace_back(i, j);
        }
}

Correction::Correction(const Film& film, const PixelBlocks& blocks, const std::vector<Vec3d>& guess)
    : film_(film), blocks_(blocks), beauty_(film.offset(film.find(""))), used_(guess.size()),
      per_alpha_(guess.size(), Vec3d(0, 0, 0)), taken_(guess.size(), Vec3d(0, 0, 0))
{
    std::vector<double> share(guess.size());  // pixels over their alpha
    for (size_t b = 0; b < guess.size(); ++b) {
        double alpha = 0;
        for (const auto& [i, j] : blocks.pixels[b]) alpha += film.pixel(i, j)[beauty_ + 3];
        const auto count = double(blocks.pixels[b].size());
        used_[b] = alpha > least_alpha * count;
        if (used_[b]) share[b] = count / alpha;
    }
    for (int round = 0; round < rounds; ++round) {
        for (size_t b = 0; b < guess.size(); ++b)
            if (used_[b]) per_alpha_[b] += (guess[b] - taken_[b]) * share[b];
        find_taken();
    }
}

Vec3d Correction::wanted(int i, int j) const
{
    const double x = (i + 0.5) / blocks_.edge - 0.5 - blocks_.x0, y = (j + 0.5) / blocks_.edge - 0.5 - blocks_.y0;
    const int bx = int(std::floor(x)), by = int(std::floor(y));
    Vec3d sum(0, 0, 0);
    double weights = 0;
    for (int n = 0; n < 4; ++n) {
        const int a = bx + n % 2, b = by + n / 2;
        if (a < 0 || b < 0 || a >= blocks_.across || b >= blocks_.down) continue;
        const size_t block = size_t(b) * size_t(blocks_.across) + size_t(a);
        if (!used_[block]) continue;
        const double w = (1 - std::abs(x - a)) * (1 - std::abs(y - b));
        weights += w;
        sum += w * per_alpha_[block];
    }
    return weights > 0 ? sum / weights : Vec3d(0, 0, 0);
}

Vec3d Correction::at(int i, int j) const
{
    const float* p = film_.pixel(i, j) + beauty_;
    Vec3d change = -double(p[3]) * wanted(i, j);
    for (int c = 0; c < 3; ++c) change[c] = std::max(change[c], -std::max(0.0, double(p[c])));
    return change;
}

void Correction::find_taken()
{
    for (size_t b = 0; b < taken_.size(); ++b) {
        Vec3d sum(0, 0, 0);
        for (const auto& [i, j] : blocks_.pixels[b]) sum -= at(i, j);
        if (!blocks_.pixels[b].empty()) taken_[b] = sum / double(blocks_.pixels[b].size());
    }
}

}  // namespace vdbcloud
