#include "vdbcloud/core/control_groups.h"

#include <fstream>
#include <sstream>

namespace vdbcloud {

std::vector<std::string> control_groups(const std::string& controller)
{
    std::vector<std::string> folders;
    std::ifstream groups("/proc/self/cgroup");
    for (std::string line; std::getline(groups, line);) {
        std::istringstream fields(line);
        std::string id, controllers, path;
        std::getline(fields, id, ':');
        std::getline(fields, controllers, ':');
        std::getline(fields, path);
        const bool second = controllers.empty();
        if (!second && ("," + controllers + ",").find("," + controller + ",") == std::string::npos) continue;
        const std::string root = second ? "/sys/fs/cgroup" : "/sys/fs/cgroup/" + controllers;
        for (; !path.empty() && path != "/"; path.erase(path.rfind('/'))) folders.push_back(root + path);
        folders.push_back(root);
    }
    return folders;
}

}  // namespace vdbcloud
