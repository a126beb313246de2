#include "standard_streams.h"

#include "vdbcloud/core/atomic_file.h"
#include "vdbcloud/core/error.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

namespace vdbcloud::app {

void occupy_standard_descriptors()
{
    for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
        if (::fcntl(descriptor, F_GETFD) != -1 || errno != EBADF) continue;
        // Opened for the direction that nobody uses: every use fails with EBADF, as on a closed descriptor. The system
        // gives the lowest free number, which is this one.
        const int mode = descriptor == STDIN_FILENO ? O_WRONLY : O_RDONLY;
        if (::open("/dev/null", mode) < 0) (void)!::open("/", O_RDONLY | O_DIRECTORY);
    }
}

void require_standard_output()
{
    const int mode = ::fcntl(STDOUT_FILENO, F_GETFL);
    if (mode == -1 || (mode & O_ACCMODE) == O_RDONLY)
        throw IoError("standard output is closed: redirect it, or name a file");
}

void to_standard_output(const std::string& text)
{
    const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
    if (std::fflush(stdout) != 0 || !written) throw IoError(system_message("standard output", "cannot write", errno));
}

}  // namespace vdbcloud::app
