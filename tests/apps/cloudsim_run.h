#pragma once
// Short runs of cloudsim.
#include "support/run.h"

#include <string>
#include <vector>

namespace vdbcloud::test {

using Words = std::vector<std::string>;

inline const Words small_box{"--cells", "16,12,20", "--minutes", "4", "--every", "1min"};

inline RunResult cloudsim(Words words, const RunOptions& options = {})
{
    words.insert(words.begin(), small_box.begin(), small_box.end());
    words.insert(words.begin(), program("cloudsim"));
    return run(words, options);
}

/// A first bubble that is cloud from the start, so that four minutes suffice.
inline const Words wet{"--bubble", "2000,2000,1200,900,700,1,5e-3"};

inline Words with(Words a, const Words& b)
{
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

}  // namespace vdbcloud::test
