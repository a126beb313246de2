#include "version.h"

#include <openvdb/io/Archive.h>
#include <openvdb/version.h>

namespace vdbcloud::app {

std::string project_version() { return VDBCLOUD_VERSION; }

std::string version_text(const std::string& tool)
{
    std::string codecs = "none";
    if (openvdb::io::Archive::hasZLibCompression()) codecs += ", zip";
    if (openvdb::io::Archive::hasBloscCompression()) codecs += ", blosc";
    return tool + " (vdbcloud) " + project_version() + "\nOpenVDB " OPENVDB_LIBRARY_VERSION_STRING ", file format " +
           std::to_string(openvdb::OPENVDB_FILE_VERSION) + "\ncodecs: " + codecs +
           "\ncompiler: " VDBCLOUD_COMPILER "\n";
}

}  // namespace vdbcloud::app
