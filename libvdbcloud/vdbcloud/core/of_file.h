#pragma once
// Errors that say which file they are about.
#include "error.h"

#include <string>

namespace vdbcloud {

/// work(), whose InputError begins with the path: "PATH: MESSAGE". Once is enough: a message that has it stays.
template<typename Work>
auto of_file(const std::string& path, const Work& work)
{
    try {
        return work();
    } catch (const InputError& e) {
        const std::string file = printable(path, 4096) + ": ", message = e.what();
        throw InputError(message.rfind(file, 0) == 0 ? message : file + message);
    }
}

}  // namespace vdbcloud
