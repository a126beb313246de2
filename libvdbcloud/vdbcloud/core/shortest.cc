#include "vdbcloud/core/shortest.h"

#include <charconv>

namespace vdbcloud {

std::string shortest(double x)
{
    char text[32];
    return {text, std::to_chars(text, text + sizeof text, x).ptr};
}

std::string shortest(const Vec3d& v) { return shortest(v[0]) + "," + shortest(v[1]) + "," + shortest(v[2]); }

}  // namespace vdbcloud
