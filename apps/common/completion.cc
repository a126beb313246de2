#include "shared.h"

#include "vdbcloud/core/error.h"

namespace vdbcloud::app {

std::string completion_script(const CLI::App&, const std::string& shell)
{
    throw UsageError("--completion: '" + shell + "': expected bash, zsh or fish");
}

}  // namespace vdbcloud::app
