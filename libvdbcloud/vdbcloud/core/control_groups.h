#pragma once
// The control groups of Linux that bound what this process may use.
#include <string>
#include <vector>

namespace vdbcloud {

/// Folders of the groups that hold this process and have `controller` ("cpu", "memory"), each followed by those that
/// hold it. Both versions of control groups; their files have other names. None where the system has no such groups.
std::vector<std::string> control_groups(const std::string& controller);

}  // namespace vdbcloud
