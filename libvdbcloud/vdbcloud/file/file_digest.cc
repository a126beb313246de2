#include "vdbcloud/file/file_digest.h"

#include "vdbcloud/core/archive_layout.h"

#include <vector>

namespace vdbcloud {

Digest file_digest(const ReadAt& read)
{
    Digest digest;
    std::vector<char> part(1 << 20);
    digest.add(part.data(), read(part.data(), identifier_begin, 0));
    uint64_t at = identifier_begin + identifier_size;
    for (size_t n; (n = read(part.data(), part.size(), at)) > 0; at += n) digest.add(part.data(), n);
    return digest;
}

}  // namespace vdbcloud
