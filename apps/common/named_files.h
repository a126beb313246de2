#pragma once
// The files that options name: what each may be called, and whether two names are one file.
#include <string>

namespace vdbcloud::app {

/// What a program writes into a file. The extensions of each kind are in named_files.cc.
enum class FileKind {
    Grids,    ///< .vdb
    Picture,  ///< .exr or .png
    Png,      ///< .png
    Map,      ///< .exr of floats
    Report,   ///< JSON
    Other,    ///< log, checkpoint
    Any       ///< a file of any name
};

/// Throws UsageError, beginning with `option`, unless a file of this kind may be called `path`.
///
/// Grids and pictures need one of the extensions of their kind, in any case of letters. Reports and others take any
/// name that does not have the extension of another kind, of a NanoVDB file or of a configuration. "-", devices,
/// fifos and folders are judged elsewhere.
void require_name(const std::string& option, const std::string& path, FileKind);

/// Identifies the file behind a name: equal for two spellings, symbolic or hard links of one file, whether the file
/// exists or not. For "-" the file behind `standard_stream` (a descriptor). Empty for a device, which several outputs
/// may share.
struct FileIdentity {
    std::string key;
    bool regular = false;  ///< a regular file, or a name that nothing has yet
};
FileIdentity identify(const std::string& path, int standard_stream);

}  // namespace vdbcloud::app
