#include "pipelines/pictures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

namespace vdbcloud::test {

Pictures by_light_paths(const std::string& cloud, double tau, double w0, double g)
{
    std::ifstream file(VDBCLOUD_SOURCE "/data/references/" + cloud + ".txt");
    Pictures pictures;
    size_t rows = 0;
    for (std::string line; std::getline(file, line);) {
        std::istringstream words(line);
        double depth = 0, albedo = 0, cosine = 0;
        std::string view;
        size_t a = 0, b = 0;
        Mean mean;
        if (!(words >> depth >> albedo >> cosine >> view >> a >> b >> mean.value >> mean.deviation)) continue;
        if (depth != tau || albedo != w0 || cosine != g) continue;
        pictures[view == "above" ? 0 : view == "side" ? 1 : 2][3 * a + b] = mean;
        ++rows;
    }
    EXPECT_EQ(rows, 3 * blocks) << cloud << ' ' << tau << ' ' << w0 << ' ' << g;
    return pictures;
}

Mean mean(const Picture& picture)
{
    Mean m;
    for (const Mean& block : picture) {
        m.value += block.value / blocks;
        m.deviation = std::hypot(m.deviation, block.deviation / blocks);
    }
    return m;
}

Mean rms(const Picture& picture, const Picture& truth)
{
    double sum = 0, noise = 0;
    for (size_t b = 0; b < blocks; ++b) {
        sum += std::pow(picture[b].value - truth[b].value, 2) / blocks;
        noise += std::pow(2 * truth[b].deviation, 2) / blocks;
    }
    return {std::sqrt(sum) / mean(truth).value, std::sqrt(noise) / mean(truth).value};
}

Mean rms(const Pictures& pictures, const Pictures& truth)
{
    Mean all;
    for (size_t v = 0; v < 3; ++v) {
        const Mean one = rms(pictures[v], truth[v]);
        all.value = std::hypot(all.value, one.value / std::sqrt(3.0));
        all.deviation = std::hypot(all.deviation, one.deviation / std::sqrt(3.0));
    }
    return all;
}

}  // namespace vdbcloud::test
