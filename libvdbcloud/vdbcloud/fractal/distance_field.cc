#include "vdbcloud/fractal/distance_field.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

constexpr float far = 1e30f;  // square of a distance to nothing

/// One line of the transform: out[i] = min over j of f[j] + (h (i - j))^2.
struct Line {
    explicit Line(int n) : value(size_t(n)), out(size_t(n)), apex(size_t(n)), from(size_t(n) + 1) {}

    void transform(double h)
    {
        const int n = int(value.size());
        int top = -1;
        for (int i = 0; i < n; ++i) {
            if (value[size_t(i)] >= far) continue;
            double meet = -1e300;
            while (top >= 0 && (meet = crossing(apex[size_t(top)], i, h)) <= from[size_t(top)]) --top;
            ++top;
            apex[size_t(top)] = i;
            from[size_t(top)] = top == 0 ? -1e300 : meet;
        }
        if (top < 0) return std::fill(out.begin(), out.end(), far);
        from[size_t(top) + 1] = 1e300;
        for (int i = 0, k = 0; i < n; ++i) {
            while (from[size_t(k) + 1] < i) ++k;
            const double d = h * (i - apex[size_t(k)]);
            out[size_t(i)] = float(d * d + double(value[size_t(apex[size_t(k)])]));
        }
    }

    std::vector<float> value, out;

private:
    /// Where the parabola of b, to the right, falls below that of a.
    double crossing(int a, int b, double h) const
    {
        const double fa = double(value[size_t(a)]) / (h * h) + double(a) * a;
        const double fb = double(value[size_t(b)]) / (h * h) + double(b) * b;
        return (fb - fa) / (2.0 * (b - a));
    }

    std::vector<int> apex;
    std::vector<double> from;
};

/// Both distances at once in one array of squares: positive inside the set, negative outside.
void along(std::vector<float>& squares, const Vec3i& size, int axis, double h)
{
    const size_t stride[3] = {size_t(size[1]) * size_t(size[2]), size_t(size[2]), 1};
    const int a = axis == 0 ? 1 : 0, b = axis == 2 ? 1 : 2, n = size[axis];
    tbb::parallel_for(tbb::blocked_range<int>(0, size[a]), [&](const auto& range) {
        Line inside(n), outside(n);
        for (int i = range.begin(); i != range.end(); ++i)
            for (int j = 0; j < size[b]; ++j) {
                float* first = squares.data() + size_t(i) * stride[a] + size_t(j) * stride[b];
                for (int k = 0; k < n; ++k) {
                    const float s = first[size_t(k) * stride[axis]];
                    inside.value[size_t(k)] = std::max(s, 0.0f);
                    outside.value[size_t(k)] = std::max(-s, 0.0f);
                }
                inside.transform(h);
                outside.transform(h);
                for (int k = 0; k < n; ++k) {
                    float& s = first[size_t(k) * stride[axis]];
                    s = s > 0 ? inside.out[size_t(k)] : -outside.out[size_t(k)];
                }
            }
    });
}

}  // namespace

std::vector<float> signed_distance(const Vec3i& size, const Vec3d& step, const std::vector<uint8_t>& inside)
{
    std::vector<float> d(inside.size());
    std::transform(inside.begin(), inside.end(), d.begin(), [](uint8_t in) { return in ? far : -far; });
    for (int axis : {2, 1, 0}) along(d, size, axis, step[axis]);
    const float half = float(0.5 * std::min({step[0], step[1], step[2]}));
    tbb::parallel_for(tbb::blocked_range<size_t>(0, d.size()), [&](const auto& range) {
        for (size_t v = range.begin(); v != range.end(); ++v)
            d[v] = d[v] > 0 ? std::sqrt(d[v]) - half : half - std::sqrt(-d[v]);
    });
    return d;
}

}  // namespace vdbcloud
