#include "pipelines/pictures.h"

#include <cmath>

namespace vdbcloud::test {

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
