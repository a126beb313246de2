#pragma once
// The error for an unusable value, in the common form.
#include "vdbcloud/core/error.h"

#include <sstream>
#include <string>

namespace vdbcloud {

/// Throws InputError "WHAT = VALUE: expected EXPECTED". `what` names the value and its owner. `value` is of any type
/// with operator<<; its text passes through printable().
template<typename T>
[[noreturn]] void refuse(const std::string& what, const T& value, const std::string& expected)
{
    std::ostringstream text;
    text << value;
    throw InputError(what + " = " + printable(text.str()) + ": expected " + expected);
}

}  // namespace vdbcloud
