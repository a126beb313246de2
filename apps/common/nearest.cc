#include "nearest.h"

#include <algorithm>
#include <numeric>

namespace vdbcloud::app {

namespace {

/// Edit distance where an exchange of two neighbours is one edit, as it is one slip of the fingers.
size_t edits(const std::string& a, const std::string& b)
{
    std::vector<size_t> before, row(b.size() + 1), next(b.size() + 1);
    std::iota(row.begin(), row.end(), size_t(0));
    for (size_t i = 1; i <= a.size(); ++i) {
        next[0] = i;
        for (size_t j = 1; j <= b.size(); ++j) {
            next[j] = std::min({row[j] + 1, next[j - 1] + 1, row[j - 1] + (a[i - 1] != b[j - 1])});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                next[j] = std::min(next[j], before[j - 2] + 1);
        }
        before = row;
        row.swap(next);
    }
    return row[b.size()];
}

}  // namespace

std::string nearest(const std::string& name, const std::vector<std::string>& known)
{
    std::string best;
    if (name.size() >= 2)
        for (const std::string& word : known)
            if (word.compare(0, name.size(), name) == 0 && (best.empty() || word.size() < best.size())) best = word;
    if (!best.empty()) return best;  // "--res" for --resolution
    size_t least = std::min<size_t>(3, 1 + name.size() / 3);
    for (const std::string& word : known) {
        const size_t distance = edits(name.substr(0, 64), word);
        if (distance >= least) continue;
        least = distance;
        best = word;
    }
    return best;
}

}  // namespace vdbcloud::app
