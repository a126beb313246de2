#include "vdbcloud/render/picture_module.h"

#include "vdbcloud/core/error.h"

#include <dlfcn.h>
#include <sys/mman.h>

namespace vdbcloud {

namespace {

/// Whether the process may map `bytes` more, as `protection` says: libraries that run into a memory limit while they
/// start crash the program.
bool room_for(size_t bytes, int protection)
{
    void* const at = ::mmap(nullptr, bytes, protection, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (at == MAP_FAILED) return false;
    ::munmap(at, bytes);
    return true;
}

struct Opened {
    const PictureModule* module = nullptr;
    std::string trouble;
};

Opened open_module()
{
    // OpenImageIO 2.4 on Debian 12 maps 438 MB, 101 MB of them writable.
    constexpr size_t mapped = size_t(640) << 20, writable = size_t(160) << 20;
    if (!room_for(mapped, PROT_NONE) || !room_for(writable, PROT_READ | PROT_WRITE))
        return {nullptr, "not enough memory to load OpenImageIO: expected a limit (ulimit -v) with 640 MB to spare"};
    void* const library = ::dlopen(picture_module_file, RTLD_NOW | RTLD_LOCAL);
    const char* const trouble = library ? nullptr : ::dlerror();
    if (!library) return {nullptr, std::string("cannot load OpenImageIO: ") + (trouble ? trouble : "unknown reason")};
    using Get = const PictureModule* (*)();
    const auto get = reinterpret_cast<Get>(::dlsym(library, picture_module_symbol));
    if (!get) return {nullptr, std::string(picture_module_file) + ": expected the one of this version of vdbcloud"};
    return {get(), {}};
}

}  // namespace

const PictureModule& picture_module(const std::string& path)
{
    static const Opened opened = open_module();
    if (!opened.module) throw IoError(printable(path) + ": " + printable(opened.trouble));
    return *opened.module;
}

}  // namespace vdbcloud
