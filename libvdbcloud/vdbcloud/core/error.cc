#include "vdbcloud/core/error.h"

namespace vdbcloud {

std::string printable(std::string_view text, size_t most)
{
    const bool cut = text.size() > most;
    std::string out(text.substr(0, most));
    for (char& c : out) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte < 0x20 || byte >= 0x7f) c = '?';
    }
    return cut ? out + "..." : out;
}

}  // namespace vdbcloud
