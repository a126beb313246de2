#pragma once
#include <string>

namespace vdbcloud::app {

/// The project's version, "0.1.0".
std::string project_version();

/// The text of --version: tool and version, OpenVDB and its file format, compiler, codecs.
std::string version_text(const std::string& tool);

}  // namespace vdbcloud::app
