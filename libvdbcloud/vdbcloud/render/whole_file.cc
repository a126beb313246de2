#include "vdbcloud/render/whole_file.h"

#include "vdbcloud/core/atomic_file.h"
#include "vdbcloud/core/error.h"

#include <unistd.h>

#include <cerrno>

namespace vdbcloud {

namespace {

void write_bytes(int descriptor, const Bytes& bytes, const std::string& path)
{
    for (size_t done = 0; done < bytes.size();) {
        const ssize_t n = ::write(descriptor, bytes.data() + done, bytes.size() - done);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) throw IoError(system_message(path, "cannot write", errno));
        done += size_t(n);
    }
}

}  // namespace

void write_picture_file(const std::string& path, bool no_clobber, const std::function<Bytes()>& make)
{
    if (path == "-") return write_bytes(STDOUT_FILENO, make(), "standard output");
    AtomicFile file(path, no_clobber);  // before encoding, so that a missing folder is reported at once
    write_bytes(file.descriptor(), make(), path);
    file.commit();
}

}  // namespace vdbcloud
