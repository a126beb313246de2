#include "vdbcloud/file/file_digest.h"

#include "vdbcloud/core/archive_layout.h"
#include "vdbcloud/file/descriptor_stream.h"

#include <vector>

namespace vdbcloud {

Digest file_digest(int descriptor)
{
    Digest digest;
    std::vector<char> part(1 << 20);
    digest.add(part.data(), read_at(descriptor, part.data(), identifier_begin, 0));
    uint64_t at = identifier_begin + identifier_size;
    for (size_t n; (n = read_at(descriptor, part.data(), part.size(), at)) > 0; at += n) digest.add(part.data(), n);
    return digest;
}

}  // namespace vdbcloud
