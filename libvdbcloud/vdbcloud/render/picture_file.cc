#include "vdbcloud/render/picture_file.h"

#include "vdbcloud/core/atomic_file.h"
#include "vdbcloud/core/error.h"

#include <OpenImageIO/filesystem.h>

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

Bytes encoded(const std::string& path, const char* format, const OIIO::ImageSpec& spec, OIIO::TypeDesc type,
              const void* pixels)
{
    const std::string name = std::string("image.") + format;
    auto output = OIIO::ImageOutput::create(name);
    if (!output) throw IoError(printable(path) + ": OpenImageIO has no writer for " + format);
    Bytes bytes;
    OIIO::Filesystem::IOVecOutput memory(bytes);
    // A writer may report success and hold an error, so every step and the remaining error are looked at.
    const bool done = output->set_ioproxy(&memory) && output->open(name, spec) && output->write_image(type, pixels) &&
                      output->close();
    if (!done || output->has_error())
        throw IoError(printable(path) + ": cannot encode " + format + ": " + printable(output->geterror()));
    return bytes;
}

void write_picture_file(const std::string& path, bool no_clobber, const std::function<Bytes()>& make)
{
    if (path == "-") return write_bytes(STDOUT_FILENO, make(), "standard output");
    AtomicFile file(path, no_clobber);  // before encoding, so that a missing folder is reported at once
    write_bytes(file.descriptor(), make(), path);
    file.commit();
}

}  // namespace vdbcloud
